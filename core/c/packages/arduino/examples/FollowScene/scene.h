/*
 * A scene in place of a camera, for C and C++: a bright square moves to and fro over a dim background, and hides for a moment in every
 * round. draw() fills `pixels` with the picture of frame number `frame`.
 */
#ifndef SCENE_H
#define SCENE_H

#include <stdint.h>

enum { WIDTH = 96, HEIGHT = 72, SIDE = 16, ROUND = 60 };
static uint8_t pixels[WIDTH * HEIGHT];
static int frame = 0;

/* The gray level at (x, y) of a texture that does not repeat. */
static uint8_t noise(uint32_t seed, int x, int y)
{
  uint32_t n = seed + (uint32_t)x * 374761393u + (uint32_t)y * 668265263u;
  n = (n ^ (n >> 13)) * 1274126177u;
  return (uint8_t)(n ^ (n >> 16));
}

/* Position of the square: it moves right for half a round, then left. */
static int left(void) { return 10 + (frame % ROUND < ROUND / 2 ? frame % ROUND : ROUND - frame % ROUND) * 2; }
static int top(void) { return 20 + left() / 4; }
static int in_view(void) { return frame % ROUND < 40 || frame % ROUND >= 48; }

static void draw(void)
{
  for (int y = 0; y < HEIGHT; y++) {
    for (int x = 0; x < WIDTH; x++) {
      int u = x - left(), v = y - top();
      int inside = in_view() && u >= 0 && u < SIDE && v >= 0 && v < SIDE;
      pixels[y * WIDTH + x] = inside ? 128 + noise(1, u / 3, v / 3) / 2 : noise(2, x / 4, y / 4) / 4 + noise(3 + frame, x, y) / 32;
    }
  }
}

#endif
