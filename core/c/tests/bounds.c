/*
 * The library reads no byte before or behind the pixels it is given: they end, or begin, where no memory is, so that one
 * byte too many ends the program. (Sanitizers see only what C reads; this sees what the library reads.) POSIX only.
 */

#define _DEFAULT_SOURCE

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "smr.h"

#define WIDTH 64
#define HEIGHT 48
#define STRIDE 70

static uint8_t *before_the_end, *after_the_start;
static size_t page;

static void must(smr_status status)
{
    if (status != SMR_OK) {
        fprintf(stderr, "bounds: %s\n", smr_status_name(status));
        exit(EXIT_FAILURE);
    }
}

/* Pages to be used, with one on each side that cannot be touched. */
static void map_pages(size_t size)
{
    size_t used = (size + page - 1) / page * page;
    uint8_t *pages = (uint8_t *)mmap(NULL, used + 2 * page, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages == (uint8_t *)MAP_FAILED || mprotect(pages + page, used, PROT_READ | PROT_WRITE) != 0) {
        perror("bounds");
        exit(EXIT_FAILURE);
    }
    after_the_start = pages + page;
    before_the_end = pages + page + used;
}

/* The part of a frame of the given number, at the very start or the very end of the pages. */
static smr_frame part_of(unsigned number, const smr_rect *part, int at_the_end)
{
    smr_frame frame;
    unsigned x, y;
    uint8_t *pixels;
    frame.stride = STRIDE;
    frame.size = (size_t)(part->height - 1) * STRIDE + part->width;
    pixels = at_the_end ? before_the_end - frame.size : after_the_start;
    for (y = 0; y < part->height; y++) {
        for (x = 0; x < part->width; x++) {
            unsigned at = (unsigned)((part->y + (int)y) * WIDTH + part->x + (int)x);
            pixels[y * STRIDE + x] = (uint8_t)((at * at * 7919u + number * 31u) >> 5);
        }
    }
    frame.pixels = pixels;
    frame.width = part->width;
    frame.height = part->height;
    frame.x = (uint16_t)part->x;
    frame.y = (uint16_t)part->y;
    frame.full_width = WIDTH;
    frame.full_height = HEIGHT;
    return frame;
}

static void track(smr_rect target, int at_the_end)
{
    static smr_storage storage;
    smr_config config;
    smr_tracker *tracker;
    smr_frame frame;
    smr_answer answer;
    unsigned number;
    must(smr_config_camera(&config));
    config.window.x = config.window.y = 9;
    config.window_limit.x = config.window_limit.y = 14;
    must(smr_init(&storage, sizeof storage, &config, &tracker));
    frame = part_of(0, &target, at_the_end);
    must(smr_lock(tracker, &frame, &target));
    for (number = 1; number < 8; number++) {
        must(smr_window(tracker, &target));
        frame = part_of(number, &target, at_the_end);
        must(smr_update(tracker, &frame, &answer));
    }
}

static void track_robust(smr_rect target, int at_the_end)
{
    static smr_robust_storage storage;
    smr_robust_config config;
    smr_robust_tracker *tracker;
    smr_rect window;
    smr_frame frame;
    smr_robust_answer answer;
    unsigned number;
    must(smr_robust_config_default(&config));
    must(smr_robust_init(&storage, sizeof storage, &config, &tracker));
    must(smr_robust_lock_window(WIDTH, HEIGHT, &target, &window));
    frame = part_of(0, &window, at_the_end);
    must(smr_robust_lock(tracker, &frame, &target));
    for (number = 1; number < 12; number++) {
        must(smr_robust_window(tracker, &window));
        frame = part_of(number * number, &window, at_the_end); /* soon lost: the sweep reads, too */
        must(smr_robust_update(tracker, &frame, &answer));
    }
}

int main(void)
{
    static const int corners[][2] = {{0, 0}, {WIDTH - 13, 0}, {0, HEIGHT - 11}, {WIDTH - 13, HEIGHT - 11}, {25, 20}};
    unsigned i;
    page = (size_t)sysconf(_SC_PAGESIZE);
    map_pages((size_t)STRIDE * HEIGHT);
    for (i = 0; i < sizeof corners / sizeof corners[0]; i++) {
        smr_rect target = {0, 0, 13, 11};
        target.x = corners[i][0];
        target.y = corners[i][1];
        track(target, 0);
        track(target, 1);
        track_robust(target, 0);
        track_robust(target, 1);
    }
    printf("bounds: nothing is read beyond the pixels\n");
    return EXIT_SUCCESS;
}
