/* Two recorded flights through window and joint-ekf: a spin-up by thrusters, a slew by four wheels.
 *
 *     replay
 *
 * On a host, and on a Cortex-M4F (target/): the same lines, since results are equal to the last bit. A line has flight,
 * estimator, number of the sample, outcome, and a hash of the bits of outcome and estimate; the last line of a flight
 * has the bits of the estimate. Lines that begin with # are for people: the tensor, and on the target the cost of each
 * function. fsw-core/docs/c.md has the commands. */
#include "flights/row.h"
#include "port.h"

static const row spin_up[] = {
#include "flights/spin_up.inc"
};
static const row wheel_slew[] = {
#include "flights/wheel_slew.inc"
};

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

/* The tensor with one sigma, and whether each element is observed. */
static void put_tensor(const char *flight, const char *estimator, const fsw_estimate *estimate) {
    static const char *const names[] = {" jxx", " jyy", " jzz", " jxy", " jxz", " jyz"};
    for (int i = 0; i < 6; i++) {
        put("# ");
        put(flight);
        put(estimator);
        put(names[i]);
        put_decimal(estimate->inertia_kg_m2[i]);
        put(" +-");
        put_decimal(estimate->sigma_kg_m2[i]);
        put((estimate->observed_elements >> i & 1u) != 0 ? " kg m2\n" : " kg m2, not observed\n");
    }
}

/* Largest and mean number of instructions, and the stack; nothing where nothing was counted. */
static void put_cost(const char *function, const struct cost *cost) {
    if (cost->number > 0) {
        put("# ");
        put(function);
        put(": instructions, largest and mean");
        put_unsigned(cost->largest);
        put_unsigned(cost->sum / cost->number);
        put("; bytes of stack");
        put_unsigned(cost->stack);
        put("\n");
    }
}

/* Costs of the functions, over all flights. */
static struct {
    struct cost init, step, work, estimate, finish, save, restore;
} of_window, of_joint_ekf;

/* A checkpoint in memory. FSW_WINDOW_WORDS hold any; these flights need fewer, and the RAM of the target is 112 KiB. */
#define MEDIUM_WORDS 10240
static struct {
    uint32_t words[MEDIUM_WORDS], length, next;
} medium;

static int32_t write_word(void *context, uint32_t word) {
    (void)context;
    if (medium.length == MEDIUM_WORDS) {
        return 0;
    }
    medium.words[medium.length++] = word;
    return 1;
}

static int32_t read_word(void *context, uint32_t *word) {
    (void)context;
    if (medium.next == medium.length) {
        return 0;
    }
    *word = medium.words[medium.next++];
    return 1;
}

/* A call whose cost is added to `cost`; it must not be refused. */
#define COUNTED(cost, call)                  \
    do {                                     \
        cost_begin();                        \
        const fsw_result result_ = (call);   \
        cost_end(&(cost));                   \
        require(result_);                    \
    } while (0)

static void require(fsw_result result) {
    if (result != FSW_RESULT_OK) {
        put("refused:");
        put_hex((uint32_t)result);
        put("\n");
        leave(1);
    }
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
    COUNTED(of_window.init, fsw_window_init(&window, sizeof window, &config));

    fsw_estimate estimate = {.struct_size = sizeof estimate};
    for (size_t k = 0; k < count; k++) {
        const fsw_sample sample = sample_of(&rows[k]);
        fsw_outcome outcome = {.struct_size = sizeof outcome};
        COUNTED(of_window.step, fsw_window_step(&window, &sample, &outcome));
        fsw_remaining remaining;
        for (int slice = 0; slice < 4; slice++) {
            COUNTED(of_window.work, fsw_window_work(&window, 1, &remaining));
        }
        COUNTED(of_window.estimate, fsw_window_estimate(&window, &estimate));
        put_sample(flight, " window", k, &outcome, hash_of(&outcome, &estimate));
    }
    COUNTED(of_window.finish, fsw_window_finish(&window));
    medium.length = medium.next = 0;
    COUNTED(of_window.save, fsw_window_save(&window, write_word, NULL));
    COUNTED(of_window.restore, fsw_window_restore(&window, read_word, NULL));
    require(fsw_window_estimate(&window, &estimate));
    put_estimate(flight, " window", &estimate);
    put_tensor(flight, " window", &estimate);
}

static void replay_joint_ekf(const char *flight, const row *rows, size_t count, float gyro_noise_rad_s) {
    fsw_joint_ekf_config config = {.struct_size = sizeof config};
    require(fsw_joint_ekf_config_defaults(&config, gyro_noise_rad_s));
    config.wheels = pyramid;
    COUNTED(of_joint_ekf.init, fsw_joint_ekf_init(&joint_ekf, sizeof joint_ekf, &config));

    fsw_estimate estimate = {.struct_size = sizeof estimate};
    for (size_t k = 0; k < count; k++) {
        const fsw_sample sample = sample_of(&rows[k]);
        fsw_outcome outcome = {.struct_size = sizeof outcome};
        COUNTED(of_joint_ekf.step, fsw_joint_ekf_step(&joint_ekf, &sample, &outcome));
        COUNTED(of_joint_ekf.estimate, fsw_joint_ekf_estimate(&joint_ekf, &estimate));
        put_sample(flight, " joint-ekf", k, &outcome, hash_of(&outcome, &estimate));
    }
    put_estimate(flight, " joint-ekf", &estimate);
    put_tensor(flight, " joint-ekf", &estimate);
}

int main(void) {
    replay_window("spin-up", spin_up, LENGTH(spin_up), 1.8151e-4f);
    replay_joint_ekf("spin-up", spin_up, LENGTH(spin_up), 1.8151e-4f);
    replay_window("wheel-slew", wheel_slew, LENGTH(wheel_slew), 1e-4f);
    replay_joint_ekf("wheel-slew", wheel_slew, LENGTH(wheel_slew), 1e-4f);
    put("done\n");
    put_cost("window init", &of_window.init);
    put_cost("window step", &of_window.step);
    put_cost("window work, a slice", &of_window.work);
    put_cost("window estimate", &of_window.estimate);
    put_cost("window finish", &of_window.finish);
    put_cost("window save", &of_window.save);
    put_cost("window restore", &of_window.restore);
    put_cost("joint-ekf init", &of_joint_ekf.init);
    put_cost("joint-ekf step", &of_joint_ekf.step);
    put_cost("joint-ekf estimate", &of_joint_ekf.estimate);
    leave(0);
    return 0;
}
