/*
 * The library's robust tracker gives the answers of its vectors (tests/vectors/README.md), number by number.
 *
 *     robust_conformance FILE
 *
 * Every frame goes to two trackers: to one as a whole, to the other only the part that it asks for. Neither the tracker
 * nor the reading of the vectors allocates.
 */

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "smr.h"

#define FRAME_PIXELS 8192
#define STRIDE_GAP 5

typedef struct expected {
    smr_fine_rect fine;
    smr_robust_state state;
    uint32_t confidence, ratio, scale, found_again, early;
    int32_t response;
} expected;

typedef struct camera {
    uint16_t width, height;
    uint8_t pixels[FRAME_PIXELS];
    uint8_t part[FRAME_PIXELS * 2]; /* rows with a gap between them */
} camera;

static FILE *vectors;
static unsigned line = 1;
static char name[32];
static smr_robust_storage whole_storage, part_storage;
static camera sensor;

static void stop(const char *what)
{
    fprintf(stderr, "robust_conformance: line %u, case %s: %s\n", line, name, what);
    exit(EXIT_FAILURE);
}

static void must(smr_status status)
{
    if (status != SMR_OK) {
        stop(smr_status_name(status));
    }
}

/* ---- reading ---- */

/* The next word of the line into `word`, and the character that ended it: ' ', '\n' or EOF. */
static int read_word(char *word, size_t size)
{
    size_t length = 0;
    int c = getc(vectors);
    while (c != ' ' && c != '\n' && c != EOF) {
        if (length + 1 >= size) {
            stop("a word is too long");
        }
        word[length++] = (char)c;
        c = getc(vectors);
    }
    word[length] = '\0';
    return c;
}

static void skip_line(int last)
{
    while (last != '\n' && last != EOF) {
        last = getc(vectors);
    }
}

static int32_t number(void)
{
    char word[16], *end;
    long value;
    read_word(word, sizeof word);
    value = strtol(word, &end, 10);
    if (end == word || *end != '\0') {
        stop("not a number");
    }
    return (int32_t)value;
}

static uint32_t unsigned_number(int base)
{
    char word[16], *end;
    unsigned long value;
    read_word(word, sizeof word);
    value = strtoul(word, &end, base);
    if (end == word || *end != '\0') {
        stop("not a number");
    }
    return (uint32_t)value;
}

static unsigned digit(void)
{
    int c = getc(vectors);
    if (c >= '0' && c <= '9') {
        return (unsigned)(c - '0');
    }
    if (c >= 'a' && c <= 'f') {
        return (unsigned)(c - 'a') + 10u;
    }
    stop("not a hexadecimal digit");
    return 0;
}

static void read_pixels(void)
{
    size_t i, count = (size_t)sensor.width * sensor.height;
    if (count > FRAME_PIXELS) {
        stop("the frame is too large for this test");
    }
    for (i = 0; i < count; i++) {
        unsigned high = digit();
        sensor.pixels[i] = (uint8_t)(high * 16 + digit());
    }
    if (getc(vectors) != '\n') {
        stop("more pixels than the frame has");
    }
}

static smr_robust_state read_state(void)
{
    char word[16];
    read_word(word, sizeof word);
    if (strcmp(word, "tracking") == 0) {
        return SMR_ROBUST_TRACKING;
    }
    if (strcmp(word, "uncertain") == 0) {
        return SMR_ROBUST_UNCERTAIN;
    }
    if (strcmp(word, "lost") != 0) {
        stop("not a state");
    }
    return SMR_ROBUST_LOST;
}

static expected read_answer(void)
{
    expected answer;
    answer.fine.x = number();
    answer.fine.y = number();
    answer.fine.width = unsigned_number(10);
    answer.fine.height = unsigned_number(10);
    answer.state = read_state();
    answer.confidence = unsigned_number(10);
    answer.ratio = unsigned_number(10);
    answer.response = number();
    answer.scale = unsigned_number(10);
    answer.found_again = unsigned_number(10);
    answer.early = unsigned_number(16);
    unsigned_number(16); /* of the weights, which C does not see: every later answer depends on them */
    return answer;
}

