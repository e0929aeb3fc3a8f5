/*
 * Counts the instructions of the updates of a flight record (tests/vectors) in QEMU with -icount shift=0, on Cortex-M, RISC-V and Xtensa.
 *
 *     instructions FILE
 */

#include <stdio.h>
#include <stdlib.h>

#include "smr.h"

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

#ifdef __XTENSA__
#define PER_COUNT 100
static unsigned count(void)
{
    unsigned counted;
    __asm__ volatile("rsr %0, ccount" : "=r"(counted));
    return counted;
}

/* QEMU's processor lacks MULUH and MULSH. start.s computes them in an exception, and counts them here. */
extern const volatile unsigned computed;

/* The counts of `number` such multiplications, beyond those of one instruction each. */
static unsigned counts_of_computed(unsigned number)
{
    enum { ROUNDS = 10000 };
    static unsigned each;
    if (each == 0) {
        unsigned rounds = ROUNDS, upper, from = count();
        __asm__ volatile("1: muluh %1, %0, %0\n addi %0, %0, -1\n bnez %0, 1b" : "+r"(rounds), "=&r"(upper));
        each = count() - from - ROUNDS * 3 / PER_COUNT;
    }
    return number / ROUNDS * each + number % ROUNDS * each / ROUNDS;
}
#else
static const unsigned computed;

static unsigned counts_of_computed(unsigned number)
{
    return number;
}

#ifdef __riscv
#define PER_COUNT 1
static unsigned count(void)
{
    unsigned long counted;
    __asm__ volatile(".option push\n.option arch, +zicsr\ncsrr %0, minstret\n.option pop" : "=r"(counted));
    return (unsigned)counted;
}
#else
/* SysTick counts down 24 bits at 25 MHz, as QEMU's boards with a Cortex-M4 do. An instruction takes a nanosecond. */
#define PER_COUNT 40
static volatile uint32_t *const systick = (volatile uint32_t *)0xE000E010u;

static unsigned count(void)
{
    static unsigned last, counted;
    unsigned now;
    systick[1] = 0xFFFFFF;
    systick[0] = 5;
    now = 0xFFFFFF - systick[2];
    counted += (now - last) & 0xFFFFFF;
    last = now;
    return counted;
}
#endif
#endif

int main(int argc, char **argv)
{
    FILE *file = argc == 2 ? fopen(argv[1], "rb") : NULL;
    size_t size, at = 0;
    unsigned updates = 0, taken = 0, multiplications = 0;
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
            unsigned from = count(), before = computed;
            ok(smr_update(tracker, &frame, &answer));
            taken += count() - from;
            multiplications += computed - before;
            updates++;
        }
    }
    if (updates == 0) return EXIT_FAILURE;
    taken -= counts_of_computed(multiplications);
    printf("%lu\n", (unsigned long)taken / updates * PER_COUNT);
    return EXIT_SUCCESS;
}
