#ifndef TASK_H
#define TASK_H
#include "FreeRTOS.h"
typedef struct task *TaskHandle_t;
BaseType_t xTaskCreate(void (*task)(void *), const char *name, uint16_t words, void *argument, unsigned priority, TaskHandle_t *handle);
void vTaskDelay(TickType_t ticks);
void vTaskDelete(TaskHandle_t task);
#endif
