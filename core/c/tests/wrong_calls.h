/*
 * The table of wrong calls on a tracker, for misuse.c, with the frames, configurations and trackers that its checks share.
 */

#ifndef WRONG_CALLS_H
#define WRONG_CALLS_H

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "smr.h"

#define WIDTH 60
#define HEIGHT 50

typedef union target {
    smr_paper_target paper;
    smr_robust_target robust;
    unsigned char bytes[1];
} target;

typedef union workspace {
    smr_paper_workspace paper;
    smr_robust_workspace robust;
    unsigned char bytes[1];
} workspace;

static unsigned failed, tried;
static uint8_t pixels[WIDTH * HEIGHT];
static uint8_t bytes[SMR_PAPER_SAVED_SIZE + SMR_ROBUST_SAVED_SIZE];
static int robust; /* the tracker under test */
static target storage;
static workspace scratch;

static void expect(const char *call, unsigned line, smr_status got, smr_status wanted)
{
    tried++;
    if (got != wanted) {
        failed++;
        fprintf(stderr, "line %u, %s: %s: %s, should be %s\n", line, robust ? "robust" : "paper", call, smr_status_name(got),
                smr_status_name(wanted));
    }
}
#define EXPECT(call, wanted) expect(#call, __LINE__, (call), (wanted))

static void hold(const char *what, unsigned line, int holds)
{
    tried++;
    if (!holds) {
        failed++;
        fprintf(stderr, "line %u, %s: not true: %s\n", line, robust ? "robust" : "paper", what);
    }
}
#define HOLD(condition) hold(#condition, __LINE__, (condition))

/* The next address, which is misaligned for every type but bytes. */
static void *askew(void *memory)
{
    return (unsigned char *)memory + 1;
}

static smr_rect rect(int32_t x, int32_t y, uint16_t width, uint16_t height)
{
    smr_rect made;
    made.x = x;
    made.y = y;
    made.width = width;
    made.height = height;
    return made;
}

static smr_frame good_frame(void)
{
    smr_frame frame;
    memset(&frame, 0, sizeof frame);
    frame.width = frame.parts[0].width = WIDTH;
    frame.height = frame.parts[0].height = HEIGHT;
    frame.parts[0].pixels = pixels;
    frame.parts[0].size = sizeof pixels;
    frame.parts[0].stride = WIDTH;
    return frame;
}

/* A frame of which only the pixels in `window` are in memory. */
static smr_frame part_of_frame(const smr_rect *window)
{
    smr_frame frame = good_frame();
    smr_part *part = &frame.parts[0];
    part->pixels = pixels + (size_t)window->y * WIDTH + (size_t)window->x;
    part->x = (uint16_t)window->x;
    part->y = (uint16_t)window->y;
    part->width = window->width;
    part->height = window->height;
    part->size = (size_t)(window->height - 1) * WIDTH + window->width;
    return frame;
}

