/*
 * Calls the library at random: with NULL or misaligned pointers, too little memory, in the wrong order, with any numbers. No call may
 * crash, access memory beyond the given size, or return an unknown status. Run it under sanitizers: every object has exactly the
 * stated size.
 *
 * fuzz [EXECUTIONS [SEED]]: the same seed gives the same calls.
 */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "smr.h"

#define CALLS 24

static uint32_t seed;
static unsigned long calls, done, locked, updated;

static uint32_t any(void)
{
    seed ^= seed << 13;
    seed ^= seed >> 17;
    seed ^= seed << 5;
    return seed;
}

static uint32_t below(uint32_t end)
{
    return any() % end;
}

static int rarely(void)
{
    return below(24) == 0;
}

static void stop(const char *what, uint32_t start)
{
    fprintf(stderr, "fuzz.c: %s: run `fuzz 1 %lu`\n", what, (unsigned long)start);
    abort();
}

/* Allocates memory of exactly `size` bytes, with random content. */
static void *memory(size_t size)
{
    unsigned char *made = (unsigned char *)malloc(size ? size : 1);
    size_t at;
    if (!made) {
        exit(2);
    }
    for (at = 0; at < size; at++) {
        made[at] = (unsigned char)any();
    }
    return made;
}

/* Returns a random number: mostly one below `end`, rarely any 16-bit number. */
static uint16_t mostly(uint32_t end)
{
    return (uint16_t)(rarely() ? any() : below(end));
}

static smr_rect box(uint16_t width, uint16_t height)
{
    smr_rect made;
    made.width = (uint16_t)(1 + below(14));
    made.height = (uint16_t)(1 + below(14));
    made.x = (int32_t)below(width);
    made.y = (int32_t)below(height);
    if (rarely()) {
        made.x = (int32_t)(any() >> 1) - 0x40000000;
        made.width = (uint16_t)any();
    }
    return made;
}

/* Allocates one part of a frame, in memory of its own. */
static void part(smr_part *made, smr_rect wanted)
{
    size_t gap = below(4);
    memset(made, 0, sizeof *made);
    if (wanted.width == 0 || wanted.height == 0 || (uint32_t)wanted.width * wanted.height > 100000) {
        wanted.x = wanted.y = 0;
        wanted.width = wanted.height = 1;
    }
    made->width = wanted.width;
    made->height = wanted.height;
    made->x = (uint16_t)wanted.x;
    made->y = (uint16_t)wanted.y;
    made->stride = wanted.width + gap;
    made->size = made->stride * (wanted.height - 1u) + wanted.width;
    made->pixels = (const uint8_t *)memory(made->size);
}

/* Makes a random field of a frame's description wrong, but never states more bytes (`size`) than the part's memory has. */
static void spoil(smr_frame *frame)
{
    smr_part *spoiled = &frame->parts[below(2)];
    switch (below(8)) {
    case 0:
        spoiled->size = spoiled->size ? below((uint32_t)spoiled->size) : 0;
        break;
    case 1:
        spoiled->stride = any();
        break;
    case 2:
        spoiled->width = (uint16_t)any();
        break;
    case 3:
        spoiled->height = (uint16_t)any();
        break;
    case 4:
        spoiled->x = (uint16_t)any();
        break;
    case 5:
        frame->width = (uint16_t)any();
        break;
    case 6:
        spoiled->stride = SIZE_MAX - below(3);
        break;
    default:
        frame->height = 0;
        break;
    }
}

static void configure(smr_config *config)
{
    switch (below(5)) {
    case 0:
        smr_config_paper(config);
        break;
    case 1:
        smr_config_robust(config);
        config->robust.reach = (uint8_t)(rarely() ? any() : 4);
        break;
    default:
        smr_config_camera(config);
        break;
    }
    config->paper.window.x = mostly(10);
    config->paper.window.y = mostly(10);
    config->paper.window_limit.x = (uint16_t)(config->paper.window.x + below(9));
    config->paper.window_limit.y = (uint16_t)(config->paper.window.y + below(9));
    config->plain_loop = (uint8_t)below(2);
    if (below(4) == 0) {
        /* Changes a random byte of the settings, but not the pointer `method`. */
        unsigned char *numbers = (unsigned char *)config;
        size_t at = offsetof(smr_config, paper) + below((uint32_t)(sizeof *config - offsetof(smr_config, paper)));
        numbers[at] = (unsigned char)any();
    }
}

