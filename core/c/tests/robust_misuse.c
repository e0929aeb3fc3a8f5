/*
 * Every way to call the robust tracker wrongly that the library can notice is noticed, by its own status, and changes
 * nothing. What both trackers have in common (names, versions) is in misuse.c.
 */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "smr.h"

#define WIDTH 60
#define HEIGHT 50

static unsigned failed, tried;
static uint8_t pixels[WIDTH * HEIGHT];
static uint8_t copied[SMR_ROBUST_PIXELS];
static smr_robust_storage storage;

static void expect(const char *call, unsigned line, smr_status got, smr_status wanted)
{
    tried++;
    if (got != wanted) {
        failed++;
        fprintf(stderr, "robust_misuse.c:%u: %s: %s, should be %s\n", line, call, smr_status_name(got),
                smr_status_name(wanted));
    }
}
#define EXPECT(call, wanted) expect(#call, __LINE__, (call), (wanted))

static void hold(const char *what, unsigned line, int holds)
{
    tried++;
    if (!holds) {
        failed++;
        fprintf(stderr, "robust_misuse.c:%u: not so: %s\n", line, what);
    }
}
#define HOLD(condition) hold(#condition, __LINE__, (condition))

/* A pointer one byte further: aligned for nothing but bytes. */
static void *askew(void *memory)
{
    return (unsigned char *)memory + 1;
}

static smr_frame good_frame(void)
{
    smr_frame frame;
    frame.pixels = pixels;
    frame.size = sizeof pixels;
    frame.stride = WIDTH;
    frame.width = frame.full_width = WIDTH;
    frame.height = frame.full_height = HEIGHT;
    frame.x = frame.y = 0;
    return frame;
}

