/*
 * Interface of each program in this folder: lock() learns a target of 64x64 pixels; find() searches a window that
 * reaches 16 pixels beyond the target's last place on each side.
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

/* Returns the target's place in the window. `last` is its place in the previous frame, relative to the same window. */
place find(window, place last);

#endif
