/*
 * MOSSE (Bolme et al., CVPR 2010) in single precision on 64x64 pixels, with the parameters of mckaydm/openmv_mosse, but
 * not its training at the start. Input: logarithm, zero mean, unit deviation, Hann window. Filter: A/B; after a search,
 * A and B learn the pixels at the response's peak. An update has three complex FFTs, as in openmv_mosse; FFTs of real
 * input could take half the time.
 */

#include "follow.h"

#include <math.h>

#define PIXELS (SIDE * SIDE)
#define LEARNING_RATE 0.125f
#define MIN_B 1.0f
#define TWO_SIGMA_SQUARED 100.0f

typedef struct complex_number {
    float re, im;
} complex_number;

static complex_number turns[SIDE], wanted[PIXELS], a[PIXELS], spectrum[PIXELS];
static float b[PIXELS], hann[SIDE], logarithm[256];

static inline complex_number plus(complex_number p, complex_number q)
{
    return (complex_number){p.re + q.re, p.im + q.im};
}

static inline complex_number minus(complex_number p, complex_number q)
{
    return (complex_number){p.re - q.re, p.im - q.im};
}

static inline complex_number times(complex_number p, complex_number q)
{
    return (complex_number){p.re * q.re - p.im * q.im, p.re * q.im + p.im * q.re};
}

/* p times the conjugate of q. */
static inline complex_number back(complex_number p, complex_number q)
{
    return (complex_number){p.re * q.re + p.im * q.im, p.im * q.re - p.re * q.im};
}

/* p times -i. */
static inline complex_number right(complex_number p)
{
    return (complex_number){p.im, -p.re};
}

/* A radix-4 FFT. It leaves the frequencies in digit-reversed order (base 4), which inverse() expects. */
static void forward(complex_number *x, int step)
{
    for (int quarter = SIDE / 4; quarter > 0; quarter /= 4) {
        for (int j = 0, turn = SIDE / 4 / quarter; j < quarter; j++) {
            for (int i = j; i < SIDE; i += 4 * quarter) {
                complex_number *p = x + i * step, *q = p + quarter * step, *r = q + quarter * step, *s = r + quarter * step;
                const complex_number even = plus(*p, *r), odd = minus(*p, *r);
                const complex_number sum = plus(*q, *s), difference = right(minus(*q, *s));
                *p = plus(even, sum);
                *q = plus(odd, difference);
                *r = minus(even, sum);
                *s = minus(odd, difference);
                if (j > 0) {
                    *q = times(*q, turns[j * turn]);
                    *r = times(*r, turns[2 * j * turn]);
                    *s = times(*s, turns[3 * j * turn]);
                }
            }
        }
    }
}

/* Inverse of forward(), by its steps in reverse order; the values become 64 times as large. */
static void inverse(complex_number *x, int step)
{
    for (int quarter = 1; quarter < SIDE; quarter *= 4) {
        for (int j = 0, turn = SIDE / 4 / quarter; j < quarter; j++) {
            for (int i = j; i < SIDE; i += 4 * quarter) {
                complex_number *p = x + i * step, *q = p + quarter * step, *r = q + quarter * step, *s = r + quarter * step;
                if (j > 0) {
                    *q = back(*q, turns[j * turn]);
                    *r = back(*r, turns[2 * j * turn]);
                    *s = back(*s, turns[3 * j * turn]);
                }
                const complex_number even = plus(*p, *r), sum = minus(*p, *r);
                const complex_number odd = plus(*q, *s), difference = right(minus(*q, *s));
                *p = plus(even, odd);
                *q = minus(sum, difference);
                *r = minus(even, odd);
                *s = plus(sum, difference);
            }
        }
    }
}

static void both_ways(complex_number *image, void transform(complex_number *, int))
{
    for (int i = 0; i < SIDE; i++)
        transform(image + i * SIDE, 1);
    for (int i = 0; i < SIDE; i++)
        transform(image + i, SIDE);
}

/* Computes `spectrum` from the 64x64 pixels at `at` in the window. */
static void see(window in, place at)
{
    float sum = 0, squares = 0;
    for (int i = 0; i < PIXELS; i++) {
        const float value = logarithm[in.pixels[(at.y + i / SIDE) * in.width + at.x + i % SIDE]];
        spectrum[i].re = value;
        sum += value;
        squares += value * value;
    }
    const float mean = sum / PIXELS, scale = 1 / (sqrtf(squares / PIXELS - mean * mean) + 1e-5f);
    for (int i = 0; i < PIXELS; i++)
        spectrum[i] = (complex_number){(spectrum[i].re - mean) * scale * hann[i / SIDE] * hann[i % SIDE], 0};
    both_ways(spectrum, forward);
}

static void learn(float rate)
{
    for (int i = 0; i < PIXELS; i++) {
        const complex_number f = spectrum[i], seen = back(wanted[i], f);
        a[i].re += rate * (seen.re - a[i].re);
        a[i].im += rate * (seen.im - a[i].im);
        b[i] += rate * (f.re * f.re + f.im * f.im - b[i]);
    }
}

void lock(window in, place at)
{
    const float pi = 3.14159265f;
    for (int i = 0; i < SIDE; i++) {
        turns[i] = (complex_number){cosf(2 * pi * (float)i / SIDE), -sinf(2 * pi * (float)i / SIDE)};
        hann[i] = 0.5f - 0.5f * cosf(2 * pi * (float)i / (SIDE - 1));
    }
    for (int i = 0; i < 256; i++)
        logarithm[i] = logf((float)(i + 1));
    for (int i = 0; i < PIXELS; i++) {
        const int x = i % SIDE - SIDE / 2, y = i / SIDE - SIDE / 2;
        wanted[i] = (complex_number){expf((float)-(x * x + y * y) / TWO_SIGMA_SQUARED), 0};
    }
    both_ways(wanted, forward);
    see(in, at);
    learn(1);
}

static int within(int value, int most)
{
    return value < 0 ? 0 : value > most ? most : value;
}

place find(window in, place last)
{
    see(in, last);
    for (int i = 0; i < PIXELS; i++) {
        const complex_number response = times(a[i], spectrum[i]);
        const float scale = 1 / (b[i] + MIN_B);
        spectrum[i] = (complex_number){response.re * scale, response.im * scale};
    }
    both_ways(spectrum, inverse);
    int peak = 0;
    for (int i = 1; i < PIXELS; i++) {
        if (spectrum[i].re > spectrum[peak].re)
            peak = i;
    }
    place at = {last.x + peak % SIDE - SIDE / 2, last.y + peak / SIDE - SIDE / 2};
    at = (place){within(at.x, in.width - SIDE), within(at.y, in.height - SIDE)};
    see(in, at);
    learn(LEARNING_RATE);
    return at;
}
