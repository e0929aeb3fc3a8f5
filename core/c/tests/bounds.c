/*
 * Checks that the library reads no byte before or after the given pixels. The pixels border on a page without access,
 * so that reading one byte too many ends the program. (Sanitizers do not see the library's reads.) POSIX only.
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

/* Pages of memory for one part of a frame, between two pages without access. */
typedef struct pages {
    uint8_t *start, *end;
} pages;

static pages parts[2];

static void must(smr_status status)
{
    if (status != SMR_OK) {
        fprintf(stderr, "bounds: %s\n", smr_status_name(status));
        exit(EXIT_FAILURE);
    }
}

static pages map_pages(size_t size)
{
    size_t page = (size_t)sysconf(_SC_PAGESIZE), used = (size + page - 1) / page * page;
    uint8_t *mapped = (uint8_t *)mmap(NULL, used + 2 * page, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    pages made;
    if (mapped == (uint8_t *)MAP_FAILED || mprotect(mapped + page, used, PROT_READ | PROT_WRITE) != 0) {
        perror("bounds");
        exit(EXIT_FAILURE);
    }
    made.start = mapped + page;
    made.end = mapped + page + used;
    return made;
}

/* Writes the `window` of frame `number` to the start or the end of `pages`. The part is empty if the window is. */
static smr_part part_of(unsigned number, const pages *pages, const smr_rect *window, int at_the_end)
{
    smr_part part;
    unsigned x, y;
    uint8_t *pixels;
    memset(&part, 0, sizeof part);
    if (window->width == 0) {
        return part;
    }
    part.stride = STRIDE;
    part.size = (size_t)(window->height - 1) * STRIDE + window->width;
    pixels = at_the_end ? pages->end - part.size : pages->start;
    for (y = 0; y < window->height; y++) {
        for (x = 0; x < window->width; x++) {
            unsigned at = (unsigned)((window->y + (int)y) * WIDTH + window->x + (int)x);
            pixels[y * STRIDE + x] = (uint8_t)((at * at * 7919u + number * 31u) >> 5);
        }
    }
    part.pixels = pixels;
    part.width = window->width;
    part.height = window->height;
    part.x = (uint16_t)window->x;
    part.y = (uint16_t)window->y;
    return part;
}

static smr_frame frame_of(unsigned number, const smr_rect windows[2], int at_the_end)
{
    smr_frame frame;
    frame.width = WIDTH;
    frame.height = HEIGHT;
    frame.parts[0] = part_of(number, &parts[0], &windows[0], at_the_end);
    frame.parts[1] = part_of(number, &parts[1], &windows[1], at_the_end);
    return frame;
}

/* Locks, then updates with 11 frames. Returns the number of updates that ask for a second window. */
static unsigned track(const smr_config *config, const smr_rect *target, int at_the_end)
{
    static union {
        smr_paper_target paper;
        smr_robust_target robust;
    } storage;
    static union {
        smr_paper_workspace paper;
        smr_robust_workspace robust;
    } workspace;
    smr_tracker *tracker;
    smr_rect windows[2] = {{0, 0, 0, 0}, {0, 0, 0, 0}};
    smr_frame frame;
    smr_answer answer;
    unsigned number, sweeps = 0;
    must(smr_init(&storage, sizeof storage, &workspace, sizeof workspace, config, &tracker));
    must(smr_lock_window(tracker, WIDTH, HEIGHT, target, &windows[0]));
    frame = frame_of(0, windows, at_the_end);
    must(smr_lock(tracker, &frame, target));
    for (number = 1; number < 12; number++) {
        must(smr_windows(tracker, windows));
        sweeps += windows[1].width > 0;
        frame = frame_of(number * number, windows, at_the_end); /* the target is soon lost, so that the robust tracker also reads the second window */
        must(smr_update(tracker, &frame, &answer));
    }
    return sweeps;
}

int main(void)
{
    static const int corners[][2] = {{0, 0}, {WIDTH - 13, 0}, {0, HEIGHT - 11}, {WIDTH - 13, HEIGHT - 11}, {25, 20}};
    smr_config paper, robust, small;
    unsigned i, sweeps = 0;
    int at_the_end;
    parts[0] = map_pages((size_t)STRIDE * HEIGHT);
    parts[1] = map_pages((size_t)STRIDE * HEIGHT);
    must(smr_config_camera(&paper));
    paper.paper.window.x = paper.paper.window.y = 9;
    paper.paper.window_limit.x = paper.paper.window_limit.y = 14;
    must(smr_config_robust(&robust));
    must(smr_config_small(&small));
    for (i = 0; i < sizeof corners / sizeof corners[0]; i++) {
        smr_rect target = {0, 0, 13, 11};
        target.x = corners[i][0];
        target.y = corners[i][1];
        for (at_the_end = 0; at_the_end < 2; at_the_end++) {
            track(&paper, &target, at_the_end);
            sweeps += track(&robust, &target, at_the_end);
            sweeps += track(&small, &target, at_the_end);
        }
    }
    if (sweeps == 0) {
        fprintf(stderr, "bounds: no frame had a second window\n");
        return EXIT_FAILURE;
    }
    printf("bounds: the trackers read nothing beyond the pixels; %u frames had two windows\n", sweeps);
    return EXIT_SUCCESS;
}
