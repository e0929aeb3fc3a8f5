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
  // In base 16, the only one that a sketch asks for; core/c/tests/xtensa/libc.c has no %x.
  void println(int number, int)
  {
    char text[9] = {};
    int first = 8;
    unsigned rest = static_cast<unsigned>(number);
    do text[--first] = "0123456789ABCDEF"[rest % 16];
    while ((rest /= 16) != 0);
    println(text + first);
  }
  // At the start, a character and the end of its line wait to be read.
  int available() { return waiting; }
  int read() { return waiting > 0 ? "\n\rx"[--waiting] : -1; }
  int waiting = 3;
};
static Stream Serial;
enum { HEX = 16 };

inline void delay(unsigned long) {}
inline unsigned long millis()
{
  static unsigned long passed = 0;
  return passed += 500;
}

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