static smr_robust_config good_config(void)
{
    smr_robust_config config;
    EXPECT(smr_robust_config_default(&config), SMR_OK);
    return config;
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

static smr_robust_tracker *good_tracker(void)
{
    smr_robust_config config = good_config();
    smr_robust_tracker *tracker = NULL;
    EXPECT(smr_robust_init(&storage, sizeof storage, &config, &tracker), SMR_OK);
    return tracker;
}

static void sizes(void)
{
    HOLD(smr_robust_tracker_size() == SMR_ROBUST_TRACKER_SIZE);
    HOLD(sizeof(smr_robust_storage) == SMR_ROBUST_TRACKER_SIZE);
    HOLD(SMR_ROBUST_TRACKER_SIZE % SMR_ROBUST_TRACKER_ALIGN == 0);
}

static void configurations(void)
{
    smr_robust_config config = good_config();
    smr_robust_tracker *tracker = NULL;
    HOLD(config.velocity == 1 && config.near == 1 && config.size == 1);
    HOLD(config.verification == 1 && config.caution == 1 && config.sweep == 1);
    HOLD(config.plain_loop == 0);
    EXPECT(smr_robust_config_default(NULL), SMR_ERROR_NULL);
    memset(&config, 200, sizeof config); /* everything but 0 switches on */
    EXPECT(smr_robust_init(&storage, sizeof storage, &config, &tracker), SMR_OK);
    memset(&config, 0, sizeof config);
    EXPECT(smr_robust_init(&storage, sizeof storage, &config, &tracker), SMR_OK);
    HOLD(tracker != NULL);
}

static void storages(void)
{
    static smr_robust_storage two[2], zeroes;
    smr_robust_config config;
    smr_robust_tracker *trackers[2] = {NULL, NULL}, **tracker = trackers;
    config = good_config();
    EXPECT(smr_robust_init(NULL, sizeof storage, &config, tracker), SMR_ERROR_NULL);
    EXPECT(smr_robust_init(two, sizeof storage, NULL, tracker), SMR_ERROR_NULL);
    EXPECT(smr_robust_init(two, sizeof storage, &config, NULL), SMR_ERROR_NULL);
    EXPECT(smr_robust_init(askew(two), sizeof storage, &config, tracker), SMR_ERROR_MISALIGNED);
    EXPECT(smr_robust_init(two, sizeof storage, &config, (smr_robust_tracker **)askew(trackers)),
           SMR_ERROR_MISALIGNED);
    EXPECT(smr_robust_init(two, 0, &config, tracker), SMR_ERROR_STORAGE_TOO_SMALL);
    EXPECT(smr_robust_init(two, SMR_ROBUST_TRACKER_SIZE - 1, &config, tracker), SMR_ERROR_STORAGE_TOO_SMALL);
    HOLD(memcmp(&two[0], &zeroes, sizeof zeroes) == 0);
    HOLD(trackers[0] == NULL);

    EXPECT(smr_robust_init(two, SMR_ROBUST_TRACKER_SIZE, &config, tracker), SMR_OK);
    HOLD(trackers[0] != NULL && trackers[1] == NULL);
    HOLD(memcmp(&two[1], &zeroes, sizeof zeroes) == 0); /* nothing is written behind the storage */
}

/* What the calls on a tracker say to memory that is not one. */
static void no_tracker(smr_robust_tracker *tracker, smr_status wanted)
{
    smr_frame frame = good_frame();
    smr_rect target = rect(10, 10, 12, 12), window;
    smr_robust_answer answer;
    smr_image image;
    EXPECT(smr_robust_lock(tracker, &frame, &target), wanted);
    EXPECT(smr_robust_update(tracker, &frame, &answer), wanted);
    EXPECT(smr_robust_window(tracker, &window), wanted);
    EXPECT(smr_robust_early_template(tracker, copied, sizeof copied, &image), wanted);
}

static void no_trackers(void)
{
    static smr_robust_storage zeroes, moved;
    static smr_storage papers;
    smr_config config;
    smr_tracker *other;
    smr_robust_tracker *tracker = good_tracker();
    no_tracker(NULL, SMR_ERROR_NULL);
    no_tracker((smr_robust_tracker *)askew(tracker), SMR_ERROR_MISALIGNED);
    no_tracker((smr_robust_tracker *)(void *)&zeroes, SMR_ERROR_NOT_INITIALISED);
    memcpy(&moved, &storage, sizeof storage);
    no_tracker((smr_robust_tracker *)(void *)&moved, SMR_ERROR_NOT_INITIALISED);
    memset(&storage, 0xFF, sizeof storage);
    no_tracker(tracker, SMR_ERROR_NOT_INITIALISED);
    /* The paper's tracker is another one. */
    EXPECT(smr_config_camera(&config), SMR_OK);
    if (sizeof papers <= sizeof zeroes) {
        EXPECT(smr_init(&zeroes, sizeof zeroes, &config, &other), SMR_OK);
        no_tracker((smr_robust_tracker *)(void *)other, SMR_ERROR_NOT_INITIALISED);
    }
}

static void pointers(void)
{
    smr_robust_tracker *tracker = good_tracker();
    smr_frame frames[2];
    smr_rect rects[2];
    smr_robust_answer answers[2];
    smr_image images[2];
    frames[0] = good_frame();
    rects[0] = rect(10, 10, 12, 12);
    EXPECT(smr_robust_lock(tracker, NULL, rects), SMR_ERROR_NULL);
    EXPECT(smr_robust_lock(tracker, frames, NULL), SMR_ERROR_NULL);
    EXPECT(smr_robust_lock(tracker, (smr_frame *)askew(frames), rects), SMR_ERROR_MISALIGNED);
    EXPECT(smr_robust_lock(tracker, frames, (smr_rect *)askew(rects)), SMR_ERROR_MISALIGNED);
    EXPECT(smr_robust_lock(tracker, frames, rects), SMR_OK);
    EXPECT(smr_robust_update(tracker, NULL, answers), SMR_ERROR_NULL);
    EXPECT(smr_robust_update(tracker, frames, NULL), SMR_ERROR_NULL);
    EXPECT(smr_robust_update(tracker, (smr_frame *)askew(frames), answers), SMR_ERROR_MISALIGNED);
    EXPECT(smr_robust_update(tracker, frames, (smr_robust_answer *)askew(answers)), SMR_ERROR_MISALIGNED);
    EXPECT(smr_robust_window(tracker, NULL), SMR_ERROR_NULL);
    EXPECT(smr_robust_window(tracker, (smr_rect *)askew(rects)), SMR_ERROR_MISALIGNED);
    EXPECT(smr_robust_early_template(tracker, NULL, sizeof copied, images), SMR_ERROR_NULL);
    EXPECT(smr_robust_early_template(tracker, copied, sizeof copied, NULL), SMR_ERROR_NULL);
    EXPECT(smr_robust_early_template(tracker, copied, sizeof copied, (smr_image *)askew(images)), SMR_ERROR_MISALIGNED);
    EXPECT(smr_robust_lock_window(WIDTH, HEIGHT, NULL, rects), SMR_ERROR_NULL);
    EXPECT(smr_robust_lock_window(WIDTH, HEIGHT, rects, NULL), SMR_ERROR_NULL);
    EXPECT(smr_robust_lock_window(WIDTH, HEIGHT, (smr_rect *)askew(rects), rects + 1), SMR_ERROR_MISALIGNED);
    EXPECT(smr_robust_lock_window(WIDTH, HEIGHT, rects, (smr_rect *)askew(rects)), SMR_ERROR_MISALIGNED);
}

/* A frame that lock and update refuse alike. */
static void refused(smr_robust_tracker *tracker, const smr_frame *frame, smr_status wanted)
{
    smr_rect target = rect(10, 10, 12, 12);
    smr_robust_answer answer;
    EXPECT(smr_robust_lock(tracker, frame, &target), wanted);
    EXPECT(smr_robust_update(tracker, frame, &answer), wanted);
}

static void frames(void)
{
    smr_robust_tracker *tracker = good_tracker();
    smr_rect target = rect(10, 10, 12, 12);
    smr_frame frame = good_frame();
    EXPECT(smr_robust_lock(tracker, &frame, &target), SMR_OK);
#define REFUSED_FRAME(change, wanted) \
    frame = good_frame(); \
    change; \
    refused(tracker, &frame, wanted)
    REFUSED_FRAME(frame.pixels = NULL, SMR_ERROR_NULL);
    REFUSED_FRAME(frame.width = 0, SMR_ERROR_FRAME_EMPTY);
    REFUSED_FRAME(frame.stride = WIDTH - 1, SMR_ERROR_STRIDE_TOO_SMALL);
    REFUSED_FRAME(frame.size = sizeof pixels - 1, SMR_ERROR_FRAME_TOO_SHORT);
    REFUSED_FRAME(frame.size = (size_t)PTRDIFF_MAX + 1, SMR_ERROR_FRAME_TOO_LARGE);
    REFUSED_FRAME(frame.x = 1, SMR_ERROR_OUTSIDE_FRAME);

    frame = good_frame();
    frame.pixels = storage.bytes;
    refused(tracker, &frame, SMR_ERROR_FRAME_OVERLAPS_TRACKER);
    frame.pixels = storage.bytes + SMR_ROBUST_TRACKER_SIZE - 1;
    refused(tracker, &frame, SMR_ERROR_FRAME_OVERLAPS_TRACKER);
}

/* The part of the frame that a window covers. */
static smr_frame part_of_frame(const smr_rect *window)
{
    smr_frame frame = good_frame();
    frame.pixels = pixels + (size_t)window->y * WIDTH + (size_t)window->x;
    frame.x = (uint16_t)window->x;
    frame.y = (uint16_t)window->y;
    frame.width = window->width;
    frame.height = window->height;
    frame.size = (size_t)(window->height - 1) * WIDTH + window->width;
    return frame;
}

static void boxes(void)
{
    smr_robust_tracker *tracker = good_tracker();
    smr_frame frame = good_frame();
    smr_rect target, window;
#define REFUSED_BOX(left, top, across, down, wanted) \
    target = rect(left, top, across, down); \
    window = rect(-7, -7, 7, 7); \
    EXPECT(smr_robust_lock_window(WIDTH, HEIGHT, &target, &window), wanted); \
    HOLD((window.x == -7) == ((wanted) != SMR_OK)); \
    EXPECT(smr_robust_lock(tracker, &frame, &target), wanted)
    REFUSED_BOX(5, 5, 0, 6, SMR_ERROR_BOX_EMPTY);
    REFUSED_BOX(5, 5, 6, 0, SMR_ERROR_BOX_EMPTY);
    REFUSED_BOX(-1, 5, 6, 6, SMR_ERROR_BOX_OUTSIDE_FRAME);
    REFUSED_BOX(WIDTH - 5, 5, 6, 6, SMR_ERROR_BOX_OUTSIDE_FRAME);
    REFUSED_BOX(INT32_MAX, INT32_MIN, UINT16_MAX, UINT16_MAX, SMR_ERROR_BOX_OUTSIDE_FRAME);
    REFUSED_BOX(0, 0, WIDTH, HEIGHT, SMR_OK);
    REFUSED_BOX(0, 0, 1, 1, SMR_OK);
}

/* The lock window is what lock reads: with it there is a lock, with a column or a row less there is none. */
static void surroundings(void)
{
    smr_robust_tracker *tracker = good_tracker();
    smr_frame frame;
    smr_rect target = rect(26, 22, 8, 8), window;
    EXPECT(smr_robust_lock_window(WIDTH, HEIGHT, &target, &window), SMR_OK);
    HOLD(window.x > 0 && window.y > 0 && window.x + window.width < WIDTH && window.y + window.height < HEIGHT);
    frame = part_of_frame(&window);
    EXPECT(smr_robust_lock(tracker, &frame, &target), SMR_OK);
    frame.width--;
    EXPECT(smr_robust_lock(tracker, &frame, &target), SMR_ERROR_SURROUNDINGS_NOT_IN_MEMORY);
    frame.width++;
    frame.height--;
    EXPECT(smr_robust_lock(tracker, &frame, &target), SMR_ERROR_SURROUNDINGS_NOT_IN_MEMORY);
}

static void order(void)
{
    smr_robust_tracker *tracker = good_tracker();
    smr_frame frame = good_frame();
    smr_rect target = rect(26, 22, 8, 8), window = rect(-7, -7, 7, 7);
    smr_robust_answer answer;
    smr_image image;
    memset(&answer, 0x5A, sizeof answer);
    memset(&image, 0x5A, sizeof image);
    EXPECT(smr_robust_update(tracker, &frame, &answer), SMR_ERROR_NOT_LOCKED);
    EXPECT(smr_robust_window(tracker, &window), SMR_ERROR_NOT_LOCKED);
    EXPECT(smr_robust_early_template(tracker, copied, sizeof copied, &image), SMR_ERROR_NOT_LOCKED);
    HOLD(answer.bbox.x == 0x5A5A5A5A && window.x == -7 && image.width == 0x5A5A);

    EXPECT(smr_robust_lock(tracker, &frame, &target), SMR_OK);
    frame.height = frame.full_height = HEIGHT - 1;
    EXPECT(smr_robust_update(tracker, &frame, &answer), SMR_ERROR_FRAME_SIZE_CHANGED);

    EXPECT(smr_robust_window(tracker, &window), SMR_OK);
    HOLD(window.x > 0 && window.y >= 0 && window.width < WIDTH && window.x + window.width <= WIDTH);
    frame = part_of_frame(&window);
    frame.width--;
    EXPECT(smr_robust_update(tracker, &frame, &answer), SMR_ERROR_WINDOW_NOT_IN_MEMORY);
    HOLD(answer.bbox.x == 0x5A5A5A5A);
    frame.width++;
    EXPECT(smr_robust_update(tracker, &frame, &answer), SMR_OK);
    HOLD(answer.bbox.x == 26 && answer.bbox.y == 22 && answer.bbox.width == 8 && answer.bbox.height == 8);
    HOLD(answer.state == SMR_ROBUST_TRACKING && answer.ratio > 65000 && answer.found_again == 0);
}

/* The early template is copied: into enough memory, and no further. */
static void early_templates(void)
{
    smr_robust_tracker *tracker = good_tracker();
    smr_frame frame = good_frame();
    smr_rect target = rect(26, 22, 8, 8);
    smr_image image;
    EXPECT(smr_robust_lock(tracker, &frame, &target), SMR_OK);
    memset(copied, 0x5A, sizeof copied);
    memset(&image, 0x5A, sizeof image);
    EXPECT(smr_robust_early_template(tracker, copied, 16 * 16 - 1, &image), SMR_ERROR_BUFFER_TOO_SMALL);
    HOLD(copied[0] == 0x5A && image.width == 0x5A5A);
    EXPECT(smr_robust_early_template(tracker, copied, 16 * 16, &image), SMR_OK);
    HOLD(image.pixels == copied && image.width == 16 && image.height == 16); /* a grid of half pixels */
    HOLD(copied[16 * 16] == 0x5A && memchr(copied, 0x5A, 16 * 16) != copied);
}

int main(void)
{
    unsigned i;
    for (i = 0; i < sizeof pixels; i++) {
        pixels[i] = (uint8_t)((i * i * 7919u) >> 5);
    }
    sizes();
    configurations();
    storages();
    no_trackers();
    pointers();
    frames();
    boxes();
    surroundings();
    order();
    early_templates();
    printf("robust_misuse: %u claims, %u failed\n", tried, failed);
    return failed == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
