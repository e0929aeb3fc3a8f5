/*
 * The part of OpenMV's imlib.h that its template.c needs. openmv.c has the integral images, in static memory.
 */

#ifndef IMLIB_H
#define IMLIB_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#define fast_sqrtf sqrtf

typedef struct point {
    int16_t x, y;
} point_t;

typedef struct rectangle {
    int16_t x, y, w, h;
} rectangle_t;

typedef struct image {
    int32_t w, h;
    uint8_t *data;
} image_t;

/* Sums of the pixels, or of their squares, above and left of each position; the first row and column are zeros. */
typedef struct integral_image {
    int w;
    uint32_t *sums;
} i_image_t;

void imlib_integral_image_alloc(i_image_t *, int w, int h);
void imlib_integral_image_free(i_image_t *);
void imlib_integral_image(image_t *, i_image_t *);
void imlib_integral_image_sq(image_t *, i_image_t *);
uint32_t imlib_integral_lookup(i_image_t *, int x, int y, int w, int h);
void imlib_image_mean(image_t *, int *r, int *g, int *b);

float imlib_template_match_ds(image_t *, image_t *, rectangle_t *);
float imlib_template_match_ex(image_t *, image_t *, rectangle_t *roi, int step, rectangle_t *);

#endif
