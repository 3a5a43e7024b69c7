/* Port to a Cortex-M4F in QEMU: start, semihosting, SysTick as instruction counter. No C library. */
#include "../port.h"

/* Arm semihosting: operation in r0, argument in r1. */
static int semihosting(int operation, const void *argument) {
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

#define SYS_WRITE0 0x04
#define SYS_EXIT 0x18
#define STOPPED_APPLICATION_EXIT 0x20026u
#define STOPPED_RUN_TIME_ERROR 0x20023u

void put(const char *text) {
    semihosting(SYS_WRITE0, text);
}

void leave(int status) {
    const uintptr_t reason = status == 0 ? STOPPED_APPLICATION_EXIT : STOPPED_RUN_TIME_ERROR;
    semihosting(SYS_EXIT, (const void *)reason);
    for (;;) {
    }
}

/* Counts down from 2^24 - 1 at the processor's clock. Under `qemu -icount shift=4` an instruction takes 16 ns: 2,688
 * ticks of 168 MHz per 1000 instructions, and 6,200,000 instructions at most. */
#define TICKS_PER_1000 2688u
#define SYST_CSR (*(volatile uint32_t *)0xe000e010u)
#define SYST_RVR (*(volatile uint32_t *)0xe000e014u)
#define SYST_CVR (*(volatile uint32_t *)0xe000e018u)
#define SYSTICK_MASK 0x00ffffffu

extern uint32_t _stack_bottom[];
#define PAINT 0xa5a5a5a5u
/* Words below the stack pointer that are left as they are. */
#define MARGIN 4

static uint32_t begin, *from;

/* Paints the free stack, so that what a call leaves behind shows its depth. */
__attribute__((noinline)) void cost_begin(void) {
    __asm__ volatile("mov %0, sp" : "=r"(from));
    from -= MARGIN;
    for (uint32_t *word = _stack_bottom; word < from; word++) {
        *(volatile uint32_t *)word = PAINT;
    }
    begin = SYST_CVR;
}

__attribute__((noinline)) void cost_end(struct cost *cost) {
    const uint32_t ticks = (begin - SYST_CVR) & SYSTICK_MASK;
    const uint32_t instructions = (uint32_t)(ticks * (uint64_t)1000 / TICKS_PER_1000);
    const uint32_t *word = _stack_bottom;
    while (word < from && *(const volatile uint32_t *)word == PAINT) {
        word++;
    }
    const uint32_t stack = (uint32_t)(from - word + MARGIN) * sizeof(uint32_t);
    cost->largest = instructions > cost->largest ? instructions : cost->largest;
    cost->stack = stack > cost->stack ? stack : cost->stack;
    cost->sum += instructions;
    cost->number++;
}

extern uint32_t _data_load[], _data_start[], _data_end[], _bss_start[], _bss_end[], _stack_top[];
int main(void);

__attribute__((noreturn)) void reset(void) {
    *(volatile uint32_t *)0xe000ed88u |= 0xfu << 20; /* CPACR: access to the FPU */
    __asm__ volatile("dsb\nisb" ::: "memory");
    const uint32_t *from = _data_load;
    for (uint32_t *to = _data_start; to < _data_end;) {
        *to++ = *from++;
    }
    for (uint32_t *to = _bss_start; to < _bss_end;) {
        *to++ = 0;
    }
    SYST_RVR = SYSTICK_MASK;
    SYST_CVR = 0;
    SYST_CSR = 5; /* enabled, processor's clock, no interrupt */
    leave(main());
    for (;;) {
    }
}

static void fault(void) {
    put("fault\n");
    leave(1);
}

/* Vector table of the core: initial stack pointer, reset, six faults. No interrupt is used. */
__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack;
    void (*handlers[15])(void);
} vectors = {_stack_top, {reset, fault, fault, fault, fault, fault, fault}};
