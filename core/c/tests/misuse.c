/*
 * Every way to call the library wrongly that it can notice is noticed, by its own status, and changes nothing.
 */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "smr.h"

#define WIDTH 40
#define HEIGHT 30

static unsigned failed, tried;
static uint8_t pixels[WIDTH * HEIGHT];
static smr_storage storage;

static void expect(const char *call, unsigned line, smr_status got, smr_status wanted)
{
    tried++;
    if (got != wanted) {
        failed++;
        fprintf(stderr, "misuse.c:%u: %s: %s, should be %s\n", line, call, smr_status_name(got), smr_status_name(wanted));
    }
}
#define EXPECT(call, wanted) expect(#call, __LINE__, (call), (wanted))

static void hold(const char *what, unsigned line, int holds)
{
    tried++;
    if (!holds) {
        failed++;
        fprintf(stderr, "misuse.c:%u: not so: %s\n", line, what);
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

static smr_config good_config(void)
{
    smr_config config;
    EXPECT(smr_config_camera(&config), SMR_OK);
    config.window.x = config.window.y = 5;
    config.window_limit.x = config.window_limit.y = 8;
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

static smr_tracker *good_tracker(void)
{
    smr_config config = good_config();
    smr_tracker *tracker = NULL;
    EXPECT(smr_init(&storage, sizeof storage, &config, &tracker), SMR_OK);
    return tracker;
}

static void names(void)
{
    HOLD(strcmp(smr_status_name(SMR_OK), "SMR_OK") == 0);
    HOLD(strcmp(smr_status_name(SMR_ERROR_WINDOW_NOT_IN_MEMORY), "SMR_ERROR_WINDOW_NOT_IN_MEMORY") == 0);
    HOLD(strcmp(smr_status_name(-1), "SMR_ERROR_UNKNOWN") == 0);
    HOLD(strcmp(smr_status_name(SMR_ERROR_BUFFER_TOO_SMALL + 1), "SMR_ERROR_UNKNOWN") == 0);
}

static void version(void)
{
    char stated[32];
    sprintf(stated, "%d.%d.%d", SMR_VERSION_MAJOR, SMR_VERSION_MINOR, SMR_VERSION_PATCH);
    HOLD(strcmp(stated, smr_version()) == 0);
}

static void sizes(void)
{
    HOLD(smr_tracker_size() == SMR_TRACKER_SIZE);
    HOLD(sizeof(smr_storage) == SMR_TRACKER_SIZE);
    HOLD(sizeof(smr_table) == 512);
}

static void tables(void)
{
    static smr_table table[2];
    EXPECT(smr_table_init(NULL, 40), SMR_ERROR_NULL);
    EXPECT(smr_table_init((smr_table *)askew(table), 40), SMR_ERROR_MISALIGNED);
    EXPECT(smr_table_init(table, 0), SMR_ERROR_SCALE_OUT_OF_RANGE);
    EXPECT(smr_table_init(table, 4097), SMR_ERROR_SCALE_OUT_OF_RANGE);
    HOLD(table[0].entries[0] == 0 && table[0].entries[255] == 0);
    EXPECT(smr_table_init(table, 40), SMR_OK);
    HOLD(table[0].entries[0] == 65535 && table[0].entries[40] == 24109); /* 65535 / e */
    HOLD(table[1].entries[0] == 0);
}

static void configurations(void)
{
    static smr_table empty;
    smr_config several[2], config = good_config();
    smr_tracker *tracker = NULL;
    EXPECT(smr_config_camera(NULL), SMR_ERROR_NULL);
    EXPECT(smr_config_camera((smr_config *)askew(several)), SMR_ERROR_MISALIGNED);
    EXPECT(smr_config_paper(NULL), SMR_ERROR_NULL);
    EXPECT(smr_config_paper((smr_config *)askew(several)), SMR_ERROR_MISALIGNED);
#define REFUSED(change, wanted) \
    config = good_config(); \
    change; \
    tracker = (smr_tracker *)(void *)&storage; \
    EXPECT(smr_init(&storage, sizeof storage, &config, &tracker), wanted); \
    HOLD(tracker == NULL)
    REFUSED(config.k.denominator = 0, SMR_ERROR_ZERO_DENOMINATOR);
    REFUSED(config.gate.tracking.denominator = 0, SMR_ERROR_ZERO_DENOMINATOR);
    REFUSED(config.gate.leaving.denominator = 0, SMR_ERROR_ZERO_DENOMINATOR);
    REFUSED(config.gate.returning.denominator = 0, SMR_ERROR_ZERO_DENOMINATOR);
    REFUSED(config.gate.lost.denominator = 0, SMR_ERROR_ZERO_DENOMINATOR);
    REFUSED(config.k.numerator = 0, SMR_ERROR_NOTHING_COUNTS);
    REFUSED(config.first_threshold = 0, SMR_ERROR_NOTHING_COUNTS);
    REFUSED(config.window_limit.x = 4, SMR_ERROR_LIMIT_BELOW_WINDOW);
    REFUSED(config.window_limit.y = 4, SMR_ERROR_LIMIT_BELOW_WINDOW);
    REFUSED(config.table = &empty, SMR_ERROR_NOT_INITIALISED);
    REFUSED(config.table = (smr_table *)askew(&empty), SMR_ERROR_MISALIGNED);
}

static void storages(void)
{
    static smr_storage two[2], zeroes;
    smr_config several[2];
    smr_tracker *trackers[2] = {NULL, NULL}, **tracker = trackers;
    several[0] = good_config();
    EXPECT(smr_init(NULL, sizeof storage, several, tracker), SMR_ERROR_NULL);
    EXPECT(smr_init(two, sizeof storage, NULL, tracker), SMR_ERROR_NULL);
    EXPECT(smr_init(two, sizeof storage, several, NULL), SMR_ERROR_NULL);
    EXPECT(smr_init(askew(two), sizeof storage, several, tracker), SMR_ERROR_MISALIGNED);
    EXPECT(smr_init(two, sizeof storage, (smr_config *)askew(several), tracker), SMR_ERROR_MISALIGNED);
    EXPECT(smr_init(two, sizeof storage, several, (smr_tracker **)askew(trackers)), SMR_ERROR_MISALIGNED);
    EXPECT(smr_init(two, 0, several, tracker), SMR_ERROR_STORAGE_TOO_SMALL);
    EXPECT(smr_init(two, SMR_TRACKER_SIZE - 1, several, tracker), SMR_ERROR_STORAGE_TOO_SMALL);
    HOLD(memcmp(&two[0], &zeroes, sizeof zeroes) == 0);
    HOLD(trackers[0] == NULL);

    EXPECT(smr_init(two, SMR_TRACKER_SIZE, several, tracker), SMR_OK);
    HOLD(trackers[0] != NULL && trackers[1] == NULL);
    HOLD(memcmp(&two[1], &zeroes, sizeof zeroes) == 0); /* nothing is written behind the storage */
}

/* What the calls on a tracker say to memory that is not one. */
static void no_tracker(smr_tracker *tracker, smr_status wanted)
{
    smr_frame frame = good_frame();
    smr_rect target = rect(10, 10, 6, 6), window;
    smr_answer answer;
    smr_image image;
    uint16_t alpha;
    EXPECT(smr_lock(tracker, &frame, &target), wanted);
    EXPECT(smr_update(tracker, &frame, &answer), wanted);
    EXPECT(smr_window(tracker, &window), wanted);
    EXPECT(smr_template(tracker, &image), wanted);
    EXPECT(smr_alpha(tracker, &alpha), wanted);
}

static void no_trackers(void)
{
    static smr_storage zeroes, moved;
    smr_tracker *tracker = good_tracker();
    no_tracker(NULL, SMR_ERROR_NULL);
    no_tracker((smr_tracker *)askew(tracker), SMR_ERROR_MISALIGNED);
    no_tracker((smr_tracker *)(void *)&zeroes, SMR_ERROR_NOT_INITIALISED);
    memcpy(&moved, &storage, sizeof storage);
    no_tracker((smr_tracker *)(void *)&moved, SMR_ERROR_NOT_INITIALISED);
    memset(&storage, 0xFF, sizeof storage);
    no_tracker(tracker, SMR_ERROR_NOT_INITIALISED);
}

static void pointers(void)
{
    smr_tracker *tracker = good_tracker();
    smr_frame frames[2];
    smr_rect rects[2];
    smr_answer answers[2];
    smr_image images[2];
    uint16_t alphas[2];
    frames[0] = good_frame();
    rects[0] = rect(10, 10, 6, 6);
    EXPECT(smr_lock(tracker, NULL, rects), SMR_ERROR_NULL);
    EXPECT(smr_lock(tracker, frames, NULL), SMR_ERROR_NULL);
    EXPECT(smr_lock(tracker, (smr_frame *)askew(frames), rects), SMR_ERROR_MISALIGNED);
    EXPECT(smr_lock(tracker, frames, (smr_rect *)askew(rects)), SMR_ERROR_MISALIGNED);
    EXPECT(smr_lock(tracker, frames, rects), SMR_OK);
    EXPECT(smr_update(tracker, NULL, answers), SMR_ERROR_NULL);
    EXPECT(smr_begin(tracker, NULL), SMR_ERROR_NULL);
    EXPECT(smr_step(tracker, frames, 1, NULL), SMR_ERROR_NULL);
    EXPECT(smr_finish(tracker, frames, NULL), SMR_ERROR_NULL);
    EXPECT(smr_update(tracker, frames, NULL), SMR_ERROR_NULL);
    EXPECT(smr_update(tracker, (smr_frame *)askew(frames), answers), SMR_ERROR_MISALIGNED);
    EXPECT(smr_update(tracker, frames, (smr_answer *)askew(answers)), SMR_ERROR_MISALIGNED);
    EXPECT(smr_window(tracker, NULL), SMR_ERROR_NULL);
    EXPECT(smr_window(tracker, (smr_rect *)askew(rects)), SMR_ERROR_MISALIGNED);
    EXPECT(smr_template(tracker, NULL), SMR_ERROR_NULL);
    EXPECT(smr_template(tracker, (smr_image *)askew(images)), SMR_ERROR_MISALIGNED);
    EXPECT(smr_alpha(tracker, NULL), SMR_ERROR_NULL);
    EXPECT(smr_alpha(tracker, (uint16_t *)askew(alphas)), SMR_ERROR_MISALIGNED);
}

/* A frame that lock and update refuse alike. */
static void refused(smr_tracker *tracker, const smr_frame *frame, smr_status wanted)
{
    smr_rect target = rect(10, 10, 6, 6);
    smr_answer answer;
    EXPECT(smr_lock(tracker, frame, &target), wanted);
    EXPECT(smr_update(tracker, frame, &answer), wanted);
}

static void frames(void)
{
    smr_tracker *tracker = good_tracker();
    smr_rect target = rect(10, 10, 6, 6);
    smr_frame frame = good_frame();
    smr_image image;
    EXPECT(smr_lock(tracker, &frame, &target), SMR_OK);
#define REFUSED_FRAME(change, wanted) \
    frame = good_frame(); \
    change; \
    refused(tracker, &frame, wanted)
    REFUSED_FRAME(frame.pixels = NULL, SMR_ERROR_NULL);
    REFUSED_FRAME(frame.width = 0, SMR_ERROR_FRAME_EMPTY);
    REFUSED_FRAME(frame.height = 0, SMR_ERROR_FRAME_EMPTY);
    REFUSED_FRAME(frame.stride = WIDTH - 1, SMR_ERROR_STRIDE_TOO_SMALL);
    REFUSED_FRAME(frame.stride = 0, SMR_ERROR_STRIDE_TOO_SMALL);
    REFUSED_FRAME(frame.stride = WIDTH + 1, SMR_ERROR_FRAME_TOO_SHORT);
    REFUSED_FRAME(frame.stride = SIZE_MAX, SMR_ERROR_FRAME_TOO_SHORT);
    REFUSED_FRAME(frame.size = sizeof pixels - 1, SMR_ERROR_FRAME_TOO_SHORT);
    REFUSED_FRAME(frame.size = 0, SMR_ERROR_FRAME_TOO_SHORT);
    REFUSED_FRAME(frame.size = (size_t)PTRDIFF_MAX + 1, SMR_ERROR_FRAME_TOO_LARGE);
    REFUSED_FRAME(frame.full_width = WIDTH - 1, SMR_ERROR_OUTSIDE_FRAME);
    REFUSED_FRAME(frame.full_height = 0, SMR_ERROR_OUTSIDE_FRAME);
    REFUSED_FRAME(frame.x = 1, SMR_ERROR_OUTSIDE_FRAME);
    REFUSED_FRAME(frame.y = UINT16_MAX, SMR_ERROR_OUTSIDE_FRAME);

    EXPECT(smr_template(tracker, &image), SMR_OK);
    frame.pixels = image.pixels;
    frame.width = image.width;
    frame.height = image.height;
    frame.stride = image.width;
    frame.size = (size_t)image.width * image.height;
    refused(tracker, &frame, SMR_ERROR_FRAME_OVERLAPS_TRACKER);
}

static void boxes(void)
{
    static uint8_t wide[SMR_PIXELS + 1];
    smr_tracker *tracker = good_tracker();
    smr_frame frame = good_frame();
    smr_rect target;
#define REFUSED_BOX(x, y, width, height, wanted) \
    target = rect(x, y, width, height); \
    EXPECT(smr_lock(tracker, &frame, &target), wanted)
    REFUSED_BOX(5, 5, 0, 6, SMR_ERROR_BOX_EMPTY);
    REFUSED_BOX(5, 5, 6, 0, SMR_ERROR_BOX_EMPTY);
    REFUSED_BOX(-1, 5, 6, 6, SMR_ERROR_BOX_OUTSIDE_FRAME);
    REFUSED_BOX(WIDTH - 5, 5, 6, 6, SMR_ERROR_BOX_OUTSIDE_FRAME);
    REFUSED_BOX(INT32_MAX, INT32_MIN, UINT16_MAX, UINT16_MAX, SMR_ERROR_BOX_OUTSIDE_FRAME);
    frame.pixels += 10;
    frame.size -= 10;
    frame.width -= 10;
    frame.x = 10;
    REFUSED_BOX(9, 5, 6, 6, SMR_ERROR_BOX_NOT_IN_MEMORY);
    REFUSED_BOX(10, 5, 6, 6, SMR_OK);

    frame.pixels = wide;
    frame.size = sizeof wide;
    frame.width = frame.full_width = SMR_PIXELS + 1;
    frame.height = frame.full_height = 1;
    frame.stride = sizeof wide;
    frame.x = 0;
    REFUSED_BOX(0, 0, SMR_PIXELS + 1, 1, SMR_ERROR_BOX_TOO_LARGE);
    REFUSED_BOX(0, 0, SMR_PIXELS, 1, SMR_OK);
}

static void windows(void)
{
    static uint8_t wide[2 * SMR_SPAN + 4];
    smr_config config = good_config();
    smr_tracker *tracker;
    smr_frame frame = good_frame();
    smr_rect target = rect(0, 0, 1, 1);
    frame.pixels = wide;
    frame.size = frame.stride = sizeof wide;
    frame.width = frame.full_width = sizeof wide;
    frame.height = frame.full_height = 1;
    config.window_limit.x = SMR_SPAN / 2 + 1;
    EXPECT(smr_init(&storage, sizeof storage, &config, &tracker), SMR_OK);
    EXPECT(smr_lock(tracker, &frame, &target), SMR_ERROR_WINDOW_TOO_LARGE);
    config.window_limit.x = (SMR_SPAN - 1) / 2;
    EXPECT(smr_init(&storage, sizeof storage, &config, &tracker), SMR_OK);
    EXPECT(smr_lock(tracker, &frame, &target), SMR_OK);
}

static void order(void)
{
    smr_tracker *tracker = good_tracker();
    smr_frame frame = good_frame();
    smr_rect target = rect(15, 10, 6, 6), window = rect(-7, -7, 7, 7);
    smr_answer answer;
    smr_image image;
    uint16_t alpha = 777;
    uint8_t done = 0;
    memset(&answer, 0x5A, sizeof answer);
    EXPECT(smr_update(tracker, &frame, &answer), SMR_ERROR_NOT_LOCKED);
    EXPECT(smr_window(tracker, &window), SMR_ERROR_NOT_LOCKED);
    EXPECT(smr_template(tracker, &image), SMR_ERROR_NOT_LOCKED);
    EXPECT(smr_alpha(tracker, &alpha), SMR_ERROR_NOT_LOCKED);
    HOLD(answer.bbox.x == 0x5A5A5A5A && window.x == -7 && alpha == 777);

    EXPECT(smr_lock(tracker, &frame, &target), SMR_OK);
    frame.height = frame.full_height = HEIGHT - 1;
    EXPECT(smr_update(tracker, &frame, &answer), SMR_ERROR_FRAME_SIZE_CHANGED);

    frame = good_frame();
    EXPECT(smr_window(tracker, &window), SMR_OK);
    HOLD(window.x == 10 && window.y == 5 && window.width == 16 && window.height == 16);
    frame.pixels = pixels + (size_t)window.y * WIDTH + (size_t)window.x;
    frame.x = (uint16_t)window.x;
    frame.y = (uint16_t)window.y;
    frame.height = window.height;
    frame.size = (size_t)(window.height - 1) * WIDTH + window.width;
    frame.width = (uint16_t)(window.width - 1);
    EXPECT(smr_update(tracker, &frame, &answer), SMR_ERROR_WINDOW_NOT_IN_MEMORY);
    HOLD(answer.bbox.x == 0x5A5A5A5A);
    frame.width = window.width;
    EXPECT(smr_finish(tracker, &frame, &answer), SMR_ERROR_NOT_BEGUN);
    EXPECT(smr_begin(tracker, &frame), SMR_OK);
    EXPECT(smr_step(tracker, &frame, 1, &done), SMR_OK);
    EXPECT(smr_update(tracker, &frame, &answer), SMR_OK);
    EXPECT(smr_step(tracker, &frame, 1, &done), SMR_ERROR_NOT_BEGUN);
    HOLD(answer.bbox.x == 15 && answer.bbox.y == 10 && answer.state == SMR_TRACKING && answer.ratio == 65535);
    EXPECT(smr_template(tracker, &image), SMR_OK);
    HOLD(image.width == 6 && image.height == 6 && image.pixels[6] == pixels[11 * WIDTH + 15]);
    EXPECT(smr_alpha(tracker, &alpha), SMR_OK);
    HOLD(alpha == 13);
}

int main(void)
{
    unsigned i;
    for (i = 0; i < sizeof pixels; i++) {
        pixels[i] = (uint8_t)((i * i * 7919u) >> 5);
    }
    names();
    version();
    sizes();
    tables();
    configurations();
    storages();
    no_trackers();
    pointers();
    frames();
    boxes();
    windows();
    order();
    printf("misuse: %u claims, %u failed\n", tried, failed);
    return failed == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
