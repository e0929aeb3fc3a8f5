/*
 * Checks that no line is lost and every frame is complete if lines arrive in an interrupt while the main loop polls for the frame. The
 * signal of a timer stands for the interrupt. POSIX only.
 */

#define _XOPEN_SOURCE 700
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/time.h>

#include "smr.h"

#define WIDTH 64
#define LINES 60
#define TOP 5
#define BOTTOM 50
#define FRAMES 150

static smr_readout readout;
static uint8_t line[WIDTH], pixels[WIDTH * (BOTTOM - TOP)];
static volatile sig_atomic_t next_line = LINES, frame_number, refused, refused_line;

static uint8_t level(int frame, int y)
{
    return (uint8_t)(frame * 31 + y * 7);
}

static void bring_a_line(int signal_number)
{
    smr_status status;
    (void)signal_number;
    if (next_line == LINES || refused) {
        return;
    }
    memset(line, level(frame_number, next_line), sizeof line);
    status = smr_readout_line(&readout, (uint16_t)next_line, line, sizeof line);
    if (status == SMR_OK) {
        next_line++;
    } else {
        refused = (sig_atomic_t)status;
        refused_line = next_line;
    }
}

static void switch_interrupt(int how)
{
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGALRM);
    sigprocmask(how, &set, NULL);
}

int main(void)
{
    const smr_rect windows[2] = {{0, TOP, WIDTH, BOTTOM - TOP}, {0, 0, 0, 0}};
    struct itimerval every;
    struct sigaction action;
    unsigned long polls = 0, between = 0;
    int y;

    memset(&action, 0, sizeof action);
    action.sa_handler = bring_a_line;
    sigaction(SIGALRM, &action, NULL);
    memset(&every, 0, sizeof every);
    every.it_interval.tv_usec = every.it_value.tv_usec = 20;
    setitimer(ITIMER_REAL, &every, NULL);

    for (frame_number = 0; frame_number < FRAMES; frame_number++) {
        smr_frame frame;
        smr_status status;
        switch_interrupt(SIG_BLOCK);
        status = smr_readout_begin(&readout, &SMR_GRAY8, WIDTH, LINES, windows, pixels, sizeof pixels);
        next_line = 0;
        switch_interrupt(SIG_UNBLOCK);
        if (status != SMR_OK) {
            fprintf(stderr, "interrupt.c: no readout begins: %s\n", smr_status_name(status));
            return 1;
        }
        while (!refused && (status = smr_readout_frame(&readout, &frame)) != SMR_OK) {
            polls++;
            between += next_line > TOP;
        }
        if (refused) {
            fprintf(stderr, "interrupt.c: all lines came in order, but line %d of frame %d is refused with %s\n",
                    (int)refused_line, (int)frame_number, smr_status_name((smr_status)refused));
            return 1;
        }
        /* Lines below the window still arrive while the frame is checked. */
        for (y = 0; y < BOTTOM - TOP; y++) {
            const uint8_t *row = frame.parts[0].pixels + y * WIDTH;
            if (row[0] != level(frame_number, TOP + y) || memcmp(row, row + 1, WIDTH - 1) != 0) {
                fprintf(stderr, "interrupt.c: line %d of frame %d has other pixels than came\n", TOP + y,
                        (int)frame_number);
                return 1;
            }
        }
    }
    if (between == 0) {
        fprintf(stderr, "interrupt.c: no line came while the frame was asked for, so nothing was tested\n");
        return 1;
    }
    printf("lines in an interrupt: %d frames, whole after %lu questions\n", FRAMES, polls);
    return 0;
}
