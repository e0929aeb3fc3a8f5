/* Stands in for the Servo library: refuses an angle that a servo does not have. */
#pragma once
#include <stdlib.h>
struct Servo {
  void attach(int) {}
  void write(int angle) { if (angle < 0 || angle > 180) abort(); }
};
