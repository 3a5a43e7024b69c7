/* A sample of a recorded flight. The files of the flights have a line ROW(…) for each. */
#ifndef ROW_H
#define ROW_H

#include "fsw_core.h"

typedef struct {
    uint64_t time_us;
    float rate_rad_s[3];
    float wheel_speed_rad_s[FSW_WHEELS];
    float torque_n_m[3];
} row;

#define ROW(t, x, y, z, a, b, c, d, l, m, n) {t, {x, y, z}, {a, b, c, d}, {l, m, n}},

static inline fsw_sample sample_of(const row *row) {
    fsw_sample sample = {.struct_size = sizeof sample, .time_us = row->time_us};
    for (int i = 0; i < 3; i++) {
        sample.rate_rad_s[i] = row->rate_rad_s[i];
        sample.torque_n_m[i] = row->torque_n_m[i];
    }
    for (int i = 0; i < FSW_WHEELS; i++) {
        sample.wheel_speed_rad_s[i] = row->wheel_speed_rad_s[i];
    }
    return sample;
}

#endif
