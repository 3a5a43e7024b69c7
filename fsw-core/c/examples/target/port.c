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

/* Counts down from 2^24 - 1 at the processor's clock. Under `qemu -icount shift=8` an instruction takes 256 ns: 43,008
 * ticks of 168 MHz per 1000 instructions, and 390,000 instructions at most. */
#define TICKS_PER_1000 43008u
#define SYST_CSR (*(volatile uint32_t *)0xe000e010u)
#define SYST_RVR (*(volatile uint32_t *)0xe000e014u)
#define SYST_CVR (*(volatile uint32_t *)0xe000e018u)
#define SYSTICK_MASK 0x00ffffffu

static uint32_t begin, largest, number, sum;

void count_begin(void) {
    begin = SYST_CVR;
}

void count_end(void) {
    const uint32_t ticks = (begin - SYST_CVR) & SYSTICK_MASK;
    const uint32_t instructions = (uint32_t)(ticks * (uint64_t)1000 / TICKS_PER_1000);
    largest = instructions > largest ? instructions : largest;
    sum += instructions;
    number++;
}

void put_count(const char *flight, const char *estimator) {
    put(flight);
    put(estimator);
    put(" instructions-largest-mean");
    put_hex(largest);
    put_hex(number == 0 ? 0 : sum / number);
    put("\n");
    largest = 0;
    sum = 0;
    number = 0;
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
