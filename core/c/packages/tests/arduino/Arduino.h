/* Stands in for the Arduino core in the test `.ci/release boards`: the functions that the sketches call, and a main that calls loop() LOOPS times. */
#pragma once
#include <stdint.h>
#include <stdio.h>

struct Stream {
  void begin(long) {}
  void print(const char *text) { printf("%s", text); }
  void print(int number) { printf("%d", number); }
  void println(const char *text) { printf("%s\n", text); }
  void println(int number) { printf("%d\n", number); }
  // At the start, one character waits to be read.
  int available() { return waiting; }
  int read() { return waiting-- ? 'x' : -1; }
  int waiting = 1;
};
static Stream Serial;

inline void delay(unsigned long) {}

void setup();
void loop();

#ifdef LOOPS
int main()
{
  setup();
  for (int i = 0; i < LOOPS; i++) loop();
  return 0;
}
#endif
