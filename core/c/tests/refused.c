/*
 * Checks that a refused call changes nothing, also between the steps of a lock or an update. A tracker follows a target in steps, alone
 * and then again with refused calls after each step, of itself and of a neighbour in the same workspace. Both times it must take the
 * same number of steps, give the same answers, save the same bytes and write the same flight record.
 *
 * refused [RUNS [SEED]]
 */

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "smr.h"

#define WIDTH 60
#define HEIGHT 50
#define FRAMES 5
#define KINDS 28
#define ANSWER (offsetof(smr_answer, found_again) + 1) /* bytes of an answer without the padding at its end */

typedef union target {
    smr_paper_target paper;
    smr_robust_target robust;
} target;

typedef union workspace {
    smr_paper_workspace paper;
    smr_robust_workspace robust;
} workspace;

/* All that a tracker does. */
typedef struct course {
    unsigned steps[1 + FRAMES];
    smr_answer answers[FRAMES];
    uint8_t saved[SMR_PAPER_SAVED_SIZE + SMR_ROBUST_SAVED_SIZE];
    size_t size;
    uint8_t record[65536];
    size_t recorded;
} course;

static int robust; /* the tracker under test */
static uint32_t seed;
static unsigned refusals, steps;
static target storage, beside;
static workspace scratch;
static uint8_t pixels[1 + FRAMES][WIDTH * HEIGHT];
static uint8_t former[SMR_PAPER_SAVED_SIZE + SMR_ROBUST_SAVED_SIZE]; /* a saved target */
static size_t former_size;
static course alone, disturbed;

static const smr_rect bbox = {20, 15, 16, 14}, outside = {50, 40, 16, 14}, empty = {5, 5, 0, 3};

static void stop(const char *what, unsigned number)
{
    fprintf(stderr, "refused.c: %s: %s %u\n", robust ? "robust" : "paper", what, number);
    exit(1);
}

static void must(int holds, const char *what, unsigned number)
{
    if (!holds) {
        stop(what, number);
    }
}

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
                int u = x - bbox.x - frame, v = y - bbox.y - frame / 2;
                int inside = u >= 0 && u < bbox.width && v >= 0 && v < bbox.height;
                pixels[frame][y * WIDTH + x] = (uint8_t)(inside ? (u / 4 * 83 + v / 4 * 47) % 251 : 90 + (x / 9 * 5 + y / 9 * 3) % 30);
            }
        }
    }
}

static smr_frame of(const uint8_t *memory, uint16_t width, uint16_t height)
{
    smr_frame frame;
    memset(&frame, 0, sizeof frame);
    frame.width = frame.parts[0].width = width;
    frame.height = frame.parts[0].height = height;
    frame.parts[0].pixels = memory;
    frame.parts[0].stride = width;
    frame.parts[0].size = (size_t)width * height;
    return frame;
}

static int write_record(void *context, const uint8_t *bytes, size_t count)
{
    course *made = (course *)context;
    must(count <= sizeof made->record - made->recorded, "the record is too large for this test", 0);
    memcpy(made->record + made->recorded, bytes, count);
    made->recorded += count;
    return 0;
}

static smr_config good_config(void)
{
    smr_config config;
    if (robust) {
        smr_config_robust(&config);
    } else {
        smr_config_camera(&config);
        config.paper.window.x = config.paper.window.y = 6;
        config.paper.window_limit.x = config.paper.window_limit.y = 9;
    }
    return config;
}

static size_t target_size(void)
{
    return robust ? SMR_ROBUST_TARGET_SIZE : SMR_PAPER_TARGET_SIZE;
}

static size_t workspace_size(void)
{
    return robust ? SMR_ROBUST_WORKSPACE_SIZE : SMR_PAPER_WORKSPACE_SIZE;
}

static smr_tracker *made_in(target *memory)
{
    const smr_config config = good_config();
    smr_tracker *made;
    must(smr_init(memory, target_size(), &scratch, workspace_size(), &config, &made) == SMR_OK, "smr_init", 0);
    return made;
}

