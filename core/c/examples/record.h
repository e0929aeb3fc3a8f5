/* A flight recorder in C: writes all that a tracker sees and answers as bytes. `host-sim replay FILE` runs them again.
 *
 * The documentation of smr_core::record describes every byte (version 1). Copy this file next to your firmware; it needs only smr.h. Set
 * `write` to a function that stores the bytes (in flash, a file, over a serial line) and returns 0 if that succeeds. After an error the
 * recorder writes nothing more and sets `failed`.
 *
 *     smr_recorder recorder = {to_flash, 0, 0, 0, 0};
 *     smr_record_begin(&recorder, &config);
 *     smr_record_lock(&recorder, tracker, &frame, &target);   after smr_lock
 *     smr_record_window(&recorder, tracker, &frame);          before smr_update or smr_begin
 *     smr_record_answer(&recorder, &answer);                  after smr_update or smr_finish
 *     smr_record_moved(&recorder, right, down);               with smr_moved
 *     smr_record_restored(&recorder, saved, size);            after smr_restore
 */
#ifndef SMR_RECORD_H
#define SMR_RECORD_H

#include "smr.h"

/* No warning in C99 or C++ about functions that you do not call. */
#if defined(__GNUC__)
#define SMR_RECORD __attribute__((unused)) static
#else
#define SMR_RECORD static
#endif

typedef struct {
    int (*write)(void *context, const uint8_t *bytes, size_t size);
    void *context;
    uint32_t entries;
    uint32_t sum;
    int failed;
} smr_recorder;

SMR_RECORD void smr_record_put(smr_recorder *to, const uint8_t *bytes, size_t size) {
    static const uint32_t table[16] = {
        0x00000000, 0x1DB71064, 0x3B6E20C8, 0x26D930AC, 0x76DC4190, 0x6B6B51F4, 0x4DB26158, 0x5005713C,
        0xEDB88320, 0xF00F9344, 0xD6D6A3E8, 0xCB61B38C, 0x9B64C2B0, 0x86D3D2D4, 0xA00AE278, 0xBDBDF21C,
    };
    size_t at;
    for (at = 0; at < size; at++) {
        to->sum ^= bytes[at];
        to->sum = (to->sum >> 4) ^ table[to->sum & 15];
        to->sum = (to->sum >> 4) ^ table[to->sum & 15];
    }
    if (!to->failed && size > 0 && to->write(to->context, bytes, size) != 0) {
        to->failed = 1;
    }
}

SMR_RECORD void smr_record_u16(smr_recorder *to, uint32_t number) {
    uint8_t bytes[2];
    bytes[0] = (uint8_t)number;
    bytes[1] = (uint8_t)(number >> 8);
    smr_record_put(to, bytes, 2);
}

SMR_RECORD void smr_record_u32(smr_recorder *to, uint32_t number) {
    smr_record_u16(to, number & 0xFFFF);
    smr_record_u16(to, number >> 16);
}

SMR_RECORD void smr_record_head(smr_recorder *to, const char *tag, uint32_t length) {
    to->sum = 0xFFFFFFFF;
    smr_record_put(to, (const uint8_t *)tag, 4);
    smr_record_u32(to, to->entries++);
    smr_record_u32(to, length);
}

SMR_RECORD void smr_record_end(smr_recorder *to) {
    smr_record_u32(to, ~to->sum);
}

SMR_RECORD void smr_record_rect(smr_recorder *to, const smr_rect *rect) {
    smr_record_u16(to, (uint32_t)rect->x);
    smr_record_u16(to, (uint32_t)rect->y);
    smr_record_u16(to, rect->width);
    smr_record_u16(to, rect->height);
}

/* The part in memory that contains all of `rect`; NULL if there is none. */
SMR_RECORD const smr_part *smr_record_part(const smr_frame *frame, const smr_rect *rect) {
    int at;
    for (at = 0; at < 2; at++) {
        const smr_part *part = &frame->parts[at];
        if (part->pixels != NULL && rect->x >= part->x && rect->y >= part->y
            && rect->x + rect->width <= part->x + part->width && rect->y + rect->height <= part->y + part->height) {
            return part;
        }
    }
    return NULL;
}

SMR_RECORD void smr_record_pixels(smr_recorder *to, const smr_frame *frame, const smr_rect *rect) {
    const smr_part *part = smr_record_part(frame, rect);
    int32_t row;
    for (row = 0; part != NULL && row < rect->height; row++) {
        size_t below = (size_t)(rect->y + row - part->y);
        smr_record_put(to, part->pixels + below * part->stride + (size_t)(rect->x - part->x), rect->width);
    }
}