static smr_config good_config(void)
{
    smr_config config;
    if (robust) {
        EXPECT(smr_config_robust(&config), SMR_OK);
    } else {
        EXPECT(smr_config_camera(&config), SMR_OK);
        config.paper.window.x = config.paper.window.y = 5;
        config.paper.window_limit.x = config.paper.window_limit.y = 8;
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

static smr_tracker *tracker_in(target *memory, const smr_config *config)
{
    smr_tracker *tracker = NULL;
    EXPECT(smr_init(memory, sizeof *memory, &scratch, sizeof scratch, config, &tracker), SMR_OK);
    return tracker;
}

static smr_tracker *good_tracker(void)
{
    smr_config config = good_config();
    return tracker_in(&storage, &config);
}

static smr_tracker *locked_tracker(void)
{
    smr_tracker *tracker = good_tracker();
    smr_frame frame = good_frame();
    smr_rect box = rect(26, 22, 8, 8);
    EXPECT(smr_lock(tracker, &frame, &box), SMR_OK);
    return tracker;
}

/*
 * The table of wrong calls on a locked tracker: each call with its status. None changes anything, also between the steps of an
 * update or a lock. The program makes all of them, or the one with index `chosen`.
 */

#define ALL 10000u

static uint8_t former[SMR_PAPER_SAVED_SIZE + SMR_ROBUST_SAVED_SIZE]; /* a saved target */
static size_t former_size;

/* Checks the status of a wrong call. While a lock is under way, the tracker may refuse the call for another reason. */
static void expect_refusal(const char *call, unsigned line, smr_status got, smr_status wanted, int is_locked)
{
    int is_refused = got != SMR_OK && got != SMR_UNDER_WAY;
    expect(call, line, got, is_locked || !is_refused ? wanted : got);
}

/* Returns the number of calls in the table. `now` is a whole frame. */
static unsigned wrong_calls(smr_tracker *tracker, const smr_frame *now, int is_locked, unsigned chosen)
{
    static uint8_t few[4], damaged[sizeof former];
    uint8_t *own = (uint8_t *)tracker;
    smr_frame wrong, corner = *now, turned = *now, several[2];
    smr_rect rects[3], windows[2], outside = rect(-1, 22, 8, 8), empty = rect(5, 5, 0, 3), box = rect(26, 22, 8, 8);
    smr_answer answers[2], untouched[2];
    smr_config config = good_config();
    smr_recorder recorder;
    smr_tracker *made = tracker;
    smr_fine_rect fine[2];
    smr_state states[2];
    smr_image images[2];
    uint16_t quality = 7;
    size_t size = 7;
    unsigned row = 0, init, i;
#define ROW(call, wanted) \
    do { \
        if (chosen == ALL || chosen == row) { \
            expect_refusal(#call, __LINE__, (call), (wanted), is_locked); \
        } \
        row++; \
    } while (0)
    rects[0] = box;
    several[0] = *now;
    corner.parts[0].width = corner.parts[0].height = 1;
    turned.width = turned.parts[0].width = HEIGHT;
    turned.height = turned.parts[0].height = WIDTH;
    turned.parts[0].stride = HEIGHT;
    memset(&recorder, 0, sizeof recorder);
    memset(answers, 0x5A, sizeof answers);
    memcpy(untouched, answers, sizeof answers);
    memcpy(damaged, former, former_size);
    damaged[former_size / 2] ^= 4;
    config.robust.reach = 3;
    config.paper.k.denominator = 0;

    ROW(smr_lock((smr_tracker *)askew(tracker), now, &box), SMR_ERROR_MISALIGNED);
    ROW(smr_lock(tracker, NULL, &box), SMR_ERROR_NULL);
    ROW(smr_lock(tracker, now, NULL), SMR_ERROR_NULL);
    ROW(smr_lock(tracker, (smr_frame *)askew(several), &box), SMR_ERROR_MISALIGNED);
    ROW(smr_lock(tracker, now, (smr_rect *)askew(rects)), SMR_ERROR_MISALIGNED);
    ROW(smr_lock(tracker, now, &outside), SMR_ERROR_BOX_OUTSIDE_FRAME);
    ROW(smr_lock(tracker, now, &empty), SMR_ERROR_BOX_EMPTY);
    ROW(smr_lock(tracker, &corner, &box), SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY);
    ROW(smr_lock_step(tracker, NULL, &box, 9), SMR_ERROR_NULL);
    ROW(smr_lock_step(tracker, now, NULL, 9), SMR_ERROR_NULL);
    ROW(smr_lock_step(tracker, now, &outside, 9), SMR_ERROR_BOX_OUTSIDE_FRAME);
    ROW(smr_lock_step(tracker, now, &empty, 9), SMR_ERROR_BOX_EMPTY);
    ROW(smr_lock_step(tracker, &corner, &box, 9), SMR_ERROR_LOCK_WINDOW_NOT_IN_MEMORY);
    ROW(smr_lock_window(tracker, WIDTH, HEIGHT, NULL, windows), SMR_ERROR_NULL);
    ROW(smr_lock_window(tracker, WIDTH, HEIGHT, &box, NULL), SMR_ERROR_NULL);
    ROW(smr_lock_window(tracker, WIDTH, HEIGHT, (smr_rect *)askew(rects), windows), SMR_ERROR_MISALIGNED);
    ROW(smr_lock_window(tracker, WIDTH, HEIGHT, &box, (smr_rect *)askew(rects)), SMR_ERROR_MISALIGNED);
    ROW(smr_lock_window(tracker, WIDTH, HEIGHT, &outside, windows), SMR_ERROR_BOX_OUTSIDE_FRAME);
    ROW(smr_update((smr_tracker *)askew(tracker), now, answers), SMR_ERROR_MISALIGNED);
    ROW(smr_update(tracker, NULL, answers), SMR_ERROR_NULL);
    ROW(smr_update(tracker, now, NULL), SMR_ERROR_NULL);
    ROW(smr_update(tracker, (smr_frame *)askew(several), answers), SMR_ERROR_MISALIGNED);
    ROW(smr_update(tracker, now, (smr_answer *)askew(answers)), SMR_ERROR_MISALIGNED);
    ROW(smr_update(tracker, &turned, answers), SMR_ERROR_FRAME_SIZE_CHANGED);
    ROW(smr_update(tracker, &corner, answers), SMR_ERROR_WINDOW_NOT_IN_MEMORY);
    ROW(smr_update_step(tracker, NULL, 9, answers), SMR_ERROR_NULL);
    ROW(smr_update_step(tracker, now, 9, NULL), SMR_ERROR_NULL);
    ROW(smr_update_step(tracker, now, 9, (smr_answer *)askew(answers)), SMR_ERROR_MISALIGNED);
    ROW(smr_update_step(tracker, &turned, 9, answers), SMR_ERROR_FRAME_SIZE_CHANGED);
    ROW(smr_update_step(tracker, &corner, 9, answers), SMR_ERROR_WINDOW_NOT_IN_MEMORY);
    ROW(smr_windows(tracker, NULL), SMR_ERROR_NULL);
    ROW(smr_windows(tracker, (smr_rect *)askew(rects)), SMR_ERROR_MISALIGNED);
    ROW(smr_last(tracker, NULL, states), SMR_ERROR_NULL);
    ROW(smr_last(tracker, fine, NULL), SMR_ERROR_NULL);
    ROW(smr_last(tracker, (smr_fine_rect *)askew(fine), states), SMR_ERROR_MISALIGNED);
    ROW(smr_last(tracker, fine, (smr_state *)askew(states)), SMR_ERROR_MISALIGNED);
    ROW(smr_moved(NULL, 256, 256), SMR_ERROR_NULL);
    ROW(smr_quality(tracker, NULL), SMR_ERROR_NULL);
    ROW(smr_quality(NULL, &quality), SMR_ERROR_NULL);
    ROW(smr_template(tracker, NULL, sizeof bytes, images), SMR_ERROR_NULL);
    ROW(smr_template(tracker, bytes, sizeof bytes, NULL), SMR_ERROR_NULL);
    ROW(smr_template(tracker, bytes, sizeof bytes, (smr_image *)askew(images)), SMR_ERROR_MISALIGNED);
    ROW(smr_template(tracker, bytes, (size_t)-1, images), SMR_ERROR_MEMORY_TOO_LARGE);
    ROW(smr_template(tracker, own, sizeof storage, images), SMR_ERROR_OVERLAPS_TRACKER);
    ROW(smr_template(tracker, scratch.bytes, sizeof storage, images), SMR_ERROR_OVERLAPS_TRACKER);
    ROW(smr_template(tracker, few, sizeof few, images), SMR_ERROR_BUFFER_TOO_SMALL);
    ROW(smr_saved_size(tracker, NULL), SMR_ERROR_NULL);
    ROW(smr_save(tracker, NULL, sizeof bytes, &size), SMR_ERROR_NULL);
    ROW(smr_save(tracker, bytes, sizeof bytes, NULL), SMR_ERROR_NULL);
    ROW(smr_save(tracker, bytes, SIZE_MAX, &size), SMR_ERROR_MEMORY_TOO_LARGE);
    ROW(smr_save(tracker, own + target_size() - 1, 1, &size), SMR_ERROR_OVERLAPS_TRACKER);
    ROW(smr_save(tracker, scratch.bytes, 1, &size), SMR_ERROR_OVERLAPS_TRACKER);
    ROW(smr_save(tracker, few, 0, &size), SMR_ERROR_BUFFER_TOO_SMALL);
    ROW(smr_save(tracker, few, sizeof few, &size), SMR_ERROR_BUFFER_TOO_SMALL);
    ROW(smr_restore(tracker, NULL, former_size), SMR_ERROR_NULL);
    ROW(smr_restore(tracker, former, SIZE_MAX), SMR_ERROR_MEMORY_TOO_LARGE);
    ROW(smr_restore(tracker, own, 1), SMR_ERROR_OVERLAPS_TRACKER);
    ROW(smr_restore(tracker, own, 64), SMR_ERROR_OVERLAPS_TRACKER);
    ROW(smr_restore(tracker, now->parts[0].pixels, sizeof pixels), SMR_ERROR_NOT_SAVED);
    ROW(smr_restore(tracker, former, 0), SMR_ERROR_NOT_SAVED);
    ROW(smr_restore(tracker, (const uint8_t *)"SMRxxxxx", 8), SMR_ERROR_OTHER_VERSION);
    ROW(smr_restore(tracker, former, former_size - 1), SMR_ERROR_TRUNCATED);
    ROW(smr_restore(tracker, damaged, former_size), SMR_ERROR_DAMAGED);
    ROW(smr_record(tracker, &recorder), SMR_ERROR_NULL); /* without `write` */
    /* The memory of this tracker, but wrong settings. */
    init = row;
    ROW(smr_init(own, target_size(), &scratch, workspace_size(), &config, &made), SMR_ERROR_CONFIG_OUT_OF_RANGE);

    /* Wrong frames: all calls that take one return the same status. */
#define FRAME(change, wanted) \
    do { \
        wrong = *now; \
        wrong.parts[1] = wrong.parts[0]; \
        change; \
        ROW(smr_lock(tracker, &wrong, &box), wanted); \
        ROW(smr_lock_step(tracker, &wrong, &box, 1), wanted); \
        ROW(smr_update(tracker, &wrong, answers), wanted); \
        ROW(smr_update_step(tracker, &wrong, 1, answers), wanted); \
    } while (0)
    FRAME(wrong.width = WIDTH - 1, SMR_ERROR_OUTSIDE_FRAME);
    FRAME(wrong.height = 0, SMR_ERROR_OUTSIDE_FRAME);
    FRAME(wrong.parts[0].pixels = NULL, SMR_ERROR_NULL);
    for (i = 0; i < 2; i++) {
        FRAME(wrong.parts[i].width = 0, SMR_ERROR_FRAME_EMPTY);
        FRAME(wrong.parts[i].height = 0, SMR_ERROR_FRAME_EMPTY);
        FRAME(wrong.parts[i].stride = WIDTH - 1, SMR_ERROR_STRIDE_TOO_SMALL);
        FRAME(wrong.parts[i].stride = 1, SMR_ERROR_STRIDE_TOO_SMALL);
        FRAME(wrong.parts[i].stride = 0, SMR_ERROR_STRIDE_TOO_SMALL);
        FRAME(wrong.parts[i].stride = WIDTH + 1, SMR_ERROR_FRAME_TOO_SHORT);
        FRAME(wrong.parts[i].stride = SIZE_MAX, SMR_ERROR_FRAME_TOO_SHORT);
        FRAME(wrong.parts[i].size = sizeof pixels - 1, SMR_ERROR_FRAME_TOO_SHORT);
        FRAME(wrong.parts[i].size = 0, SMR_ERROR_FRAME_TOO_SHORT);
        FRAME(wrong.parts[i].size = (size_t)PTRDIFF_MAX + 1, SMR_ERROR_MEMORY_TOO_LARGE);
        FRAME(wrong.parts[i].x = 1, SMR_ERROR_OUTSIDE_FRAME);
        FRAME(wrong.parts[i].y = UINT16_MAX, SMR_ERROR_OUTSIDE_FRAME);
        FRAME(wrong.parts[i].pixels = own, SMR_ERROR_OVERLAPS_TRACKER);
        FRAME(wrong.parts[i].pixels = own + target_size() - 1, SMR_ERROR_OVERLAPS_TRACKER);
        FRAME(wrong.parts[i].pixels = scratch.bytes, SMR_ERROR_OVERLAPS_TRACKER);
        FRAME(wrong.parts[i].pixels = scratch.bytes + workspace_size() - 1, SMR_ERROR_OVERLAPS_TRACKER);
    }
    HOLD(memcmp(answers, untouched, sizeof answers) == 0 && size == 7 && quality == 7 && few[0] == 0);
    HOLD(made == (chosen == ALL || chosen == init ? NULL : tracker));
    return row;
}

#endif
