/* Inertia estimation in three FreeRTOS tasks. */
#ifndef INERTIA_TASKS_H
#define INERTIA_TASKS_H

#include "fsw_core.h"

/* Starts estimator, mutex and tasks, before the scheduler; 0 where the configuration or a task was refused. */
int inertia_start(void);

/* Of the board: waits for the next sample of gyro and tachometers; 0 at the end of the samples. */
int board_wait_for_sample(fsw_sample *sample);
/* Of the board: sends an estimate to the ground. */
void board_send_estimate(const fsw_estimate *estimate);
/* Of the board: reports an outcome other than FSW_OUTCOME_UPDATED, such as a spike, a gap or a change. */
void board_report_outcome(fsw_outcome_code code);

#endif
