/* Stands in for FreeRTOS in the test `.ci/release boards`. */
#pragma once
#define pdMS_TO_TICKS(milliseconds) (milliseconds)
