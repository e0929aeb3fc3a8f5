/*
 * Checks the read-out: every format gives the gray levels that the header states. A tracker that gets only windows from the read-out answers like one that gets whole gray frames.
 */

#include <stdio.h>
#include <string.h>

#include "smr.h"

#define WIDTH 96
#define HEIGHT 72
#define STRIDE (2 * WIDTH + 6)

/* Indices of `formats`. */
enum { GRAY8, YUYV, UYVY, RGB565_BE, RGB565_LE, BAYER8, GRAY10 };
static const smr_format *const formats[] = {&SMR_GRAY8, &SMR_YUYV, &SMR_UYVY, &SMR_RGB565_BE, &SMR_RGB565_LE, &SMR_BAYER8, &SMR_GRAY10};

static unsigned failed, tried;

static void hold(const char *what, unsigned line, int holds)
{
    tried++;
    if (!holds) {
        failed++;
        fprintf(stderr, "readout.c:%u: not true: %s\n", line, what);
    }
}
#define HOLD(condition) hold(#condition, __LINE__, (condition))

/* The bytes that a camera sends; a mosaic (BAYER8) has twice as many lines. */
static uint8_t sent[2 * HEIGHT * STRIDE];
static uint8_t gray[WIDTH * HEIGHT], read_pixels[2 * WIDTH * HEIGHT];

/* A texture that moves by two columns and one row per frame. */
static uint8_t level(int frame, int x, int y)
{
    int u = x - 2 * frame, v = y - frame;
    return (uint8_t)(128 + (u / 3 * 37 + v / 4 * 61 + (u / 3) * (v / 4) * 17) % 90);
}

static unsigned luma(unsigned rgb)
{
    unsigned red = rgb >> 11, green = rgb >> 5 & 63, blue = rgb & 31;
    red = red << 3 | red >> 2;
    green = green << 2 | green >> 4;
    blue = blue << 3 | blue >> 2;
    return (19595 * red + 38470 * green + 7471 * blue + 32768) >> 16;
}

/* Fills `sent` with a frame in a camera's format, and `gray` with its gray levels. */
static void expose(int format, int frame)
{
    int x, y;
    memset(sent, 0xA5, sizeof sent);
    for (y = 0; y < HEIGHT; y++) {
        for (x = 0; x < WIDTH; x++) {
            uint8_t *line = sent + y * STRIDE, *meant = gray + y * WIDTH + x;
            unsigned rgb = (unsigned)level(frame, x, y) * 257u;
            *meant = level(frame, x, y);
            switch (format) {
            case GRAY8: line[x] = *meant; break;
            case YUYV: line[2 * x] = *meant; break;
            case UYVY: line[2 * x + 1] = *meant; break;
            case RGB565_BE: line[2 * x] = (uint8_t)(rgb >> 8); line[2 * x + 1] = (uint8_t)rgb; *meant = (uint8_t)luma(rgb); break;
            case RGB565_LE: line[2 * x + 1] = (uint8_t)(rgb >> 8); line[2 * x] = (uint8_t)rgb; *meant = (uint8_t)luma(rgb); break;
            case BAYER8:
                line = sent + 2 * y * STRIDE;
                line[2 * x] = *meant; line[2 * x + 1] = (uint8_t)(*meant + 9);
                line[STRIDE + 2 * x] = (uint8_t)(*meant + 4); line[STRIDE + 2 * x + 1] = (uint8_t)(*meant + 1);
                *meant = (uint8_t)(((2u * *meant + 9) / 2 + (2u * *meant + 6) / 2) / 2);
                break;
            default: line[x / 4 * 5 + x % 4] = *meant; break; /* GRAY10 */
            }
        }
    }
}

static smr_frame whole(void)
{
    smr_frame frame;
    memset(&frame, 0, sizeof frame);
    frame.width = frame.parts[0].width = WIDTH;
    frame.height = frame.parts[0].height = HEIGHT;
    frame.parts[0].pixels = gray;
    frame.parts[0].size = sizeof gray;
    frame.parts[0].stride = WIDTH;
    return frame;
}

/* Reads the windows of a frame out of `sent`, line by line. The second window may be empty. */
static smr_frame read_out(int format, const smr_rect windows[2])
{
    smr_readout readout;
    smr_frame frame;
    uint16_t scale = format == BAYER8 ? 2 : 1, y;
    smr_status status = smr_readout_begin(&readout, formats[format], scale * WIDTH, scale * HEIGHT, windows, read_pixels, sizeof read_pixels);
    memset(&frame, 0, sizeof frame);
    HOLD(status == SMR_OK);
    for (y = 0; y < scale * HEIGHT; y++) {
        status = smr_readout_line(&readout, y, sent + y * STRIDE, STRIDE);
        HOLD(status == SMR_OK);
    }
    status = smr_readout_frame(&readout, &frame);
    HOLD(status == SMR_OK);
    return frame;
}

