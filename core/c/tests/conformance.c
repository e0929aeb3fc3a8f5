/*
 * Checks that the library's answers equal those of a flight record (tests/vectors), number by number.
 *
 *     conformance FILE
 *
 * Two trackers with a common workspace get every frame. The first gets a whole frame, black where the record has no pixels, and its
 * own flight record must have the same bytes. The second gets only the parts that it reads and updates in steps; after each frame it
 * is saved and restored. Each flight ends with the saved target. Nothing is allocated.
 */

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "smr.h"

#define FRAME_PIXELS 8192

typedef union storage {
    smr_paper_target paper;
    smr_robust_target robust;
    smr_robust_small_target small;
} storage;

static uint8_t record[256 * 1024];
static size_t size, recorded;
static unsigned flights, answers;
static storage whole_storage, part_storage;
static union {
    smr_paper_workspace paper;
    smr_robust_workspace robust;
    smr_robust_small_workspace small;
} shared_workspace;
static uint8_t pixels[FRAME_PIXELS];

static void must(int is, const char *what)
{
    if (!is) {
        fprintf(stderr, "conformance: flight %u, answer %u: %s\n", flights, answers, what);
        exit(EXIT_FAILURE);
    }
}

static void ok(smr_status status)
{
    must(status == SMR_OK, smr_status_name(status));
}

/* The recorder's `write`: compares the bytes that a tracker records with those of the given flight record. */
static int32_t same(void *context, const uint8_t *bytes, size_t count)
{
    (void)context;
    must(count <= size - recorded && memcmp(record + recorded, bytes, count) == 0, "other bytes are recorded");
    recorded += count;
    return 0;
}

static smr_tracker *made(storage *memory, const smr_config *config)
{
    smr_tracker *tracker;
    ok(smr_init(memory, sizeof *memory, &shared_workspace, sizeof shared_workspace, config, &tracker));
    return tracker;
}

static smr_frame whole_frame(const smr_frame *parts)
{
    smr_frame frame;
    int i, y;
    must((size_t)parts->width * parts->height <= sizeof pixels, "the frame is too large for this test");
    memset(&frame, 0, sizeof frame);
    memset(pixels, 0, sizeof pixels);
    for (i = 0; i < 2; i++) {
        const smr_part *part = &parts->parts[i];
        for (y = 0; y < part->height; y++) {
            memcpy(pixels + (part->y + y) * parts->width + part->x, part->pixels + (size_t)y * part->stride, part->width);
        }
    }
    frame.width = frame.parts[0].width = parts->width;
    frame.height = frame.parts[0].height = parts->height;
    frame.parts[0].pixels = pixels;
    frame.parts[0].size = (size_t)parts->width * parts->height;
    frame.parts[0].stride = parts->width;
    return frame;
}

/* Updates in steps. Fails if the robust tracker completes the update in one step. */
static void update_in_steps(smr_tracker *tracker, const smr_frame *frame, int is_robust, smr_answer *answer)
{
    smr_status status;
    unsigned steps = 0;
    while ((status = smr_update_step(tracker, frame, is_robust ? 5000 : 50, answer)) == SMR_UNDER_WAY) {
        steps++;
    }
    ok(status);
    must(!is_robust || steps > 0, "an update was not cut");
}

static void compare(const smr_tracker *tracker, const smr_answer *answer, const smr_answer *wanted)
{
    smr_fine_rect last;
    smr_state state;
    must(memcmp(answer, wanted, offsetof(smr_answer, found_again) + 1) == 0, "another answer");
    ok(smr_last(tracker, &last, &state));
    must(memcmp(&last, &wanted->fine, sizeof last) == 0 && state == wanted->state, "another box or state is remembered");
}

static const uint8_t *saved(const smr_tracker *tracker, size_t *written)
{
    static uint8_t bytes[SMR_PAPER_SAVED_SIZE > SMR_ROBUST_SAVED_SIZE ? SMR_PAPER_SAVED_SIZE : SMR_ROBUST_SAVED_SIZE];
    ok(smr_save(tracker, bytes, sizeof bytes, written));
    return bytes;
}

static void run(void)
{
    smr_recorder recorder = {same, NULL, 0, 0, NULL};
    smr_tracker *whole = NULL, *part = NULL;
    smr_frame frame, all;
    smr_config config;
    smr_answer answer;
    smr_entry entry;
    size_t at = 0, written;
    int is_robust = 0;
    while (ok(smr_next_entry(record, size, &at, &entry)), entry.kind != SMR_ENTRY_END) {
        switch (entry.kind) {
        case SMR_ENTRY_BEGIN:
            flights++;
            is_robust = entry.is_robust;
            ok(entry.is_small ? smr_config_small(&config) : is_robust ? smr_config_robust(&config) : smr_config_paper(&config));
            config.paper = entry.paper;
            config.robust = entry.robust;
            whole = made(&whole_storage, &config);
            ok(smr_record(whole, &recorder));
            part = made(&part_storage, &config);
            break;
        case SMR_ENTRY_LOCK:
            all = whole_frame(&entry.frame);
            ok(smr_lock(whole, &all, &entry.bbox));
            ok(smr_lock(part, &entry.frame, &entry.bbox));
            break;
        case SMR_ENTRY_MOVED:
            ok(smr_moved(whole, entry.right, entry.down));
            ok(smr_moved(part, entry.right, entry.down));
            break;
        case SMR_ENTRY_WINDOW:
            frame = entry.frame;
            break;
        case SMR_ENTRY_ANSWER:
            answers++;
            all = whole_frame(&frame);
            ok(smr_update(whole, &all, &answer));
            compare(whole, &answer, &entry.answer);
            update_in_steps(part, &frame, is_robust, &answer);
            compare(part, &answer, &entry.answer);
            {
                const uint8_t *bytes = saved(part, &written);
                must(made(&part_storage, &config) == part, "another tracker in the same storage");
                ok(smr_restore(part, bytes, written));
            }
            break;
        case SMR_ENTRY_RESTORED:
            must(memcmp(saved(whole, &written), entry.saved, entry.saved_size) == 0 && written == entry.saved_size, "another target is saved");
            must(memcmp(saved(part, &written), entry.saved, entry.saved_size) == 0, "another target is saved after steps");
            ok(smr_restore(whole, entry.saved, entry.saved_size));
            break;
        default:
            must(0, "an unknown entry");
        }
    }
    must(recorded == size && recorder.failed == 0, "fewer bytes are recorded");
}

int main(int argc, char **argv)
{
    FILE *file = argc == 2 ? fopen(argv[1], "rb") : NULL;
    if (file == NULL) {
        fprintf(stderr, "usage: conformance FILE (a readable flight record)\n");
        return EXIT_FAILURE;
    }
    size = fread(record, 1, sizeof record, file);
    must(size < sizeof record, "the record is too large for this test");
    fclose(file);
    run();
    printf("conformance, %u flights, %u answers, with whole frames and with parts, and the bytes that are recorded: all equal\n", flights, answers);
    return answers > 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
