/*
 * The interface of each program in this folder: a target of 64x64 is locked, then found in the window around its last place, +-16 pixels.
 */

#ifndef FOLLOW_H
#define FOLLOW_H

#include <stdint.h>

#define SIDE 64
#define REACH 16
#define WINDOW (SIDE + 2 * REACH)

/* Column and row. */
typedef struct place {
    int x, y;
} place;

/* A window that the frame's edge has cut, perhaps. Its rows lie one after the other, which is free for all. */
typedef struct window {
    const uint8_t *pixels;
    int width, height;
} window;

/* Takes the target at `at`. */
void lock(window, place at);

/* Where the target is now; it was at `last`. */
place find(window, place last);

#endif
