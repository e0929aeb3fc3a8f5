/*
 * The library's answers are those of the conformance vectors (tests/vectors/README.md), number by number.
 *
 *     conformance FILE
 *
 * The first line of the file names the tracker. Every frame goes to two trackers that share a workspace. The first gets the whole
 * frame. The second gets only the parts that it needs and updates in steps; it is saved and restored after each frame. Nothing is
 * allocated.
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
    smr_state state;
    uint32_t confidence, ratio, runner_up_ratio, has_runner_up, alpha, scale, found_again, template_hash;
} expected;

typedef struct camera {
    uint16_t width, height;
    uint8_t pixels[FRAME_PIXELS];
    uint8_t parts[2][FRAME_PIXELS * 2]; /* rows with gaps between them */
} camera;

typedef union storage {
    smr_paper_target paper;
    smr_robust_target robust;
} storage;

typedef union workspace {
    smr_paper_workspace paper;
    smr_robust_workspace robust;
} workspace;

static FILE *vectors;
static unsigned line = 1;
static char name[32];
static int robust; /* the tracker of the vectors */
static storage whole_storage, part_storage;
static workspace shared_workspace;
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

/* Reads the next word of the line into `word`. Returns the character after it: ' ', '\n' or EOF. */
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

static int32_t signed_number(void)
{
    return (int32_t)number(10);
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

static smr_state read_state(void)
{
    static const char *const names[] = {"tracking", "leaving", "uncertain", "lost"};
    char word[16];
    int state;
    read_word(word, sizeof word);
    for (state = SMR_TRACKING; state <= SMR_LOST; state++) {
        if (strcmp(word, names[state]) == 0) {
            return (smr_state)state;
        }
    }
    stop("not a state");
    return SMR_LOST;
}

static expected read_paper_answer(const smr_rect *locked)
{
    expected answer;
    unsigned i;
    answer.fine.x = signed_number() * 256;
    answer.fine.y = signed_number() * 256;
    answer.fine.width = locked->width * 256u;
    answer.fine.height = locked->height * 256u;
    answer.state = read_state();
    answer.ratio = unsigned_number(10);
    answer.confidence = answer.state == SMR_LOST ? 0 : answer.ratio;
    answer.runner_up_ratio = unsigned_number(10);
    answer.alpha = unsigned_number(10);
    for (i = 0; i < 4; i++) {
        signed_number(); /* the peak and the runner-up's score, which the C interface does not show */
    }
    answer.has_runner_up = unsigned_number(10);
    answer.template_hash = unsigned_number(16);
    answer.scale = 65536;
    return answer;
}

static expected read_robust_answer(void)
{
    expected answer;
    answer.fine.x = signed_number();
    answer.fine.y = signed_number();
    answer.fine.width = unsigned_number(10);
    answer.fine.height = unsigned_number(10);
    answer.state = read_state();
    answer.confidence = unsigned_number(10);
    answer.ratio = unsigned_number(10);
    signed_number(); /* the response, which the C interface does not show */
    answer.scale = unsigned_number(10);
    answer.found_again = unsigned_number(10);
    answer.template_hash = unsigned_number(16);
    unsigned_number(16); /* hash of the weights, which the C interface does not show: later answers depend on them */
    answer.runner_up_ratio = answer.has_runner_up = answer.alpha = 0;
    return answer;
}

/* Sets a number of the configuration. Returns 0 if it has none of that name. */
static int set(smr_config *config, const char *keyword)
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
    NUMBER("first_threshold", config->paper.first_threshold, uint8_t)
    NUMBER("least_threshold", config->paper.least_threshold, uint8_t)
    NUMBER("padding", config->paper.padding, uint16_t)
    NUMBER("growth", config->paper.growth, uint16_t)
    NUMBER("neighbourhood", config->paper.neighbourhood, uint16_t)
    NUMBER("gate_lead", config->paper.gate_lead, uint16_t)
    NUMBER("gate_least_ratio", config->paper.least_ratio, uint16_t)
    NUMBER("runner_up_always", config->paper.runner_up_always, uint8_t)
    PAIR("k", config->paper.k, fraction)
    PAIR("gate_tracking", config->paper.gate_tracking, fraction)
    PAIR("gate_leaving", config->paper.gate_leaving, fraction)
    PAIR("gate_returning", config->paper.gate_returning, fraction)
    PAIR("gate_lost", config->paper.gate_lost, fraction)
    PAIR("window", config->paper.window, radius)
    PAIR("window_limit", config->paper.window_limit, radius)
    PAIR("update_zone", config->paper.update_zone, margins)
    NUMBER("size_part", config->robust.size, uint8_t)
    NUMBER("sweep", config->robust.sweep, uint8_t)
    NUMBER("refiner", config->robust.refiner, uint8_t)
    NUMBER("reach", config->robust.reach, uint8_t)
    NUMBER("patience", config->robust.patience, uint8_t)
    NUMBER("lost_below", config->robust.lost_below, uint16_t)
    NUMBER("uncertain_below", config->robust.uncertain_below, uint16_t)
    NUMBER("learning_rate", config->robust.learning_rate, uint16_t)
    NUMBER("early_rate", config->robust.early_rate, uint16_t)
    return 0;
}