static void one(uint32_t start)
{
    smr_config config;
    smr_tracker *tracker = NULL;
    size_t storage_size, workspace_size, size = 0, written = 0;
    void *storage, *workspace;
    uint8_t *saved;
    uint16_t width = (uint16_t)(16 + below(40)), height = (uint16_t)(16 + below(30)), quality;
    unsigned call;

    seed = start ? start : 1;
    any();
    configure(&config);
    storage_size = smr_target_size(&config);
    workspace_size = smr_workspace_size(&config);
    storage_size -= rarely() && storage_size ? 1 : 0;
    workspace_size -= rarely() && workspace_size ? 1 : 0;
    storage = memory(storage_size);
    workspace = memory(workspace_size);
    if (smr_init(storage, storage_size, workspace, workspace_size, &config, rarely() ? NULL : &tracker) != SMR_OK) {
        tracker = NULL;
    }
    smr_saved_size(tracker, &size);
    saved = (uint8_t *)memory(size);
    for (call = 0; call < CALLS; call++) {
        smr_frame frame;
        smr_answer answer;
        smr_rect windows[2] = {{0, 0, 0, 0}, {0, 0, 0, 0}}, target = box(width, height);
        smr_fine_rect bbox;
        smr_state state = SMR_TRACKING;
        smr_image image;
        smr_status status = SMR_OK;
        uint8_t *read[2];

        memset(&frame, 0, sizeof frame);
        frame.width = width;
        frame.height = height;
        if (call == 0 || rarely()) {
            smr_lock_window(tracker, width, height, &target, &windows[0]);
        } else {
            smr_windows(tracker, windows);
        }
        part(&frame.parts[0], windows[0]);
        if (windows[1].width) {
            part(&frame.parts[1], windows[1]);
        }
        read[0] = (uint8_t *)frame.parts[0].pixels;
        read[1] = (uint8_t *)frame.parts[1].pixels;
        if (rarely()) {
            spoil(&frame);
        }
        switch (call == 0 ? 0 : below(16)) {
        case 0:
            status = smr_lock(tracker, rarely() ? NULL : &frame, rarely() ? NULL : &target);
            locked += status == SMR_OK;
            break;
        case 1:
            status = smr_moved(tracker, (int32_t)(any() >> (1 + below(24))), -(int32_t)(any() >> (1 + below(24))));
            break;
        case 2:
            status = smr_save(tracker, rarely() ? NULL : saved, rarely() ? below((uint32_t)size + 1) : size, &written);
            break;
        case 3:
            if (size && below(2)) {
                saved[below((uint32_t)size)] ^= (uint8_t)(1u << below(8));
            }
            status = smr_restore(tracker, saved, below(2) ? size : below((uint32_t)size + 1));
            break;
        case 4:
            status = smr_template(tracker, saved, below((uint32_t)size + 1), rarely() ? NULL : &image);
            break;
        case 7:
            status = smr_last(tracker, rarely() ? NULL : &bbox, rarely() ? NULL : &state);
            break;
        case 8:
        case 9:
            do {
                status = smr_update_step(tracker, &frame, any() >> below(32), rarely() ? NULL : &answer);
            } while (status == SMR_UNDER_WAY && !rarely());
            break;
        case 12:
            do {
                status = smr_lock_step(tracker, rarely() ? NULL : &frame, rarely() ? NULL : &target, any() >> below(32));
            } while (status == SMR_UNDER_WAY && !rarely());
            smr_quality(tracker, rarely() ? NULL : &quality);
            break;
        default:
            status = smr_update(tracker, rarely() ? NULL : &frame, rarely() ? NULL : &answer);
            updated += status == SMR_OK;
            break;
        }
        calls++;
        done += status == SMR_OK;
        if (status < 0 || status >= SMR_ERROR_UNKNOWN) {
            stop("an unknown status", start);
        }
        free(read[0]);
        free(read[1]);
    }
    free(saved);
    free(workspace);
    free(storage);
}

int main(int count, char **words)
{
    unsigned long executions = count > 1 ? strtoul(words[1], NULL, 10) : 2000, at;
    unsigned long start = count > 2 ? strtoul(words[2], NULL, 10) : 1;

    for (at = 0; at < executions; at++) {
        one((uint32_t)(start + at));
    }
    /* Fails if too few calls succeeded for a useful test. */
    if (executions >= 1000 && (locked < executions / 4 || updated < executions)) {
        fprintf(stderr, "fuzz.c: of %lu calls only %lu locked and %lu updated\n", calls, locked, updated);
        return 1;
    }
    printf("fuzz: %lu executions, %lu calls, %lu of them succeeded, %lu updates\n", executions, calls, done, updated);
    return 0;
}
