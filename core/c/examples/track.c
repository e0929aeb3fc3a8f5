/*
 * Follows a patch that moves through generated frames, half out of the picture and back, and prints where it is.
 *
 * This is all that a program needs: one storage, one configuration, lock, update. It allocates nothing. Each frame is
 * given as a camera would that reads out only the part it is asked for.
 */

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "smr.h"

#define FRAME_WIDTH 96
#define FRAME_HEIGHT 64
#define TARGET 12
#define FRAMES 24
#define TURN 14

static uint8_t sensor[FRAME_HEIGHT][FRAME_WIDTH];
static smr_storage storage;

/* A texture that does not repeat: the same at every call for the same seed. */
static uint8_t noise(uint32_t seed, int x, int y)
{
    uint32_t n = seed + (uint32_t)x * 374761393u + (uint32_t)y * 668265263u;
    n = (n ^ (n >> 13)) * 1274126177u;
    return (uint8_t)((n ^ (n >> 16)) & 255u);
}

/* A new dim background in every frame, and the bright target with its corner at (left, top), as far as it is in view. */
static void expose(uint32_t number, int left, int top)
{
    int x, y;
    for (y = 0; y < FRAME_HEIGHT; y++) {
        for (x = 0; x < FRAME_WIDTH; x++) {
            int inside = x >= left && x < left + TARGET && y >= top && y < top + TARGET;
            sensor[y][x] = inside ? (uint8_t)(128 + noise(1, x - left, y - top) / 2)
                                  : (uint8_t)(noise(1000 + number, x, y) / 4);
        }
    }
}

/* What the camera hands over when it is asked for `part` of the frame. */
static smr_frame read_out(const smr_rect *part)
{
    smr_frame frame;
    frame.pixels = &sensor[part->y][part->x];
    frame.stride = FRAME_WIDTH;
    frame.size = (size_t)(part->height - 1) * FRAME_WIDTH + part->width;
    frame.width = part->width;
    frame.height = part->height;
    frame.x = (uint16_t)part->x;
    frame.y = (uint16_t)part->y;
    frame.full_width = FRAME_WIDTH;
    frame.full_height = FRAME_HEIGHT;
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
    return state == SMR_TRACKING ? "tracking" : state == SMR_LEAVING ? "leaving" : "lost";
}

static unsigned percent(uint16_t ratio)
{
    return (ratio * 100u + 32767u) / 65535u;
}

int main(void)
{
    int left = 20, top = 20, number, wrong = 0;
    smr_rect part = {0, 0, TARGET, TARGET};
    smr_config config;
    smr_tracker *tracker;
    smr_frame frame;

    must(smr_config_camera(&config), "smr_config_camera");
    config.window.x = config.window.y = 12;
    config.window_limit.x = config.window_limit.y = 24;
    must(smr_init(&storage, sizeof storage, &config, &tracker), "smr_init");
    printf("smr %s, %lu bytes for the tracker\n", smr_version(), (unsigned long)smr_tracker_size());

    part.x = left;
    part.y = top;
    expose(0, left, top);
    frame = read_out(&part);
    must(smr_lock(tracker, &frame, &part), "smr_lock");

    for (number = 1; number <= FRAMES; number++) {
        smr_answer answer;
        left += number <= TURN ? 5 : -5;
        top += number % 3 - 1;
        expose((uint32_t)number, left, top);
        must(smr_window(tracker, &part), "smr_window");
        frame = read_out(&part);
        must(smr_update(tracker, &frame, &answer), "smr_update");
        printf("frame %2d: %3" PRId32 ",%3" PRId32 " %ux%u %-8s similar %3u %%, alpha %u\n", number,
               answer.bbox.x, answer.bbox.y, (unsigned)answer.bbox.width, (unsigned)answer.bbox.height,
               name_of(answer.state), percent(answer.ratio), (unsigned)answer.alpha);
        wrong += answer.state == SMR_LOST || answer.bbox.x != left || answer.bbox.y != top;
    }
    printf("%d of %d frames wrong\n", wrong, FRAMES);
    return wrong == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
