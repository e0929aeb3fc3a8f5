/*
 * Firmware that follows a target through frames.bin with lock() and find(), and writes the target's places to
 * places.txt. `smr-qemu --cycles` estimates the cycles of the code between two calls of smr_ticks.
 */

#include "follow.h"

#include <stdio.h>
#include <string.h>

#define MAX_PIXELS (640 * 480)

/* Number of frames to read; later ones are ignored. */
#ifndef MAX
#define MAX UINT16_MAX
#endif

static uint8_t frame[MAX_PIXELS], pixels[WINDOW * WINDOW];

__attribute__((noinline)) void smr_ticks(void)
{
    __asm__ volatile("" ::: "memory");
}

static int least(int a, int b)
{
    return a < b ? a : b;
}

/* Copies the window around `at` from the frame. `corner` gets the place of its top left pixel in the frame. */
static window cut(int width, int height, place at, place *corner)
{
    *corner = (place){at.x < REACH ? 0 : at.x - REACH, at.y < REACH ? 0 : at.y - REACH};
    window cut = {pixels, least(width, at.x + SIDE + REACH) - corner->x, least(height, at.y + SIDE + REACH) - corner->y};
    for (int y = 0; y < cut.height; y++)
        memcpy(pixels + y * cut.width, frame + (corner->y + y) * width + corner->x, (size_t)cut.width);
    return cut;
}

int main(void)
{
    /* Width, height and number of the frames; column and row of the target's top left pixel in the first frame. */
    uint16_t header[5];
    FILE *in = fopen("frames.bin", "rb"), *out = fopen("places.txt", "w");
    if (!in || !out || fread(header, sizeof header, 1, in) != 1)
        return 1;
    const size_t size = (size_t)header[0] * header[1];
    place at = {header[3], header[4]};
    if (size > MAX_PIXELS)
        return 1;
    for (int number = 0; number < least(header[2], MAX); number++) {
        if (fread(frame, size, 1, in) != 1)
            return 1;
        place corner;
        const window window = cut(header[0], header[1], at, &corner);
        place last = {at.x - corner.x, at.y - corner.y};
        smr_ticks();
        if (number == 0)
            lock(window, last);
        else
            last = find(window, last);
        smr_ticks();
        at = (place){corner.x + last.x, corner.y + last.y};
        fprintf(out, "%d %d\n", at.x, at.y);
    }
    return fclose(out);
}
