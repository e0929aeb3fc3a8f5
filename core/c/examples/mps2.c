/*
 * Start-up code for an Arm MPS2 or MPS3 board: contains the vector table, enables the floating-point unit and starts the C library
 * (newlib with semihosting, rdimon.specs).
 */

#include <stddef.h>
#include <stdint.h>

extern unsigned char __stack[], end[];
extern void _start(void);
void reset(void);
void *_sbrk(ptrdiff_t more);

static void fault(void)
{
    for (;;) {
    }
}

typedef struct vectors {
    const void *stack;
    void (*handlers[15])(void);
} vectors;

__attribute__((section(".vectors"), used)) static const vectors table = {
    __stack,
    {reset, fault, fault, fault, fault, fault, 0, 0, 0, 0, fault, fault, 0, fault, fault},
};

void reset(void)
{
    /* Coprocessor access control: full access to the floating-point unit. */
    volatile uint32_t *const cpacr = (volatile uint32_t *)0xE000ED88u;
    *cpacr |= 0xFu << 20;
    __asm__ volatile("dsb\n\tisb" ::: "memory");
    _start();
}

/* Grows the heap, which the C library needs to open files. The heap begins after the data, because semihosting on the MPS3 reports a wrong heap. */
void *_sbrk(ptrdiff_t more)
{
    static unsigned char *top = end;
    unsigned char *before = top;
    top += more;
    return before;
}
