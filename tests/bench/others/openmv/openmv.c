/*
 * Search of the window by OpenMV's find_template, from OpenMV's template.c, which is linked with this file. If DIAMOND
 * is 1, it is the search of image.SEARCH_DS, which begins in the middle of the window; if 0, that of image.SEARCH_EX.
 */

#include "imlib.h"

#include "../follow.h"

#include <string.h>

static uint8_t target[SIDE * SIDE];
static uint32_t memory[2][(WINDOW + 1) * (WINDOW + 1)];
static unsigned in_use;

void imlib_integral_image_alloc(i_image_t *sums, int w, int h)
{
    (void)h;
    *sums = (i_image_t){w + 1, memory[in_use++]};
}

void imlib_integral_image_free(i_image_t *sums)
{
    (void)sums;
    in_use--;
}

static inline void integral(const image_t *image, const i_image_t *into, bool squares)
{
    memset(into->sums, 0, (size_t)into->w * sizeof *into->sums);
    for (int y = 0; y < image->h; y++) {
        const uint8_t *row = image->data + y * image->w;
        uint32_t *above = into->sums + y * into->w, *sums = above + into->w, sum = 0;
        *sums = 0;
        for (int x = 0; x < image->w; x++) {
            sum += squares ? row[x] * row[x] : row[x];
            sums[x + 1] = above[x + 1] + sum;
        }
    }
}

void imlib_integral_image(image_t *image, i_image_t *into)
{
    integral(image, into, false);
}

void imlib_integral_image_sq(image_t *image, i_image_t *into)
{
    integral(image, into, true);
}

uint32_t imlib_integral_lookup(i_image_t *of, int x, int y, int w, int h)
{
    const uint32_t *above = of->sums + y * of->w + x, *below = above + h * of->w;
    return below[w] - below[0] - above[w] + above[0];
}

void imlib_image_mean(image_t *image, int *r, int *g, int *b)
{
    int sum = 0;
    for (int i = 0; i < image->w * image->h; i++)
        sum += image->data[i];
    *r = *g = *b = sum / (image->w * image->h);
}

void lock(window in, place at)
{
    for (int y = 0; y < SIDE; y++)
        memcpy(target + y * SIDE, in.pixels + (at.y + y) * in.width + at.x, SIDE);
}

place find(window in, place last)
{
    image_t image = {in.width, in.height, (uint8_t *)in.pixels}, pattern = {SIDE, SIDE, target};
    rectangle_t roi = {0, 0, (int16_t)in.width, (int16_t)in.height}, found = {(int16_t)last.x, (int16_t)last.y, SIDE, SIDE};
    if (DIAMOND)
        imlib_template_match_ds(&image, &pattern, &found);
    else
        imlib_template_match_ex(&image, &pattern, &roi, 1, &found);
    return (place){found.x, found.y};
}
