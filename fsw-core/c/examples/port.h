/* Text output, exit and an instruction counter: of a host, or of a Cortex-M in QEMU with semihosting (target/port.c). */
#ifndef PORT_H
#define PORT_H

#include <stdint.h>

void put(const char *text);
void leave(int status);

/* A space, and eight hexadecimal digits. */
static inline void put_hex(uint32_t word) {
    char text[10];
    text[0] = ' ';
    for (int i = 0; i < 8; i++) {
        text[1 + i] = "0123456789abcdef"[(word >> (28 - 4 * i)) & 15u];
    }
    text[9] = '\0';
    put(text);
}

/* A space, and a decimal number. */
static inline void put_unsigned(uint32_t number) {
    char text[12];
    int first = 11;
    text[first] = '\0';
    do {
        text[--first] = (char)('0' + number % 10u);
        number /= 10u;
    } while (number > 0);
    text[--first] = ' ';
    put(&text[first]);
}

/* A space, and a number below 4000 with six decimals, cut. */
static inline void put_decimal(float value) {
    const float size = value < 0.0f ? -value : value;
    const uint32_t whole = (uint32_t)size, millionths = (uint32_t)((size - (float)whole) * 1e6f);
    char text[] = ".000000";
    uint32_t rest = millionths;
    for (int i = 6; i > 0; i--) {
        text[i] = (char)('0' + rest % 10u);
        rest /= 10u;
    }
    put(value < 0.0f ? " -" : " ");
    char digits[12];
    int first = 11;
    digits[first] = '\0';
    rest = whole;
    do {
        digits[--first] = (char)('0' + rest % 10u);
        rest /= 10u;
    } while (rest > 0);
    put(&digits[first]);
    put(text);
}

/* Cost of the calls of one function: number, instructions, bytes of stack. */
struct cost {
    uint32_t number, largest, sum, stack;
};

/* What lies between cost_begin and cost_end is added. Nothing on a host. */
void cost_begin(void);
void cost_end(struct cost *cost);

#endif
