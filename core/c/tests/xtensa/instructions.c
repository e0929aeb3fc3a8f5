/*
 * Counts the instructions of the updates of a flight record (tests/vectors) in QEMU, without those that stand in for MULUH and MULSH.
 *
 *     instructions FILE
 */

#include <stdio.h>
#include <stdlib.h>

#include "smr.h"

#define MULTIPLICATIONS 10000

/* The multiplications that start.s has computed. */
extern const volatile unsigned computed;

static uint8_t record[256 * 1024];
static union {
    smr_paper_target paper;
    smr_robust_target robust;
} storage;
static union {
    smr_paper_workspace paper;
    smr_robust_workspace robust;
} workspace;

static void ok(smr_status status)
{
    if (status == SMR_OK) return;
    fprintf(stderr, "instructions: %s\n", smr_status_name(status));
    exit(EXIT_FAILURE);
}

/* With -icount shift=0 the counter of cycles counts a hundred instructions. */
static unsigned hundreds(void)
{
    unsigned count;
    __asm__ volatile("rsr %0, ccount" : "=r"(count));
    return count;
}

/* The hundreds of instructions that MULTIPLICATIONS take, but for the two others in each round. */
static unsigned cost(void)
{
    unsigned rounds = MULTIPLICATIONS, upper, from = hundreds();
    __asm__ volatile("1: muluh %1, %0, %0\n addi %0, %0, -1\n bnez %0, 1b" : "+r"(rounds), "=&r"(upper));
    return hundreds() - from - MULTIPLICATIONS * 2 / 100;
}

int main(int argc, char **argv)
{
    FILE *file = argc == 2 ? fopen(argv[1], "rb") : NULL;
    size_t size, at = 0;
    unsigned updates = 0, taken = 0, multiplications = 0, each = cost();
    smr_tracker *tracker = NULL;
    smr_config config;
    smr_frame frame;
    smr_entry entry;
    smr_answer answer;
    if (file == NULL) return EXIT_FAILURE;
    size = fread(record, 1, sizeof record, file);
    fclose(file);
    while (ok(smr_next_entry(record, size, &at, &entry)), entry.kind != SMR_ENTRY_END) {
        if (entry.kind == SMR_ENTRY_BEGIN) {
            ok(entry.is_small ? smr_config_small(&config) : entry.is_robust ? smr_config_robust(&config) : smr_config_paper(&config));
            config.paper = entry.paper;
            config.robust = entry.robust;
            ok(smr_init(&storage, sizeof storage, &workspace, sizeof workspace, &config, &tracker));
        } else if (entry.kind == SMR_ENTRY_LOCK) {
            ok(smr_lock(tracker, &entry.frame, &entry.bbox));
        } else if (entry.kind == SMR_ENTRY_MOVED) {
            ok(smr_moved(tracker, entry.right, entry.down));
        } else if (entry.kind == SMR_ENTRY_WINDOW) {
            frame = entry.frame;
        } else if (entry.kind == SMR_ENTRY_RESTORED) {
            ok(smr_restore(tracker, entry.saved, entry.saved_size));
        } else if (entry.kind == SMR_ENTRY_ANSWER) {
            unsigned from = hundreds(), before = computed;
            ok(smr_update(tracker, &frame, &answer));
            taken += hundreds() - from;
            multiplications += computed - before;
            updates++;
        }
    }
    if (updates == 0) return EXIT_FAILURE;
    taken -= multiplications / MULTIPLICATIONS * each + multiplications % MULTIPLICATIONS * each / MULTIPLICATIONS;
    printf("instructions of an update: mean %u00\n", taken / updates);
    return EXIT_SUCCESS;
}
