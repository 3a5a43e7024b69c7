/* Runs the three tasks as POSIX threads on the recorded slew, and prints the last estimate. */
#define _POSIX_C_SOURCE 200809L
#include "inertia_tasks.h"

#include "FreeRTOS.h"
#include "semphr.h"
#include "task.h"
#include "../../flights/row.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static const row rows[] = {
#include "../../flights/wheel_slew.inc"
};

struct semaphore {
    pthread_mutex_t mutex;
};

struct start {
    void (*task)(void *);
    void *argument;
};

static void *run(void *start) {
    const struct start this = *(struct start *)start;
    free(start);
    this.task(this.argument);
    return NULL;
}

BaseType_t xTaskCreate(void (*task)(void *), const char *name, uint16_t words, void *argument, unsigned priority, TaskHandle_t *handle) {
    pthread_t thread;
    struct start *start = malloc(sizeof *start);
    (void)name, (void)words, (void)priority, (void)handle;
    *start = (struct start){task, argument};
    return pthread_create(&thread, NULL, run, start) == 0 && pthread_detach(thread) == 0 ? pdPASS : 0;
}

static void wait_us(uint32_t us) {
    const struct timespec span = {us / 1000000, (long)(us % 1000000) * 1000};
    nanosleep(&span, NULL);
}

void vTaskDelay(TickType_t ticks) {
    wait_us(ticks);
}

void vTaskDelete(TaskHandle_t task) {
    (void)task;
    pthread_exit(NULL);
}

SemaphoreHandle_t xSemaphoreCreateMutex(void) {
    SemaphoreHandle_t mutex = malloc(sizeof *mutex);
    pthread_mutex_init(&mutex->mutex, NULL);
    return mutex;
}

BaseType_t xSemaphoreTake(SemaphoreHandle_t mutex, TickType_t ticks) {
    (void)ticks;
    return pthread_mutex_lock(&mutex->mutex) == 0;
}

BaseType_t xSemaphoreGive(SemaphoreHandle_t mutex) {
    return pthread_mutex_unlock(&mutex->mutex) == 0;
}

static pthread_mutex_t shared = PTHREAD_MUTEX_INITIALIZER;
static size_t taken;
static fsw_estimate last;

int board_wait_for_sample(fsw_sample *sample) {
    static size_t next;
    if (next == sizeof rows / sizeof rows[0]) {
        pthread_mutex_lock(&shared);
        taken = next;
        pthread_mutex_unlock(&shared);
        return 0;
    }
    wait_us(200);
    *sample = sample_of(&rows[next++]);
    return 1;
}

void board_send_estimate(const fsw_estimate *estimate) {
    pthread_mutex_lock(&shared);
    last = *estimate;
    pthread_mutex_unlock(&shared);
}

void board_report_outcome(fsw_outcome_code code) {
    printf("outcome %d\n", (int)code);
}

int main(void) {
    if (!inertia_start()) {
        puts("refused");
        return 1;
    }
    /* Until an estimate after the last sample has converged, 30 s at most. */
    for (int tenths = 0; tenths < 300; tenths++) {
        wait_us(100000);
        pthread_mutex_lock(&shared);
        const int is_done = taken > 0 && last.status == FSW_STATUS_CONVERGED;
        pthread_mutex_unlock(&shared);
        if (is_done) {
            break;
        }
    }
    printf("status %d, %u directions\n", (int)last.status, (unsigned)last.observed_directions);
    return 0;
}
