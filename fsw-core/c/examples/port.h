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

/* Instructions between count_begin and count_end; put_count prints the largest number and the mean since its last call.
 * Nothing on a host. */
void count_begin(void);
void count_end(void);
void put_count(const char *flight, const char *estimator);

#endif