/* Begins a record: the tracker and its configuration. */
SMR_RECORD void smr_record_begin(smr_recorder *to, const smr_config *config) {
    const smr_paper_config *paper = &config->paper;
    const smr_robust_config *robust = &config->robust;
    int is_robust = paper->k.denominator == 0; /* smr_config_robust sets the paper's numbers to 0 */
    const uint16_t *similarities = smr_similarities();
    int at;
    to->entries = 0;
    smr_record_head(to, "SMRB", 4 + 2 * (uint32_t)(is_robust ? 268 + (robust->refiner != 0) : 282));
    smr_record_u16(to, 1);
    smr_record_u16(to, is_robust ? 'R' : 'P');
    for (at = 0; at < 256; at++) {
        smr_record_u16(to, similarities[at]);
    }
    if (is_robust) {
        const uint32_t numbers[12] = {
            robust->size != 0, robust->sweep != 0, 1, 1, 1, 1, robust->reach, robust->patience,
            robust->lost_below, robust->uncertain_below, robust->learning_rate, robust->early_rate,
        };
        for (at = 0; at < 12; at++) {
            smr_record_u16(to, numbers[at]);
        }
        if (robust->refiner != 0) {
            smr_record_u16(to, 1);
        }
    } else {
        const uint32_t numbers[26] = {
            paper->k.numerator, paper->k.denominator, paper->gate_tracking.numerator, paper->gate_tracking.denominator,
            paper->gate_leaving.numerator, paper->gate_leaving.denominator, paper->gate_returning.numerator, paper->gate_returning.denominator,
            paper->gate_lost.numerator, paper->gate_lost.denominator, paper->gate_lead, paper->least_ratio,
            paper->first_threshold, paper->least_threshold, paper->padding, paper->window.x, paper->window.y,
            paper->growth, paper->window_limit.x, paper->window_limit.y, paper->neighbourhood,
            paper->runner_up_always != 0, paper->update_zone.left, paper->update_zone.top,
            paper->update_zone.right, paper->update_zone.bottom,
        };
        for (at = 0; at < 26; at++) {
            smr_record_u16(to, numbers[at]);
        }
    }
    smr_record_end(to);
}

/* Call it after smr_lock, with the same arguments. */
SMR_RECORD void smr_record_lock(smr_recorder *to, const smr_tracker *tracker, const smr_frame *frame, const smr_rect *target) {
    smr_rect window;
    if (to->failed || smr_lock_window(tracker, frame->width, frame->height, target, &window) != SMR_OK) {
        return;
    }
    smr_record_head(to, "SMRL", 20 + (uint32_t)window.width * window.height);
    smr_record_u16(to, frame->width);
    smr_record_u16(to, frame->height);
    smr_record_rect(to, target);
    smr_record_rect(to, &window);
    smr_record_pixels(to, frame, &window);
    smr_record_end(to);
}

/* Call it before the update. It writes nothing if the frame does not contain the pixels that the tracker needs. */
SMR_RECORD void smr_record_window(smr_recorder *to, const smr_tracker *tracker, const smr_frame *frame) {
    const smr_rect nothing = {0, 0, 0, 0};
    smr_rect windows[2], near_by, sweep;
    if (to->failed || smr_windows(tracker, windows) != SMR_OK) {
        return;
    }
    near_by = windows[0];
    sweep = windows[1];
    if (near_by.width == 0 || near_by.height == 0) near_by = nothing;
    if (sweep.width == 0 || sweep.height == 0) sweep = nothing;
    if ((near_by.width > 0 && smr_record_part(frame, &near_by) == NULL)
        || (sweep.width > 0 && smr_record_part(frame, &sweep) == NULL)) {
        return;
    }
    smr_record_head(to, "SMRW", 20 + (uint32_t)near_by.width * near_by.height + (uint32_t)sweep.width * sweep.height);
    smr_record_u16(to, frame->width);
    smr_record_u16(to, frame->height);
    smr_record_rect(to, &near_by);
    smr_record_rect(to, &sweep);
    if (near_by.width > 0) smr_record_pixels(to, frame, &near_by);
    if (sweep.width > 0) smr_record_pixels(to, frame, &sweep);
    smr_record_end(to);
}

SMR_RECORD void smr_record_answer(smr_recorder *to, const smr_answer *answer) {
    uint32_t flags = (answer->found_again ? 1 : 0) | (answer->has_runner_up ? 2 : 0) | (answer->alpha ? 4 : 0);
    if (to->failed) return;
    smr_record_head(to, "SMRA", 30);
    smr_record_u32(to, (uint32_t)answer->fine.x);
    smr_record_u32(to, (uint32_t)answer->fine.y);
    smr_record_u32(to, answer->fine.width);
    smr_record_u32(to, answer->fine.height);
    smr_record_u16(to, (uint32_t)answer->state | flags << 8);
    smr_record_u16(to, answer->confidence);
    smr_record_u16(to, answer->ratio);
    smr_record_u16(to, answer->has_runner_up ? answer->runner_up_ratio : 0);
    smr_record_u16(to, answer->alpha);
    smr_record_u32(to, answer->scale);
    smr_record_end(to);
}

SMR_RECORD void smr_record_moved(smr_recorder *to, int32_t right, int32_t down) {
    if (to->failed) return;
    smr_record_head(to, "SMRM", 8);
    smr_record_u32(to, (uint32_t)right);
    smr_record_u32(to, (uint32_t)down);
    smr_record_end(to);
}

SMR_RECORD void smr_record_restored(smr_recorder *to, const uint8_t *saved, size_t size) {
    if (to->failed) return;
    smr_record_head(to, "SMRS", (uint32_t)size);
    smr_record_put(to, saved, size);
    smr_record_end(to);
}

#endif
