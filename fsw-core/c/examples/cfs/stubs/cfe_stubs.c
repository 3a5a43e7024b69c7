/* STUB of cFE: a software bus that delivers a recorded flight, a critical data store in memory, events and telemetry on
 * standard output. The application runs twice: over the first half of the flight, which ends with a save request, and over
 * the second half, after a reset. */
#include "fsw_inertia_app.h"
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

typedef struct {
    uint64 time_us;
    float rate[3], wheel[4], torque[3];
} row;
#define ROW(t, x, y, z, a, b, c, d, l, m, n) {t, {x, y, z}, {a, b, c, d}, {l, m, n}},
static const row flight[] = {
#include "../../flights/wheel_slew.inc"
};
#define LENGTH (sizeof flight / sizeof flight[0])

static size_t next, end;
static enum { SAMPLES, HOUSEKEEPING, SAVE, OVER } phase;
static union {
    CFE_SB_Buffer_t buffer;
    FSW_INERTIA_Sample_t sample;
} message;
static FSW_INERTIA_Store_t stored;
static bool is_stored;

bool CFE_ES_RunLoop(uint32 *RunStatus) {
    return *RunStatus == CFE_ES_RunStatus_APP_RUN && phase != OVER;
}

void CFE_ES_ExitApp(uint32 ExitStatus) {
    (void)ExitStatus;
}

CFE_Status_t CFE_ES_RegisterCDS(CFE_ES_CDSHandle_t *HandlePtr, size_t BlockSize, const char *Name) {
    (void)Name;
    *HandlePtr = 1;
    if (BlockSize != sizeof stored) {
        return CFE_STATUS_EXTERNAL_RESOURCE_FAIL;
    }
    return is_stored ? CFE_ES_CDS_ALREADY_EXISTS : CFE_SUCCESS;
}

CFE_Status_t CFE_ES_CopyToCDS(CFE_ES_CDSHandle_t Handle, const void *DataToCopy) {
    (void)Handle;
    memcpy(&stored, DataToCopy, sizeof stored);
    is_stored = true;
    return CFE_SUCCESS;
}

CFE_Status_t CFE_ES_RestoreFromCDS(void *RestoreToMemory, CFE_ES_CDSHandle_t Handle) {
    (void)Handle;
    memcpy(RestoreToMemory, &stored, sizeof stored);
    return CFE_SUCCESS;
}

CFE_Status_t CFE_EVS_Register(const void *Filters, uint16 NumEventFilters, uint16 FilterScheme) {
    (void)Filters, (void)NumEventFilters, (void)FilterScheme;
    return CFE_SUCCESS;
}

CFE_Status_t CFE_EVS_SendEvent(uint16 EventID, CFE_EVS_EventType_Enum_t EventType, const char *Spec, ...) {
    va_list arguments;
    printf("event %u, type %d: ", EventID, (int)EventType);
    va_start(arguments, Spec);
    vprintf(Spec, arguments);
    va_end(arguments);
    printf("\n");
    return CFE_SUCCESS;
}

CFE_Status_t CFE_MSG_Init(CFE_MSG_Message_t *MsgPtr, CFE_SB_MsgId_t MsgId, CFE_MSG_Size_t Size) {
    MsgPtr->Id = MsgId;
    MsgPtr->Size = (uint32)Size;
    return CFE_SUCCESS;
}

CFE_Status_t CFE_MSG_GetMsgId(const CFE_MSG_Message_t *MsgPtr, CFE_SB_MsgId_t *MsgId) {
    *MsgId = MsgPtr->Id;
    return CFE_SUCCESS;
}

CFE_Status_t CFE_MSG_GetSize(const CFE_MSG_Message_t *MsgPtr, CFE_MSG_Size_t *Size) {
    *Size = MsgPtr->Size;
    return CFE_SUCCESS;
}

CFE_Status_t CFE_SB_CreatePipe(CFE_SB_PipeId_t *PipeIdPtr, uint16 Depth, const char *PipeName) {
    (void)Depth, (void)PipeName;
    *PipeIdPtr = 1;
    return CFE_SUCCESS;
}

CFE_Status_t CFE_SB_Subscribe(CFE_SB_MsgId_t MsgId, CFE_SB_PipeId_t PipeId) {
    (void)MsgId, (void)PipeId;
    return CFE_SUCCESS;
}

static void request(CFE_SB_MsgId_Atom_t id) {
    CFE_MSG_Init(&message.buffer.Msg, CFE_SB_ValueToMsgId(id), sizeof message.buffer);
}

CFE_Status_t CFE_SB_ReceiveBuffer(CFE_SB_Buffer_t **BufPtr, CFE_SB_PipeId_t PipeId, int32 TimeOut) {
    (void)PipeId, (void)TimeOut;
    *BufPtr = &message.buffer;
    switch (phase) {
    case SAMPLES:
        message.sample.TimeUs = flight[next].time_us;
        memcpy(message.sample.RateRadS, flight[next].rate, sizeof flight[next].rate);
        memcpy(message.sample.WheelSpeedRadS, flight[next].wheel, sizeof flight[next].wheel);
        memcpy(message.sample.TorqueNM, flight[next].torque, sizeof flight[next].torque);
        CFE_MSG_Init(&message.buffer.Msg, CFE_SB_ValueToMsgId(FSW_INERTIA_SAMPLE_MID), sizeof message.sample);
        if (++next == end) {
            phase = HOUSEKEEPING;
        }
        return CFE_SUCCESS;
    case HOUSEKEEPING:
        request(FSW_INERTIA_HK_MID);
        phase = SAVE;
        return CFE_SUCCESS;
    case SAVE:
        request(FSW_INERTIA_SAVE_MID);
        phase = OVER;
        return CFE_SUCCESS;
    default:
        return CFE_SB_PIPE_RD_ERR;
    }
}

CFE_Status_t CFE_SB_TransmitMsg(const CFE_MSG_Message_t *MsgPtr, bool IsOrigination) {
    const FSW_INERTIA_Tlm_t *tlm = (const FSW_INERTIA_Tlm_t *)(const void *)MsgPtr;
    (void)IsOrigination;
    printf("telemetry: %u samples, %u rejected, jxx %.6f +- %.6f kg m2, status %u, %u directions\n", tlm->Samples, tlm->Rejected,
           (double)tlm->InertiaKgM2[0], (double)tlm->SigmaKgM2[0], tlm->Status, tlm->ObservedDirections);
    return CFE_SUCCESS;
}

void CFE_SB_TimeStampMsg(CFE_MSG_Message_t *MsgPtr) {
    (void)MsgPtr;
}

int main(void) {
    end = LENGTH / 2;
    FSW_INERTIA_AppMain();
    end = LENGTH;
    phase = SAMPLES;
    FSW_INERTIA_AppMain();
    return 0;
}
