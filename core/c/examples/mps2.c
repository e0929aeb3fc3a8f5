/*
 * What runs before main on an Arm MPS2 board: two vectors, the floating-point unit that the C library is built for, and
 * the C library's own start (newlib with semihosting, rdimon.specs).
 */

#include <stdint.h>

extern unsigned char __stack[];
extern void _start(void);
void reset(void);

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
