/* The scene of the simulated cameras: a bright square on a dim pattern, in 320x240 pixels. It moves right by two pixels per picture. */
#pragma once

/* The gray level of a pixel, 0 to 31, in picture `number`. */
static inline int square_level(int x, int y, int number)
{
  int u = x - 136 - number * 2, v = y - 96;
  int inside = u >= 0 && u < 48 && v >= 0 && v < 48;
  return inside ? 16 + (u / 6 * 7 + v / 6 * 11 + u / 6 * (v / 6) * 5) % 16 : (x / 8 * 5 + y / 8 * 3 + x / 8 * (y / 8)) % 8;
}
