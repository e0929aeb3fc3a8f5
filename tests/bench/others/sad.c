/*
 * Hand-written search of all offsets for the least sum of absolute differences. An instruction adds four pixels on a
 * Cortex-M4 (USADA8), 16 on a Cortex-M55 (VABAV). With STOP, an offset is given up in the row in which its sum is no
 * longer the least.
 */

#include "follow.h"

#include <limits.h>
#include <string.h>

#ifdef __ARM_FEATURE_MVE
#include <arm_mve.h>

static inline uint32_t row(uint32_t sum, const uint8_t *f, const uint8_t *g)
{
#pragma GCC unroll 4
    for (int x = 0; x < SIDE; x += 16)
        sum = vabavq_u8(sum, vld1q_u8(f + x), vld1q_u8(g + x));
    return sum;
}
#else
#include <arm_acle.h>

static inline uint32_t word(const uint8_t *pixels)
{
    uint32_t word;
    memcpy(&word, pixels, sizeof word);
    return word;
}

static inline uint32_t row(uint32_t sum, const uint8_t *f, const uint8_t *g)
{
#pragma GCC unroll 16
    for (int x = 0; x < SIDE; x += 4)
        sum = __usada8(word(f + x), word(g + x), sum);
    return sum;
}
#endif

static uint8_t target[SIDE * SIDE] __attribute__((aligned(16)));

void lock(window in, place at)
{
    for (int y = 0; y < SIDE; y++)
        memcpy(target + y * SIDE, in.pixels + (at.y + y) * in.width + at.x, SIDE);
}

static uint32_t sum_at(window in, place at, uint32_t least)
{
    const uint8_t *f = in.pixels + at.y * in.width + at.x;
    uint32_t sum = 0;
    for (const uint8_t *g = target; g < target + sizeof target; g += SIDE, f += in.width) {
        sum = row(sum, f, g);
        if (STOP && sum >= least)
            break;
    }
    return sum;
}

place find(window in, place last)
{
    /* The target mostly moves little: with STOP, the small sum at its last place makes other offsets end early. */
    place best = last;
    uint32_t least = STOP ? sum_at(in, last, UINT_MAX) : UINT_MAX;
    for (int y = 0; y <= in.height - SIDE; y++) {
        for (int x = 0; x <= in.width - SIDE; x++) {
            const uint32_t sum = sum_at(in, (place){x, y}, least);
            if (sum < least) {
                least = sum;
                best = (place){x, y};
            }
        }
    }
    return best;
}