/* ---- whole frames and parts ---- */

static smr_frame whole_frame(void)
{
    smr_frame frame;
    memset(&frame, 0, sizeof frame);
    frame.width = frame.parts[0].width = sensor.width;
    frame.height = frame.parts[0].height = sensor.height;
    frame.parts[0].pixels = sensor.pixels;
    frame.parts[0].size = (size_t)sensor.width * sensor.height;
    frame.parts[0].stride = sensor.width;
    return frame;
}

/* Reads `window` out of the sensor. The part is empty if the window is. */
static smr_part read_out(unsigned which, const smr_rect *window)
{
    smr_part part;
    uint8_t *pixels = sensor.parts[which];
    unsigned y;
    memset(&part, 0, sizeof part);
    if (window->width == 0) {
        return part;
    }
    part.pixels = pixels;
    part.stride = (size_t)window->width + STRIDE_GAP;
    part.size = (size_t)(window->height - 1) * part.stride + window->width;
    part.width = window->width;
    part.height = window->height;
    part.x = (uint16_t)window->x;
    part.y = (uint16_t)window->y;
    if (part.size > sizeof sensor.parts[which]) {
        stop("the part is too large for this test");
    }
    memset(pixels, 0xA5, sizeof sensor.parts[which]);
    for (y = 0; y < window->height; y++) {
        memcpy(pixels + y * part.stride, sensor.pixels + ((size_t)window->y + y) * sensor.width + (size_t)window->x,
               window->width);
    }
    return part;
}

static smr_frame frame_of(const smr_rect *window, const smr_rect *sweep)
{
    smr_frame frame;
    frame.width = sensor.width;
    frame.height = sensor.height;
    frame.parts[0] = read_out(0, window);
    frame.parts[1] = read_out(1, sweep);
    return frame;
}

/* ---- comparing ---- */