/* Sets a part of the configuration; false if there is none of that name. */
static int set(smr_robust_config *config, const char *keyword)
{
#define PART(word, place) \
    if (strcmp(keyword, word) == 0) { \
        (place) = (uint8_t)number(); \
        return 1; \
    }
    PART("velocity", config->velocity)
    PART("near", config->near)
    PART("size_part", config->size)
    PART("verification", config->verification)
    PART("caution", config->caution)
    PART("sweep", config->sweep)
    return 0;
}

/* ---- the two ways to give a frame ---- */

static smr_frame whole_frame(void)
{
    smr_frame frame;
    frame.pixels = sensor.pixels;
    frame.size = (size_t)sensor.width * sensor.height;
    frame.stride = sensor.width;
    frame.width = frame.full_width = sensor.width;
    frame.height = frame.full_height = sensor.height;
    frame.x = frame.y = 0;
    return frame;
}

static smr_frame part_of_frame(const smr_rect *part)
{
    smr_frame frame = whole_frame();
    unsigned y;
    frame.pixels = sensor.part;
    frame.stride = (size_t)part->width + STRIDE_GAP;
    frame.size = (size_t)(part->height - 1) * frame.stride + part->width;
    frame.width = part->width;
    frame.height = part->height;
    frame.x = (uint16_t)part->x;
    frame.y = (uint16_t)part->y;
    if (frame.size > sizeof sensor.part) {
        stop("the part is too large for this test");
    }
    memset(sensor.part, 0xA5, sizeof sensor.part);
    for (y = 0; y < part->height; y++) {
        memcpy(sensor.part + y * frame.stride, sensor.pixels + ((size_t)part->y + y) * sensor.width + (size_t)part->x,
               part->width);
    }
    return frame;
}

/* ---- comparing ---- */

static uint32_t hash(const smr_image *image)
{
    uint32_t hash = 0x811C9DC5u;
    size_t i;
    for (i = 0; i < (size_t)image->width * image->height; i++) {
        hash = (hash ^ image->pixels[i]) * 0x01000193u;
    }
    return hash;
}

static void compare(const char *what, uint32_t answered, uint32_t wanted)
{
    if (answered != wanted) {
        fprintf(stderr, "robust_conformance: %s is %" PRId32 ", should be %" PRId32 "\n", what, (int32_t)answered,
                (int32_t)wanted);
        stop("another answer");
    }
}

/* The whole pixel that an edge of the fine box is rounded to. */
static int32_t rounded(int64_t edge)
{
    return (int32_t)((edge + 128 + 256 * (int64_t)65536) / 256 - 65536);
}

static void compare_boxes(const smr_robust_answer *answer, const smr_fine_rect *wanted)
{
    const smr_rect *bbox = &answer->bbox;
    compare("box x", (uint32_t)answer->fine.x, (uint32_t)wanted->x);
    compare("box y", (uint32_t)answer->fine.y, (uint32_t)wanted->y);
    compare("box width", answer->fine.width, wanted->width);
    compare("box height", answer->fine.height, wanted->height);
    compare("left edge", (uint32_t)bbox->x, (uint32_t)rounded(wanted->x));
    compare("upper edge", (uint32_t)bbox->y, (uint32_t)rounded(wanted->y));
    compare("right edge", (uint32_t)(bbox->x + bbox->width), (uint32_t)rounded((int64_t)wanted->x + wanted->width));
    compare("lower edge", (uint32_t)(bbox->y + bbox->height), (uint32_t)rounded((int64_t)wanted->y + wanted->height));
}

