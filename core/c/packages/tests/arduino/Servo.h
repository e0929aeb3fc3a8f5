/* Stands in for the Servo library: aborts at an angle outside 0 to 180 degrees. */
#pragma once
#include <stdlib.h>
struct Servo {
  void attach(int) {}
  void write(int angle) { if (angle < 0 || angle > 180) abort(); }
};
