/*
 * Checks that wrong calls change nothing between the steps of a lock or an update. A tracker follows a target in steps, alone and then
 * again with calls of the table after each step, of itself and of a neighbour in the same workspace. Both times it must take the same
 * number of steps, give the same answers, save the same bytes and write the same flight record.
 */

#ifndef BETWEEN_STEPS_H
#define BETWEEN_STEPS_H

#include "wrong_calls.h"

#define FRAMES 5
#define ANSWER (offsetof(smr_answer, found_again) + 1) /* bytes of an answer without the padding at its end */
/* Instead of an index in the table: no call, or up to three of any. */
#define NONE 20000u
#define ANY 30000u

/* All that a tracker does. */
typedef struct course {
    unsigned steps[1 + FRAMES];
    smr_answer answers[FRAMES];
    uint8_t saved[sizeof former];
    size_t size;
    uint8_t record[49152];
    size_t recorded;
} course;

static uint32_t seed;
static uint8_t drawn[1 + FRAMES][WIDTH * HEIGHT];
static target beside;
static course alone, disturbed;

static uint32_t any(void)
{
    seed ^= seed << 13;
    seed ^= seed >> 17;
    seed ^= seed << 5;
    return seed;
}

static void draw(void)
{
    int frame, x, y;
    for (frame = 0; frame <= FRAMES; frame++) {
        for (y = 0; y < HEIGHT; y++) {
            for (x = 0; x < WIDTH; x++) {
                int u = x - 20 - frame, v = y - 15 - frame / 2, inside = u >= 0 && u < 16 && v >= 0 && v < 14;
                drawn[frame][y * WIDTH + x] = (uint8_t)(inside ? (u / 4 * 83 + v / 4 * 47) % 251 : 90 + (x / 9 * 5 + y / 9 * 3) % 30);
            }
        }
    }
}

static smr_frame drawn_frame(unsigned number)
{
    smr_frame frame = good_frame();
    frame.parts[0].pixels = drawn[number];
    return frame;
}

static int32_t write_record(void *context, const uint8_t *record, size_t count)
{
    course *made = (course *)context;
    if (count > sizeof made->record - made->recorded) {
        return 1;
    }
    memcpy(made->record + made->recorded, record, count);
    made->recorded += count;
    return 0;
}

/* Makes wrong calls on the tracker or, in one of three cases, on a neighbour in the same workspace. */
static void between(unsigned chosen, smr_tracker *tracker, smr_tracker *neighbour, const smr_frame *now, int is_locked)
{
    unsigned count = chosen == ANY ? any() % 4 : chosen != NONE;
    unsigned rows = chosen == ANY ? wrong_calls(tracker, now, is_locked, NONE) : 1;
    while (count-- > 0) {
        unsigned row = chosen == ANY ? any() % rows : chosen;
        if (any() % 3 == 0) {
            wrong_calls(neighbour, now, 1, row);
        } else {
            wrong_calls(tracker, now, is_locked, row);
        }
    }
}

static void follow(course *made, uint32_t locking, uint32_t updating, unsigned chosen)
{
    smr_config config = good_config();
    smr_tracker *tracker = good_tracker(), *neighbour = tracker_in(&beside, &config);
    smr_frame frame = drawn_frame(0);
    smr_rect box = rect(20, 15, 16, 14);
    smr_recorder recorder;
    smr_status status;
    unsigned number;
    memset(made, 0, sizeof *made);
    memset(&recorder, 0, sizeof recorder);
    recorder.write = write_record;
    recorder.context = made;
    EXPECT(smr_record(tracker, &recorder), SMR_OK);
    EXPECT(smr_lock(neighbour, &frame, &box), SMR_OK);
    do {
        status = smr_lock_step(tracker, &frame, &box, locking);
        between(chosen, tracker, neighbour, &frame, status == SMR_OK);
    } while (status == SMR_UNDER_WAY && ++made->steps[0] < 10000);
    EXPECT(status, SMR_OK);
    for (number = 1; number <= FRAMES; number++) {
        frame = drawn_frame(number);
        do {
            status = smr_update_step(tracker, &frame, updating, &made->answers[number - 1]);
            between(chosen, tracker, neighbour, &frame, 1);
        } while (status == SMR_UNDER_WAY && ++made->steps[number] < 10000);
        EXPECT(status, SMR_OK);
    }
    EXPECT(smr_save(tracker, made->saved, sizeof made->saved, &made->size), SMR_OK);
    /* A begin and a lock, then a window and an answer of each frame. */
    HOLD(recorder.failed == 0 && recorder.entries == 2 + 2 * FRAMES);
}

/* The tracker takes the same number of steps with wrong calls as alone, gives the same answers, saves and records the same bytes. */
static int is_undisturbed(uint32_t locking, uint32_t updating, unsigned chosen)
{
    unsigned number;
    int is_same;
    follow(&disturbed, locking, updating, chosen);
    is_same = memcmp(alone.steps, disturbed.steps, sizeof alone.steps) == 0;
    for (number = 0; number < FRAMES; number++) {
        is_same &= memcmp(&alone.answers[number], &disturbed.answers[number], ANSWER) == 0;
    }
    return is_same && alone.size == disturbed.size && memcmp(alone.saved, disturbed.saved, alone.size) == 0 &&
           alone.recorded == disturbed.recorded && memcmp(alone.record, disturbed.record, alone.recorded) == 0;
}

static void between_steps(unsigned long runs)
{
    /* Work of a step. An update takes some thousand units of the paper tracker, and 3,000,000 of the robust one. */
    uint32_t most = robust ? 1000000 : 1000;
    smr_frame frame = good_frame();
    unsigned rows = wrong_calls(locked_tracker(), &frame, 1, NONE), row;
    while (runs-- > 0) {
        uint32_t locking = most / 8 + any() % most, updating = most / 8 + any() % most;
        follow(&alone, locking, updating, NONE);
        HOLD(is_undisturbed(locking, updating, ANY));
    }
    follow(&alone, most, most, NONE);
    HOLD(alone.steps[1] > 0);
    if (!is_undisturbed(most, most, ALL)) {
        for (row = 0; row < rows; row++) {
            if (!is_undisturbed(most, most, row)) {
                fprintf(stderr, "%s: call %u of the table has changed something\n", robust ? "robust" : "paper", row);
            }
        }
        HOLD(!"wrong calls between steps have changed something");
    }
}

#endif
