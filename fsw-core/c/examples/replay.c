/* Two recorded flights through window and joint-ekf: a spin-up by thrusters, a slew by four wheels.
 *
 *     replay
 *
 * On a host, and on a Cortex-M4F (target/): the same lines, since results are equal to the last bit. A line has flight,
 * estimator, number of the sample, outcome, and a hash of the bits of outcome and estimate; the last line of a flight
 * has the bits of the estimate. fsw-core/docs/c.md has the commands. */
#include "../include/fsw_core.h"
#include "port.h"

typedef struct {
    uint64_t time_us;
    float rate_rad_s[3];
    float wheel_speed_rad_s[4];
    float torque_n_m[3];
} row;

#define ROW(t, x, y, z, a, b, c, d, l, m, n) {t, {x, y, z}, {a, b, c, d}, {l, m, n}},
static const row spin_up[] = {
#include "flights/spin_up.inc"
};
static const row wheel_slew[] = {
#include "flights/wheel_slew.inc"
};
#undef ROW

#define LENGTH(array) (sizeof(array) / sizeof((array)[0]))

/* The estimators: static, so that the linker accounts for their memory. */
static fsw_window window;
static fsw_joint_ekf joint_ekf;

/* 32-bit FNV-1a hash, one word at a time. */
static uint32_t mix(uint32_t hash, uint32_t word) {
    return (hash ^ word) * 0x01000193u;
}

static uint32_t bits(float value) {
    union {
        float value;
        uint32_t bits;
    } both;
    both.value = value;
    return both.bits;
}

/* Hash of what a step and an estimate return. */
static uint32_t hash_of(const fsw_outcome *outcome, const fsw_estimate *estimate) {
    uint32_t hash = mix(0x811c9dc5u, (uint32_t)outcome->code);
    for (int i = 0; i < 3; i++) {
        hash = mix(hash, bits(outcome->rate_rad_s[i]));
        hash = mix(hash, bits(outcome->innovation_rad_s[i]));
    }
    hash = mix(hash, (uint32_t)estimate->status);
    hash = mix(hash, estimate->observed_directions);
    for (int i = 0; i < 6; i++) {
        hash = mix(hash, bits(estimate->inertia_kg_m2[i]));
        for (int k = 0; k < 6; k++) {
            hash = mix(hash, bits(estimate->covariance_kg2_m4[i][k]));
        }
    }
    return mix(hash, bits(estimate->residual_rms_rad_s));
}

static void put_sample(const char *flight, const char *estimator, size_t k, const fsw_outcome *outcome, uint32_t hash) {
    put(flight);
    put(estimator);
    put_hex((uint32_t)k);
    put_hex((uint32_t)outcome->code);
    put_hex(hash);
    put("\n");
}

static void put_estimate(const char *flight, const char *estimator, const fsw_estimate *estimate) {
    put(flight);
    put(estimator);
    put(" end");
    put_hex((uint32_t)estimate->status);
    for (int i = 0; i < 6; i++) {
        put_hex(bits(estimate->inertia_kg_m2[i]));
        put_hex(bits(estimate->sigma_kg_m2[i]));
    }
    put("\n");
}

static void require(fsw_result result) {
    if (result != FSW_RESULT_OK) {
        put("refused:");
        put_hex((uint32_t)result);
        put("\n");
        leave(1);
    }
}

static fsw_sample sample_of(const row *row) {
    fsw_sample sample = {.struct_size = sizeof sample, .time_us = row->time_us};
    for (int i = 0; i < 3; i++) {
        sample.rate_rad_s[i] = row->rate_rad_s[i];
        sample.torque_n_m[i] = row->torque_n_m[i];
    }
    for (int i = 0; i < 4; i++) {
        sample.wheel_speed_rad_s[i] = row->wheel_speed_rad_s[i];
    }
    return sample;
}

/* Four wheels on the diagonals of a cube, 2.1e-5 kg m². */
static const fsw_wheels pyramid = {
    .axis = {{1, 1, 1}, {-1, 1, 1}, {-1, -1, 1}, {1, -1, 1}},
    .spin_inertia_kg_m2 = {2.1e-5f, 2.1e-5f, 2.1e-5f, 2.1e-5f},
};

static void replay_window(const char *flight, const row *rows, size_t count, float gyro_noise_rad_s) {
    fsw_window_config config = {.struct_size = sizeof config};
    require(fsw_window_config_defaults(&config, gyro_noise_rad_s));
    config.wheels = pyramid;
    config.slices_per_step = 0; /* work in idle time */
    require(fsw_window_init(&window, sizeof window, &config));

    fsw_estimate estimate = {.struct_size = sizeof estimate};
    for (size_t k = 0; k < count; k++) {
        const fsw_sample sample = sample_of(&rows[k]);
        fsw_outcome outcome = {.struct_size = sizeof outcome};
        count_begin();
        const fsw_result result = fsw_window_step(&window, &sample, &outcome);
        count_end();
        require(result);
        fsw_remaining remaining;
        require(fsw_window_work(&window, 4, &remaining));
        require(fsw_window_estimate(&window, &estimate));
        put_sample(flight, " window", k, &outcome, hash_of(&outcome, &estimate));
    }
    put_count(flight, " window");
    require(fsw_window_finish(&window));
    require(fsw_window_estimate(&window, &estimate));
    put_estimate(flight, " window", &estimate);
}

static void replay_joint_ekf(const char *flight, const row *rows, size_t count, float gyro_noise_rad_s) {
    fsw_joint_ekf_config config = {.struct_size = sizeof config};
    require(fsw_joint_ekf_config_defaults(&config, gyro_noise_rad_s));
    config.wheels = pyramid;
    require(fsw_joint_ekf_init(&joint_ekf, sizeof joint_ekf, &config));

    fsw_estimate estimate = {.struct_size = sizeof estimate};
    for (size_t k = 0; k < count; k++) {
        const fsw_sample sample = sample_of(&rows[k]);
        fsw_outcome outcome = {.struct_size = sizeof outcome};
        count_begin();
        const fsw_result result = fsw_joint_ekf_step(&joint_ekf, &sample, &outcome);
        count_end();
        require(result);
        require(fsw_joint_ekf_estimate(&joint_ekf, &estimate));
        put_sample(flight, " joint-ekf", k, &outcome, hash_of(&outcome, &estimate));
    }
    put_count(flight, " joint-ekf");
    put_estimate(flight, " joint-ekf", &estimate);
}

int main(void) {
    replay_window("spin-up", spin_up, LENGTH(spin_up), 1.8151e-4f);
    replay_joint_ekf("spin-up", spin_up, LENGTH(spin_up), 1.8151e-4f);
    replay_window("wheel-slew", wheel_slew, LENGTH(wheel_slew), 1e-4f);
    replay_joint_ekf("wheel-slew", wheel_slew, LENGTH(wheel_slew), 1e-4f);
    put("done\n");
    leave(0);
    return 0;
}
