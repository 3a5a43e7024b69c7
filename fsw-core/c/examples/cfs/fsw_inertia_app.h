/* Messages and data store of the inertia application. */
#ifndef FSW_INERTIA_APP_H
#define FSW_INERTIA_APP_H

#include "cfe.h"
#include "fsw_core.h"

#define FSW_INERTIA_PIPE_DEPTH 32
#define FSW_INERTIA_SAMPLE_MID 0x0880 /* from the gyro application, at its rate */
#define FSW_INERTIA_HK_MID 0x1881     /* from the scheduler, at the rate of telemetry */
#define FSW_INERTIA_SAVE_MID 0x1882   /* from the scheduler or the ground */
#define FSW_INERTIA_TLM_MID 0x0881

/* Gyro sample: members as in fsw_sample. */
typedef struct {
    CFE_MSG_TelemetryHeader_t TelemetryHeader;
    uint64 TimeUs;
    float RateRadS[3];
    float WheelSpeedRadS[FSW_WHEELS];
    float TorqueNM[3];
} FSW_INERTIA_Sample_t;

/* Telemetry. */
typedef struct {
    CFE_MSG_TelemetryHeader_t TelemetryHeader;
    uint32 BuildFingerprint;
    uint32 Status;             /* fsw_status */
    uint32 ObservedDirections; /* 0 to 6 */
    uint32 Samples;            /* samples that entered the state */
    uint32 Rejected;           /* samples that did not */
    float InertiaKgM2[6];      /* jxx jyy jzz jxy jxz jyz */
    float SigmaKgM2[6];
} FSW_INERTIA_Tlm_t;

/* Critical data store: a state in words. Its integrity is checked by cFE. */
typedef struct {
    uint32 Length;
    uint32 Words[FSW_WINDOW_WORDS];
} FSW_INERTIA_Store_t;

void FSW_INERTIA_AppMain(void);

#endif