static smr_tracker *askew(smr_tracker *tracker)
{
    return (smr_tracker *)((unsigned char *)tracker + 1);
}

/* Makes the refused call with index `kind`, with `now`, the frame of the step before it. */
static void refuse(smr_tracker *tracker, unsigned kind, const smr_frame *now)
{
    static uint8_t few[4], damaged[sizeof former];
    const smr_frame turned = of(pixels[0], HEIGHT, WIDTH);
    smr_frame corner = *now, wrong = *now;
    smr_answer answer, untouched;
    smr_config config = good_config();
    smr_recorder recorder;
    smr_tracker *made = tracker;
    smr_state state;
    smr_image image;
    smr_rect window;
    size_t size = 7;
    smr_status status;

    corner.parts[0].width = corner.parts[0].height = 1;
    memset(&recorder, 0, sizeof recorder);
    memset(&answer, 0x5A, sizeof answer);
    untouched = answer;
    memcpy(damaged, former, former_size);
    damaged[former_size / 2] ^= 4;
    switch (kind) {
    case 0: status = smr_update(tracker, &turned, &answer); break;
    case 1: status = smr_update(tracker, &corner, &answer); break;
    case 2: status = smr_update(tracker, now, NULL); break;
    case 3: status = smr_update(tracker, NULL, &answer); break;
    case 4: status = smr_update(askew(tracker), now, &answer); break;
    case 5: status = smr_update_step(tracker, &turned, 9, &answer); break;
    case 6: status = smr_update_step(tracker, &corner, 9, &answer); break;
    case 7: status = smr_update_step(tracker, now, 9, NULL); break;
    case 8: status = smr_lock(tracker, now, &outside); break;
    case 9: status = smr_lock(tracker, now, &empty); break;
    case 10: status = smr_lock(tracker, &corner, &bbox); break;
    case 11: status = smr_lock(tracker, now, NULL); break;
    case 12: status = smr_lock_step(tracker, now, &outside, 9); break;
    case 13: status = smr_lock_step(tracker, &corner, &bbox, 9); break;
    case 14: status = smr_restore(tracker, (const uint8_t *)"SMRxxxxx", 8); break;
    case 15: status = smr_restore(tracker, former, former_size - 1); break;
    case 16: status = smr_restore(tracker, damaged, former_size); break;
    case 17: status = smr_restore(tracker, (const uint8_t *)&storage, 64); break;
    case 18: status = smr_restore(tracker, NULL, 64); break;
    case 19: status = smr_moved(NULL, 256, 256); break;
    case 20: status = smr_save(tracker, few, sizeof few, &size); break;
    case 21: status = smr_template(tracker, few, sizeof few, &image); break;
    case 22: status = smr_last(tracker, NULL, &state); break;
    case 23: status = smr_lock_window(tracker, WIDTH, HEIGHT, &outside, &window); break;
    case 24: status = smr_record(tracker, &recorder); break; /* without `write` */
    case 25: /* the present tracker's memory, but wrong settings */
        config.robust.reach = 3;
        config.paper.k.denominator = 0;
        status = smr_init(tracker, target_size(), &scratch, workspace_size(), &config, &made);
        must(made == NULL, "the handle after a refused smr_init", kind);
        break;
    case 26:
        wrong.parts[0].stride = 1;
        status = smr_update_step(tracker, &wrong, 9, &answer);
        break;
    default:
        wrong.parts[0].pixels = (const uint8_t *)&scratch;
        status = smr_lock(tracker, &wrong, &bbox);
        break;
    }
    must(status != SMR_OK && status != SMR_UNDER_WAY, "a call that should be refused:", kind);
    must(memcmp(&answer, &untouched, sizeof answer) == 0 && size == 7 && few[0] == 0, "memory for a result has changed:", kind);
    refusals++;
}

/* After each step: up to three refused calls if `kind` is KINDS, else the one with this index, if there is one. */
static void between(unsigned kind, smr_tracker *tracker, smr_tracker *neighbour, const smr_frame *now)
{
    unsigned count = kind == KINDS ? any() % 4 : kind < KINDS;
    while (count--) {
        refuse(any() % 3 == 0 ? neighbour : tracker, kind == KINDS ? any() % KINDS : kind, now);
    }
}

