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

/* Decimal digits of a number, at least so many, with leading zeros. */
static inline void put_digits(uint32_t number, int least) {
    char text[11];
    int first = 10;
    text[first] = '\0';
    for (; number > 0 || least > 0; least--) {
        text[--first] = (char)('0' + number % 10u);
        number /= 10u;
    }
    put(&text[first]);
}

/* A space, and a number. */
static inline void put_unsigned(uint32_t number) {
    put(" ");
    put_digits(number, 1);
}

/* A space, and a number of less than 4e9 with six decimals, cut. */
static inline void put_decimal(float value) {
    const float size = value < 0.0f ? -value : value;
    const uint32_t whole = (uint32_t)size;
    put(value < 0.0f ? " -" : " ");
    put_digits(whole, 1);
    put(".");
    put_digits((uint32_t)((size - (float)whole) * 1e6f), 6);
}

/* Cost of the calls of one function: their number, instructions of the most expensive one and of all, bytes of stack. */
struct cost {
    uint32_t number, largest, sum, stack;
};

/* What lies between cost_begin and cost_end is added. Nothing on a host. */
void cost_begin(void);
void cost_end(struct cost *cost);

#endif