static uint32_t template_hash(const smr_tracker *tracker)
{
    static uint8_t pixels[SMR_PIXELS > SMR_ROBUST_PIXELS ? SMR_PIXELS : SMR_ROBUST_PIXELS];
    smr_image image;
    uint32_t hash = 0x811C9DC5u;
    size_t i;
    must(smr_template(tracker, pixels, sizeof pixels, &image));
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

/* An edge of the fine box, rounded to whole pixels. */
static int32_t rounded(int64_t edge)
{
    return (int32_t)((edge + 128 + 256 * (int64_t)65536) / 256 - 65536);
}

static void compare_boxes(const smr_answer *answer, const smr_fine_rect *wanted)
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

static void compare_answer(const smr_tracker *tracker, const smr_answer *answer, const expected *wanted)
{
    smr_fine_rect last;
    smr_state state;
    compare_boxes(answer, &wanted->fine);
    compare("state", (uint32_t)answer->state, (uint32_t)wanted->state);
    compare("confidence", answer->confidence, wanted->confidence);
    compare("ratio", answer->ratio, wanted->ratio);
    compare("runner-up ratio", answer->runner_up_ratio, wanted->runner_up_ratio);
    compare("has runner-up", answer->has_runner_up, wanted->has_runner_up);
    compare("alpha", answer->alpha, wanted->alpha);
    compare("scale", answer->scale, wanted->scale);
    compare("found again", answer->found_again, wanted->found_again);
    compare("hash of the template", template_hash(tracker), wanted->template_hash);
    must(smr_last(tracker, &last, &state));
    compare("box that is remembered", (uint32_t)memcmp(&last, &answer->fine, sizeof last), 0);
    compare("state that is remembered", (uint32_t)state, (uint32_t)answer->state);
}

/* ---- running the cases ---- */

static smr_tracker *made(storage *memory, const smr_config *config)
{
    smr_tracker *tracker;
    must(smr_init(memory, sizeof *memory, &shared_workspace, sizeof shared_workspace, config, &tracker));
    return tracker;
}

/* In steps that are shorter than any update. */
static void update_in_steps(smr_tracker *tracker, const smr_frame *frame, smr_answer *answer)
{
    uint32_t work = robust ? 5000 : 50;
    unsigned steps = 1;
    smr_status status;
    while ((status = smr_update_step(tracker, frame, work, answer)) == SMR_UNDER_WAY) {
        steps++;
    }
    must(status);
    if (robust && steps < 2) {
        stop("an update was not cut");
    }
}

static void save_and_restore(smr_tracker *tracker, const smr_config *config)
{
    static uint8_t saved[SMR_PAPER_SAVED_SIZE > SMR_ROBUST_SAVED_SIZE ? SMR_PAPER_SAVED_SIZE : SMR_ROBUST_SAVED_SIZE];
    size_t size, written;
    must(smr_saved_size(tracker, &size));
    must(smr_save(tracker, saved, size, &written));
    if (made(&part_storage, config) != tracker) {
        stop("another tracker in the same storage");
    }
    must(smr_restore(tracker, saved, written));
}

static void update_both(smr_tracker *whole, smr_tracker *part, const smr_config *config, smr_answer answers[2])
{
    smr_frame frame = whole_frame();
    smr_rect windows[2];
    must(smr_update(whole, &frame, &answers[0]));
    must(smr_windows(part, windows));
    frame = frame_of(&windows[0], &windows[1]);
    update_in_steps(part, &frame, &answers[1]);
    save_and_restore(part, config);
}

static void lock_both(smr_tracker *whole, smr_tracker *part, const smr_rect *target)
{
    static const smr_rect nothing = {0, 0, 0, 0};
    smr_frame frame = whole_frame();
    smr_rect window;
    must(smr_lock(whole, &frame, target));
    must(smr_lock_window(part, sensor.width, sensor.height, target, &window));
    frame = frame_of(&window, &nothing);
    must(smr_lock(part, &frame, target));
}

static void run(unsigned *cases, unsigned *compared)
{
    smr_tracker *whole = NULL, *part = NULL;
    smr_rect target = {0, 0, 0, 0};
    smr_answer answers[2];
    smr_config config;
    char keyword[24];
    int last, skipped = 0; /* a case with another scale: C has the paper's alone */

    for (; (last = read_word(keyword, sizeof keyword)) != EOF; line++) {
        if (keyword[0] == '\0' || keyword[0] == '#' || (skipped && strcmp(keyword, "case") != 0)) {
            skip_line(last);
        } else if (strcmp(keyword, "smr-vectors") == 0 || strcmp(keyword, "smr-robust-vectors") == 0) {
            robust = strcmp(keyword, "smr-robust-vectors") == 0;
            if (number(10) != 3) {
                stop("another version of the vectors");
            }
        } else if (strcmp(keyword, "case") == 0) {
            read_word(name, sizeof name);
            must(robust ? smr_config_robust(&config) : smr_config_paper(&config));
            config.robust.refiner = 0; /* a case says so if it is on */
            skipped = 0;
            ++*cases;
        } else if (strcmp(keyword, "size") == 0) {
            sensor.width = (uint16_t)number(10);
            sensor.height = (uint16_t)number(10);
        } else if (strcmp(keyword, "lock") == 0) {
            target.x = signed_number();
            target.y = signed_number();
            target.width = (uint16_t)number(10);
            target.height = (uint16_t)number(10);
            read_pixels();
            whole = made(&whole_storage, &config);
            part = made(&part_storage, &config);
            lock_both(whole, part, &target);
        } else if (strcmp(keyword, "frame") == 0) {
            read_pixels();
            update_both(whole, part, &config, answers);
        } else if (strcmp(keyword, "answer") == 0) {
            expected wanted = robust ? read_robust_answer() : read_paper_answer(&target);
            if (!robust) {
                wanted.found_again = answers[0].found_again; /* not in these vectors */
            }
            compare_answer(whole, &answers[0], &wanted);
            compare_answer(part, &answers[1], &wanted);
            ++*compared;
        } else if (strcmp(keyword, "scale") == 0) {
            skipped = number(10) != 255;
            *cases -= (unsigned)skipped;
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
        fprintf(stderr, "usage: conformance FILE (a readable file of vectors)\n");
        return EXIT_FAILURE;
    }
    run(&cases, &compared);
    fclose(vectors);
    printf("conformance, %s tracker: %u cases, %u answers, with whole frames and with parts: all equal\n",
           robust ? "robust" : "the paper's", cases, compared);
    return compared > 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
