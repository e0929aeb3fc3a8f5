/*
 * A complete program: follows a target through generated frames and prints its box. The target moves, is hidden for a while, and
 * reappears elsewhere.
 *
 *     track                with the paper tracker
 *     track robust         with the robust tracker; only the configuration differs
 *     track METHOD FILE    writes a flight record to FILE, which `host-sim replay FILE` runs again
 *
 * The steps: memory, a configuration, a lock, updates. Nothing is allocated. The program simulates a camera that reads out only the
 * windows that the tracker needs (smr_windows).
 */

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "smr.h"

#define FRAME_WIDTH 160
#define FRAME_HEIGHT 120
#define TARGET 16
#define FRAMES 40
#define HIDDEN_FROM 16
#define HIDDEN_TO 26

/* Memory for either tracker. A program with one tracker has only an smr_paper_target or an smr_robust_target. */
static union {
    smr_paper_target paper;
    smr_robust_target robust;
} storage;
static union {
    smr_paper_workspace paper;
    smr_robust_workspace robust;
} workspace;

static uint8_t sensor[FRAME_HEIGHT][FRAME_WIDTH];

/* The gray level at (x, y) of a texture that does not repeat; the same seed gives the same texture. */
static uint8_t noise(uint32_t seed, int x, int y)
{
    uint32_t n = seed + x * 374761393u + y * 668265263u;
    n = (n ^ (n >> 13)) * 1274126177u;
    return (n ^ (n >> 16)) & 255u;
}

/* Draws a dim, flickering background and, if `in_view`, the bright target with its top left corner at (left, top). */
static void expose(uint32_t number, int in_view, int left, int top)
{
    int x, y;
    for (y = 0; y < FRAME_HEIGHT; y++) {
        for (x = 0; x < FRAME_WIDTH; x++) {
            int inside = in_view && x >= left && x < left + TARGET && y >= top && y < top + TARGET;
            sensor[y][x] = inside ? 128 + noise(1, (x - left) / 3, (y - top) / 3) / 2
                                  : noise(2, x / 4, y / 4) / 4 + noise(1000 + number, x, y) / 32;
        }
    }
}

/* Reads `window` out of the sensor. An empty window gives an empty part. */
static smr_part read_out(const smr_rect *window)
{
    smr_part part;
    memset(&part, 0, sizeof part);
    if (window->width > 0) {
        part.pixels = &sensor[window->y][window->x];
        part.stride = FRAME_WIDTH;
        part.size = (window->height - 1) * sizeof sensor[0] + window->width;
        part.width = window->width;
        part.height = window->height;
        part.x = window->x;
        part.y = window->y;
    }
    return part;
}

static smr_frame frame_of(const smr_rect windows[2])
{
    smr_frame frame;
    frame.width = FRAME_WIDTH;
    frame.height = FRAME_HEIGHT;
    frame.parts[0] = read_out(&windows[0]);
    frame.parts[1] = read_out(&windows[1]);
    return frame;
}

static void must(smr_status status, const char *what)
{
    if (status != SMR_OK) {
        fprintf(stderr, "%s: %s\n", what, smr_status_name(status));
        exit(EXIT_FAILURE);
    }
}

static const char *name_of(smr_state state)
{
    static const char *const names[] = {"tracking", "leaving", "uncertain", "lost"};
    return names[state];
}

/* The file of the flight record, if there is one. `context` of a recorder is for programs with several. */
static FILE *record;

/* Stores the bytes of a flight record. Firmware would write to flash or a serial line here. */
static int32_t to_file(void *context, const uint8_t *bytes, size_t size)
{
    (void)context;
    return fwrite(bytes, 1, size, record) != size;
}

static unsigned percent(uint16_t ratio)
{
    return (ratio * 100u + 32767u) / 65535u;
}

int main(int argc, char **argv)
{
    int left = 20, top = 20, number, wrong = 0;
    smr_rect target = {0, 0, TARGET, TARGET}, windows[2] = {{0, 0, 0, 0}, {0, 0, 0, 0}};
    smr_config config;
    smr_tracker *tracker;
    smr_frame frame;
    unsigned long bytes[2];
    smr_recorder recorder = {to_file, NULL, 0, 0, NULL};

    if (argc == 3 && (record = fopen(argv[2], "wb")) == NULL) {
        fprintf(stderr, "cannot write %s\n", argv[2]);
        return EXIT_FAILURE;
    }
    if (argc >= 2 && strcmp(argv[1], "robust") == 0) {
        must(smr_config_robust(&config), "smr_config_robust");
    } else {
        must(smr_config_camera(&config), "smr_config_camera");
        config.paper.window.x = config.paper.window.y = 12;
        config.paper.window_limit.x = config.paper.window_limit.y = 24;
        config.paper.least_ratio = 65535 / 2; /* do not accept noise */
    }
    must(smr_init(&storage, sizeof storage, &workspace, sizeof workspace, &config, &tracker), "smr_init");
    bytes[0] = smr_target_size(&config);
    bytes[1] = smr_workspace_size(&config);
    printf("smr %s, %lu bytes for the target, %lu for the workspace\n", smr_version(), bytes[0], bytes[1]);

    if (argc == 3) {
        must(smr_record(tracker, &recorder), "smr_record");
    }
    target.x = left;
    target.y = top;
    expose(0, 1, left, top);
    must(smr_lock_window(tracker, FRAME_WIDTH, FRAME_HEIGHT, &target, &windows[0]), "smr_lock_window");
    frame = frame_of(windows);
    must(smr_lock(tracker, &frame, &target), "smr_lock");

    for (number = 1; number <= FRAMES; number++) {
        int in_view = number < HIDDEN_FROM || number >= HIDDEN_TO, near, sought;
        smr_answer answer;
        left += in_view ? 2 : 0;
        top += in_view ? number % 3 - 1 : 1;
        expose(number, in_view, left, top);
        must(smr_windows(tracker, windows), "smr_windows");
        frame = frame_of(windows);
        must(smr_update(tracker, &frame, &answer), "smr_update");
        printf("frame %2d: %3" PRId32 ",%3" PRId32 " %ux%u %-9s similar %3u %%, %u x %u%s pixels read\n", number,
               answer.bbox.x, answer.bbox.y, answer.bbox.width, answer.bbox.height,
               name_of(answer.state), percent(answer.ratio), windows[0].width, windows[0].height,
               windows[1].width > 0 ? " and more" : "");
        near = labs(0L + answer.bbox.x - left) <= 2 && labs(0L + answer.bbox.y - top) <= 2;
        /* The tracker must find the target while it is in view, and must not be tracking in the last frame in which it is hidden. If the
         * target reappears outside windows[0], the search window, the robust tracker may miss it in the first three
         * frames in view: outside windows[0], an update searches only windows[1], a part of the frame. As long as the
         * tracker misses the target, the state must not be SMR_TRACKING. */
        sought = number >= HIDDEN_TO && number < HIDDEN_TO + 3 && windows[1].width > 0 && answer.state != SMR_TRACKING;
        wrong += (in_view && !near && !sought) || (number == HIDDEN_TO - 1 && answer.state == SMR_TRACKING);
    }
    wrong += recorder.failed || (record != NULL && fclose(record) != 0);
    printf("track: %d of %d frames wrong\n", wrong, FRAMES);
    return wrong == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
