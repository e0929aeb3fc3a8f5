/* Stands in for FreeRTOS in .ci/release boards. */
#pragma once
#define pdMS_TO_TICKS(milliseconds) (milliseconds)