/* The read-out stores two windows in one buffer, one after the other; each is a part of the frame. */
static void two_windows(int format)
{
    static const smr_rect windows[2] = {{7, 5, 20, 10}, {40, 9, 11, 8}};
    smr_frame frame;
    int which, y;
    expose(format, 3);
    frame = read_out(format, windows);
    HOLD(frame.width == WIDTH && frame.height == HEIGHT && frame.parts[1].pixels == read_pixels + 20 * 10);
    for (which = 0; which < 2; which++) {
        const smr_part *part = &frame.parts[which];
        const smr_rect *window = &windows[which];
        HOLD(part->x == window->x && part->y == window->y && part->width == window->width && part->height == window->height);
        HOLD(part->size == (size_t)window->width * window->height && part->stride == window->width);
        for (y = 0; y < window->height; y++) {
            HOLD(memcmp(part->pixels + y * window->width, gray + (window->y + y) * WIDTH + window->x, window->width) == 0);
        }
    }
}

/* A tracker that gets whole gray frames and one that gets windows from the read-out give equal answers. */
static void follow(int format)
{
    static smr_robust_target storages[2];
    static smr_robust_workspace workspace;
    static const smr_rect target = {30, 20, 24, 20};
    smr_tracker *trackers[2];
    smr_config config;
    smr_rect windows[2];
    smr_frame frame;
    int index, number;
    smr_config_robust(&config);
    for (index = 0; index < 2; index++) {
        HOLD(smr_init(&storages[index], sizeof storages[index], &workspace, sizeof workspace, &config, &trackers[index]) == SMR_OK);
    }
    expose(format, 0);
    memset(windows, 0, sizeof windows);
    HOLD(smr_lock_window(trackers[1], WIDTH, HEIGHT, &target, windows) == SMR_OK);
    frame = whole();
    HOLD(smr_lock(trackers[0], &frame, &target) == SMR_OK);
    frame = read_out(format, windows);
    HOLD(smr_lock(trackers[1], &frame, &target) == SMR_OK);
    for (number = 1; number < 8; number++) {
        smr_answer expected, answer;
        memset(&expected, 0, sizeof expected);
        memset(&answer, 0, sizeof answer);
        expose(format, number);
        frame = whole();
        HOLD(smr_update(trackers[0], &frame, &expected) == SMR_OK);
        HOLD(smr_windows(trackers[1], windows) == SMR_OK);
        frame = read_out(format, windows);
        HOLD(smr_update(trackers[1], &frame, &answer) == SMR_OK);
        HOLD(memcmp(&expected, &answer, sizeof answer) == 0);
    }
}

/* A shrunk frame has the means of blocks, as the header defines them. */
static void shrunk(int n)
{
    const smr_rect windows[2] = {{2, 1, (uint16_t)(WIDTH / n - 2), (uint16_t)(HEIGHT / n - 1)}, {0, 0, 0, 0}};
    smr_readout readout;
    smr_frame frame;
    int x, y, i, k;
    expose(YUYV, 5);
    HOLD(smr_readout_begin_shrunk(&readout, &SMR_YUYV, WIDTH, HEIGHT, (uint16_t)n, windows, read_pixels, sizeof read_pixels) == SMR_OK);
    HOLD(smr_readout_lines(&readout, sent, sizeof sent, STRIDE) == SMR_OK);
    HOLD(smr_readout_frame(&readout, &frame) == SMR_OK);
    HOLD(frame.width == WIDTH / n && frame.height == HEIGHT / n);
    for (y = 0; y < windows[0].height; y++) {
        for (x = 0; x < windows[0].width; x++) {
            int mean = 0;
            for (k = 1; k <= n; k++) {
                const uint8_t *of = gray + ((y + 1) * n + k - 1) * WIDTH + (x + 2) * n;
                int sum = 0;
                for (i = 0; i < n; i++) sum += of[i];
                mean += ((((2 * sum + n) / (2 * n)) - mean) * ((65536 + k - 1) / k) + 32768 + (1 << 24)) / 65536 - 256;
            }
            HOLD(frame.parts[0].pixels[y * windows[0].width + x] == mean);
        }
    }
}

int main(void)
{
    int format;
    shrunk(1);
    shrunk(2);
    shrunk(3);
    shrunk(4);
    for (format = GRAY8; format <= GRAY10; format++) {
        two_windows(format);
        follow(format);
    }
    printf("%u checks of the read-out, %u failed\n", tried, failed);
    return failed != 0;
}
