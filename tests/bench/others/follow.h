/*
 * The interface of each program in this folder: a target of 64x64 is locked, then found in the window around its last place, +-16 pixels.
 */

#ifndef FOLLOW_H
#define FOLLOW_H

#include <stdint.h>

#define SIDE 64
#define REACH 16
#define WINDOW (SIDE + 2 * REACH)

/* Column and row of the top left pixel of a target or a window. */
typedef struct place {
    int x, y;
} place;

/* A search window, cut off at the frame's edge. The benchmark copies the window's rows without gaps, and does not measure the copy. */
typedef struct window {
    const uint8_t *pixels;
    int width, height;
} window;

/* Learns the target, whose place in the window is `at`. */
void lock(window, place at);

/* Returns the target's place in the window; `last` is its place in the frame before, in the same window. */
place find(window, place last);

#endif