static void follow(course *made, uint32_t locking, uint32_t updating, unsigned kind)
{
    smr_tracker *tracker = made_in(&storage), *neighbour = made_in(&beside);
    smr_frame first = of(pixels[0], WIDTH, HEIGHT);
    smr_recorder recorder;
    smr_status status;
    unsigned frame;

    memset(made, 0, sizeof *made);
    memset(&recorder, 0, sizeof recorder);
    recorder.write = write_record;
    recorder.context = made;
    must(smr_record(tracker, &recorder) == SMR_OK, "smr_record", 0);
    must(smr_lock(neighbour, &first, &bbox) == SMR_OK, "smr_lock", 0);
    do {
        status = smr_lock_step(tracker, &first, &bbox, locking);
        must(++made->steps[0] < 10000, "a lock that does not end: call", kind);
        between(kind, tracker, neighbour, &first);
    } while (status == SMR_UNDER_WAY);
    must(status == SMR_OK, "a step of a lock", made->steps[0]);
    for (frame = 1; frame <= FRAMES; frame++) {
        smr_frame next = of(pixels[frame], WIDTH, HEIGHT);
        do {
            status = smr_update_step(tracker, &next, updating, &made->answers[frame - 1]);
            must(++made->steps[frame] < 10000, "an update that does not end: call", kind);
            between(kind, tracker, neighbour, &next);
        } while (status == SMR_UNDER_WAY);
        must(status == SMR_OK, "a step of an update", made->steps[frame]);
        steps += made->steps[frame];
    }
    must(smr_save(tracker, made->saved, sizeof made->saved, &made->size) == SMR_OK, "smr_save", 0);
    /* A begin and a lock, then a window and an answer of each frame. */
    must(recorder.failed == 0 && recorder.entries == 2 + 2 * FRAMES, "another number of entries:", recorder.entries);
}

static void compare(uint32_t locking, uint32_t updating, unsigned kind)
{
    unsigned frame;
    follow(&alone, locking, updating, KINDS + 1);
    follow(&disturbed, locking, updating, kind);
    must(memcmp(alone.steps, disturbed.steps, sizeof alone.steps) == 0, "another number of steps: call", kind);
    for (frame = 0; frame < FRAMES; frame++) {
        must(memcmp(&alone.answers[frame], &disturbed.answers[frame], ANSWER) == 0, "another answer: call", kind);
    }
    must(alone.size == disturbed.size && memcmp(alone.saved, disturbed.saved, alone.size) == 0, "another target is saved: call", kind);
    must(alone.recorded == disturbed.recorded && memcmp(alone.record, disturbed.record, alone.recorded) == 0, "another record: call", kind);
}

int main(int count, char **words)
{
    unsigned long runs = count > 1 ? strtoul(words[1], NULL, 10) : 8;
    unsigned run, kind;

    seed = count > 2 ? (uint32_t)strtoul(words[2], NULL, 10) | 1 : 1;
    draw();
    for (robust = 0; robust <= 1; robust++) {
        /* Work of a step. An update takes some thousand units of the paper tracker, and 3,000,000 of the robust one. */
        uint32_t most = robust ? 1000000 : 1000;
        smr_frame first = of(pixels[0], WIDTH, HEIGHT);
        smr_tracker *tracker = made_in(&storage);
        must(smr_lock(tracker, &first, &bbox) == SMR_OK, "smr_lock", 0);
        must(smr_save(tracker, former, sizeof former, &former_size) == SMR_OK, "smr_save", 0);
        for (run = 0; run < runs; run++) {
            compare(most / 8 + any() % most, most / 8 + any() % most, KINDS);
        }
        for (kind = 0; kind < KINDS; kind++) {
            compare(most, most, kind);
        }
        must(disturbed.steps[1] > 1, "an update that takes several steps", disturbed.steps[1]);
    }
    printf("refused: %u refused calls between %u steps changed nothing\n", refusals, steps);
    return 0;
}