static void compare_answer(const smr_robust_tracker *tracker, const smr_robust_answer *answer, const expected *wanted)
{
    static uint8_t pixels[SMR_ROBUST_PIXELS];
    smr_image image;
    compare_boxes(answer, &wanted->fine);
    compare("state", (uint32_t)answer->state, (uint32_t)wanted->state);
    compare("confidence", answer->confidence, wanted->confidence);
    compare("ratio", answer->ratio, wanted->ratio);
    compare("response", (uint32_t)answer->response, (uint32_t)wanted->response);
    compare("scale", answer->scale, wanted->scale);
    compare("found again", answer->found_again, wanted->found_again);
    must(smr_robust_early_template(tracker, pixels, sizeof pixels, &image));
    compare("hash of the early template", hash(&image), wanted->early);
}

/* ---- one case after the other ---- */

static smr_robust_tracker *start(smr_robust_storage *storage, const smr_robust_config *config, const smr_frame *frame,
                                 const smr_rect *target)
{
    smr_robust_tracker *tracker;
    must(smr_robust_init(storage, sizeof *storage, config, &tracker));
    must(smr_robust_lock(tracker, frame, target));
    return tracker;
}

static smr_frame lock_window(const smr_rect *target)
{
    smr_rect window;
    must(smr_robust_lock_window(sensor.width, sensor.height, target, &window));
    return part_of_frame(&window);
}

static void update_both(smr_robust_tracker *whole, smr_robust_tracker *part, smr_robust_answer answers[2])
{
    smr_frame frame = whole_frame();
    smr_rect window;
    must(smr_robust_update(whole, &frame, &answers[0]));
    must(smr_robust_window(part, &window));
    frame = part_of_frame(&window);
    must(smr_robust_update(part, &frame, &answers[1]));
}

static void run(unsigned *cases, unsigned *compared)
{
    smr_robust_tracker *whole = NULL, *part = NULL;
    smr_robust_answer answers[2];
    smr_robust_config config;
    char keyword[24];
    int last;

    for (; (last = read_word(keyword, sizeof keyword)) != EOF; line++) {
        if (keyword[0] == '\0' || keyword[0] == '#') {
            skip_line(last);
        } else if (strcmp(keyword, "smr-robust-vectors") == 0) {
            if (number() != 2) {
                stop("another version of the vectors");
            }
        } else if (strcmp(keyword, "case") == 0) {
            read_word(name, sizeof name);
            must(smr_robust_config_default(&config));
            whole = part = NULL;
            ++*cases;
        } else if (strcmp(keyword, "size") == 0) {
            sensor.width = (uint16_t)number();
            sensor.height = (uint16_t)number();
        } else if (strcmp(keyword, "lock") == 0) {
            smr_frame frame;
            smr_rect target;
            target.x = number();
            target.y = number();
            target.width = (uint16_t)number();
            target.height = (uint16_t)number();
            read_pixels();
            frame = whole_frame();
            whole = start(&whole_storage, &config, &frame, &target);
            frame = lock_window(&target);
            part = start(&part_storage, &config, &frame, &target);
        } else if (strcmp(keyword, "frame") == 0) {
            read_pixels();
            update_both(whole, part, answers);
        } else if (strcmp(keyword, "answer") == 0) {
            expected wanted = read_answer();
            compare_answer(whole, &answers[0], &wanted);
            compare_answer(part, &answers[1], &wanted);
            ++*compared;
        } else if (!set(&config, keyword)) {
            stop("an unknown line");
        }
    }
}

int main(int argc, char **argv)
{
    unsigned cases = 0, compared = 0;
    vectors = argc == 2 ? fopen(argv[1], "r") : NULL;
    if (vectors == NULL) {
        fprintf(stderr, "robust_conformance: give the file of the vectors, one that can be read\n");
        return EXIT_FAILURE;
    }
    run(&cases, &compared);
    fclose(vectors);
    printf("robust_conformance: %u cases, %u answers, each of a whole frame and of a part: all equal\n", cases, compared);
    return compared > 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
