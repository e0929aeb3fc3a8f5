/* Stands in for FreeRTOS in .ci/boards. */
#pragma once
#define pdMS_TO_TICKS(milliseconds) (milliseconds)
