/* Inertia estimation in three FreeRTOS tasks, by fsw-core's window estimator.
 *
 *   task       priority  holds the mutex for
 *   sample     highest   one step
 *   telemetry  middle    one estimate
 *   work       lowest    one slice of work
 *
 * The mutex has priority inheritance: a sample waits for one slice or one estimate at most. Their instructions, and the
 * stack of each function, are in fsw-core/docs/c.md. */
#include "inertia_tasks.h"

#include "FreeRTOS.h"
#include "semphr.h"
#include "task.h"

/* Words of 4 bytes: deepest call of the task, its own frames, and one interrupt frame with the registers of the FPU. */
#define SAMPLE_STACK 1024
#define TELEMETRY_STACK 1536
#define WORK_STACK 2048

#define GYRO_NOISE_RAD_S 1e-4f /* one sigma of a sample */
#define TELEMETRY_PERIOD_MS 1000
#define IDLE_MS 20 /* wait of the work task once nothing is left */

static fsw_window window;
static SemaphoreHandle_t mutex;

static void sample_task(void *unused) {
    fsw_sample sample = {.struct_size = sizeof sample};
    fsw_outcome outcome = {.struct_size = sizeof outcome};
    (void)unused;
    while (board_wait_for_sample(&sample)) {
        xSemaphoreTake(mutex, portMAX_DELAY);
        const fsw_result result = fsw_window_step(&window, &sample, &outcome);
        xSemaphoreGive(mutex);
        if (result == FSW_RESULT_OK && outcome.code != FSW_OUTCOME_CODE_UPDATED) {
            board_report_outcome(outcome.code);
        }
    }
    vTaskDelete(NULL);
}

static void work_task(void *unused) {
    (void)unused;
    for (;;) {
        fsw_remaining remaining = FSW_REMAINING_NOTHING;
        xSemaphoreTake(mutex, portMAX_DELAY);
        (void)fsw_window_work(&window, 1, &remaining);
        xSemaphoreGive(mutex);
        if (remaining == FSW_REMAINING_NOTHING) {
            vTaskDelay(pdMS_TO_TICKS(IDLE_MS));
        }
    }
}

static void telemetry_task(void *unused) {
    fsw_estimate estimate = {.struct_size = sizeof estimate};
    (void)unused;
    for (;;) {
        xSemaphoreTake(mutex, portMAX_DELAY);
        const fsw_result result = fsw_window_estimate(&window, &estimate);
        xSemaphoreGive(mutex);
        if (result == FSW_RESULT_OK) {
            board_send_estimate(&estimate);
        }
        vTaskDelay(pdMS_TO_TICKS(TELEMETRY_PERIOD_MS));
    }
}

static int start_estimator(void) {
    static const float diagonals[FSW_WHEELS][3] = {{1, 1, 1}, {-1, 1, 1}, {-1, -1, 1}, {1, -1, 1}};
    fsw_window_config config = {.struct_size = sizeof config};
    (void)fsw_window_config_defaults(&config, GYRO_NOISE_RAD_S);
    for (int wheel = 0; wheel < FSW_WHEELS; wheel++) {
        for (int axis = 0; axis < 3; axis++) {
            config.wheels.axis[wheel][axis] = diagonals[wheel][axis];
        }
        config.wheels.spin_inertia_kg_m2[wheel] = 2.1e-5f;
    }
    config.slices_per_step = 0; /* the work task does all of them */
    return fsw_window_init(&window, sizeof window, &config) == FSW_RESULT_OK;
}

int inertia_start(void) {
    mutex = xSemaphoreCreateMutex();
    return mutex != NULL && start_estimator() &&
           xTaskCreate(sample_task, "sample", SAMPLE_STACK, NULL, 3, NULL) == pdPASS &&
           xTaskCreate(telemetry_task, "telemetry", TELEMETRY_STACK, NULL, 2, NULL) == pdPASS &&
           xTaskCreate(work_task, "work", WORK_STACK, NULL, 1, NULL) == pdPASS;
}
