/*
 * The library gives the answers of the conformance vectors (tests/vectors/README.md), number by number.
 *
 *     conformance FILE
 *
 * Every frame goes to two trackers: to one as a whole, to the other only the part that it asks for. Neither the tracker
 * nor the reading of the vectors allocates.
 */

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "smr.h"

#define FRAME_PIXELS 1536
#define STRIDE_GAP 5

typedef struct expected {
    int32_t x, y, peak_x, peak_y;
    smr_state state;
    uint32_t ratio, runner_up_ratio, alpha, score, runner_up, has_runner_up, template_hash;
} expected;

typedef struct camera {
    uint16_t width, height;
    uint8_t pixels[FRAME_PIXELS];
    uint8_t part[FRAME_PIXELS * 2]; /* rows with a gap between them */
} camera;

static FILE *vectors;
static unsigned line = 1;
static char name[32];
static smr_storage whole_storage, part_storage;
static camera sensor;

static void stop(const char *what)
{
    fprintf(stderr, "conformance: line %u, case %s: %s\n", line, name, what);
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

static long number(int base)
{
    char word[16], *end;
    long value;
    read_word(word, sizeof word);
    value = strtol(word, &end, base);
    if (end == word || *end != '\0') {
        stop("not a number");
    }
    return value;
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

static smr_fraction fraction(void)
{
    smr_fraction value;
    value.numerator = (uint16_t)number(10);
    value.denominator = (uint16_t)number(10);
    return value;
}

static smr_margins margins(void)
{
    smr_margins margins;
    margins.left = (uint16_t)number(10);
    margins.top = (uint16_t)number(10);
    margins.right = (uint16_t)number(10);
    margins.bottom = (uint16_t)number(10);
    return margins;
}

static smr_radius radius(void)
{
    smr_radius value;
    value.x = (uint16_t)number(10);
    value.y = (uint16_t)number(10);
    return value;
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

static expected read_answer(void)
{
    expected answer;
    char state[16];
    answer.x = (int32_t)number(10);
    answer.y = (int32_t)number(10);
    read_word(state, sizeof state);
    answer.state = strcmp(state, "tracking") == 0 ? SMR_TRACKING : strcmp(state, "leaving") == 0 ? SMR_LEAVING : SMR_LOST;
    if (answer.state == SMR_LOST && strcmp(state, "lost") != 0) {
        stop("not a state");
    }
    answer.ratio = unsigned_number(10);
    answer.runner_up_ratio = unsigned_number(10);
    answer.alpha = unsigned_number(10);
    answer.peak_x = (int32_t)number(10);
    answer.peak_y = (int32_t)number(10);
    answer.score = unsigned_number(10);
    answer.runner_up = unsigned_number(10);
    answer.has_runner_up = unsigned_number(10);
    answer.template_hash = unsigned_number(16);
    return answer;
}

/* Sets a number of the configuration; false if there is none of that name. */
static int set(smr_config *config, smr_table *table, const char *keyword)
{
#define NUMBER(word, place, type) \
    if (strcmp(keyword, word) == 0) { \
        (place) = (type)number(10); \
        return 1; \
    }
#define PAIR(word, place, read) \
    if (strcmp(keyword, word) == 0) { \
        (place) = read(); \
        return 1; \
    }
    if (strcmp(keyword, "scale") == 0) {
        must(smr_table_init(table, (uint16_t)number(10)));
        config->table = table;
        return 1;
    }
    NUMBER("first_threshold", config->first_threshold, uint8_t)
    NUMBER("least_threshold", config->least_threshold, uint8_t)
    NUMBER("padding", config->padding, uint16_t)
    NUMBER("growth", config->growth, uint16_t)
    NUMBER("neighbourhood", config->neighbourhood, uint16_t)
    NUMBER("gate_lead", config->gate.lead, uint16_t)
    NUMBER("gate_least_ratio", config->gate.least_ratio, uint16_t)
    NUMBER("runner_up_always", config->runner_up_always, uint8_t)
    PAIR("k", config->k, fraction)
    PAIR("gate_tracking", config->gate.tracking, fraction)
    PAIR("gate_leaving", config->gate.leaving, fraction)
    PAIR("gate_returning", config->gate.returning, fraction)
    PAIR("gate_lost", config->gate.lost, fraction)
    PAIR("window", config->window, radius)
    PAIR("window_limit", config->window_limit, radius)
    PAIR("update_zone", config->update_zone, margins)
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

static uint32_t template_hash(const smr_tracker *tracker)
{
    smr_image image;
    uint32_t hash = 0x811C9DC5u;
    size_t i;
    must(smr_template(tracker, &image));
    for (i = 0; i < (size_t)image.width * image.height; i++) {
        hash = (hash ^ image.pixels[i]) * 0x01000193u;
    }
    return hash;
}

static void compare(const char *what, uint32_t answered, uint32_t wanted)
{
    if (answered != wanted) {
        fprintf(stderr, "conformance: %s is %" PRId32 ", should be %" PRId32 "\n", what, (int32_t)answered, (int32_t)wanted);
        stop("another answer");
    }
}

static void compare_answer(const smr_tracker *tracker, const smr_answer *answer, const expected *wanted)
{
    compare("box x", (uint32_t)answer->bbox.x, (uint32_t)wanted->x);
    compare("box y", (uint32_t)answer->bbox.y, (uint32_t)wanted->y);
    compare("state", (uint32_t)answer->state, (uint32_t)wanted->state);
    compare("ratio", answer->ratio, wanted->ratio);
    compare("runner-up ratio", answer->runner_up_ratio, wanted->runner_up_ratio);
    compare("alpha", answer->alpha, wanted->alpha);
    compare("peak x", (uint32_t)answer->peak.x, (uint32_t)wanted->peak_x);
    compare("peak y", (uint32_t)answer->peak.y, (uint32_t)wanted->peak_y);
    compare("peak score", answer->peak.score, wanted->score);
    compare("runner-up score", answer->runner_up, wanted->runner_up);
    compare("has runner-up", answer->has_runner_up, wanted->has_runner_up);
    compare("hash of the template", template_hash(tracker), wanted->template_hash);
}

/* ---- one case after the other ---- */

static smr_tracker *start(smr_storage *storage, const smr_config *config, const smr_rect *target)
{
    smr_frame frame = whole_frame();
    smr_tracker *tracker;
    must(smr_init(storage, sizeof *storage, config, &tracker));
    must(smr_lock(tracker, &frame, target));
    return tracker;
}

/* In steps of less than any frame needs, and the tracker is left alone between them. */
static void update_in_steps(smr_tracker *tracker, const smr_frame *frame, smr_answer *answer)
{
    uint8_t done = 0;
    must(smr_begin(tracker, frame));
    while (!done) {
        must(smr_step(tracker, frame, 50, &done));
    }
    must(smr_finish(tracker, frame, answer));
}

static void update_both(smr_tracker *whole, smr_tracker *part, smr_answer answers[2])
{
    smr_frame frame = whole_frame();
    smr_rect window;
    must(smr_update(whole, &frame, &answers[0]));
    must(smr_window(part, &window));
    frame = part_of_frame(&window);
    update_in_steps(part, &frame, &answers[1]);
}

static void run(unsigned *cases, unsigned *compared)
{
    static smr_table table; /* trackers read it as long as they live */
    smr_tracker *whole = NULL, *part = NULL;
    smr_answer answers[2];
    smr_config config;
    char keyword[24];
    int last;

    for (; (last = read_word(keyword, sizeof keyword)) != EOF; line++) {
        if (keyword[0] == '\0' || keyword[0] == '#') {
            skip_line(last);
        } else if (strcmp(keyword, "smr-vectors") == 0) {
            if (number(10) != 3) {
                stop("another version of the vectors");
            }
        } else if (strcmp(keyword, "case") == 0) {
            read_word(name, sizeof name);
            must(smr_config_paper(&config));
            whole = part = NULL;
            ++*cases;
        } else if (strcmp(keyword, "size") == 0) {
            sensor.width = (uint16_t)number(10);
            sensor.height = (uint16_t)number(10);
        } else if (strcmp(keyword, "lock") == 0) {
            smr_rect target;
            target.x = (int32_t)number(10);
            target.y = (int32_t)number(10);
            target.width = (uint16_t)number(10);
            target.height = (uint16_t)number(10);
            read_pixels();
            whole = start(&whole_storage, &config, &target);
            part = start(&part_storage, &config, &target);
        } else if (strcmp(keyword, "frame") == 0) {
            read_pixels();
            update_both(whole, part, answers);
        } else if (strcmp(keyword, "answer") == 0) {
            expected wanted = read_answer();
            compare_answer(whole, &answers[0], &wanted);
            compare_answer(part, &answers[1], &wanted);
            ++*compared;
        } else if (!set(&config, &table, keyword)) {
            stop("an unknown line");
        }
    }
}

int main(int argc, char **argv)
{
    unsigned cases = 0, compared = 0;
    vectors = argc == 2 ? fopen(argv[1], "r") : NULL;
    if (vectors == NULL) {
        fprintf(stderr, "conformance: give the file of the vectors, one that can be read\n");
        return EXIT_FAILURE;
    }
    run(&cases, &compared);
    fclose(vectors);
    printf("conformance: %u cases, %u answers, each of a whole frame and of a part: all equal\n", cases, compared);
    return compared > 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
