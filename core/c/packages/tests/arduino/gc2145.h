/* Stands in for the sensor of the Nicla Vision. */
#pragma once
class GC2145 : public ImageSensor {};
