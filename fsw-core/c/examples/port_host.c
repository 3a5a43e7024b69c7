/* Port to a hosted system. */
#include "port.h"
#include <stdio.h>
#include <stdlib.h>

void put(const char *text) {
    fputs(text, stdout);
}

void leave(int status) {
    exit(status);
}

void cost_begin(void) {}
void cost_end(struct cost *cost) {
    (void)cost;
}
