/* Stands in for the library of the GC2145, the Nicla Vision's sensor. */
#pragma once
class GC2145 : public ImageSensor {};
