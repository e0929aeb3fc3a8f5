/* Stands in for the tasks of FreeRTOS: after LOOPS delays the program ends. */
#pragma once
#include <stdlib.h>
static inline void vTaskDelay(unsigned ticks)
{
  static int delays;
  (void)ticks;
  if (++delays == LOOPS) exit(0);
}

void app_main(void);
int main(void)
{
  app_main();
  return 1;
}
