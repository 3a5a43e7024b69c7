/* STUB of the cFE interface, for compiling and running the example without cFS: the names and parameters that
 * fsw_inertia_app.c uses, as cFE 7 has them. Not a part of cFS; sizes of headers differ. In a mission the application is
 * built with the cfe.h of the mission. */
#ifndef CFE_STUB_H
#define CFE_STUB_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef int32_t int32;
typedef uint16_t uint16;
typedef uint32_t uint32;
typedef uint64_t uint64;

typedef int32 CFE_Status_t;
#define CFE_SUCCESS ((CFE_Status_t)0)
#define CFE_STATUS_EXTERNAL_RESOURCE_FAIL ((CFE_Status_t)0xc8000005)
#define CFE_ES_CDS_ALREADY_EXISTS ((CFE_Status_t)0x4400000d)
#define CFE_SB_PIPE_RD_ERR ((CFE_Status_t)0xca000008)

typedef uint32 CFE_SB_MsgId_Atom_t;
typedef struct {
    CFE_SB_MsgId_Atom_t Value;
} CFE_SB_MsgId_t;
typedef size_t CFE_MSG_Size_t;
typedef struct {
    CFE_SB_MsgId_t Id;
    uint32 Size;
} CFE_MSG_Message_t;
typedef struct {
    CFE_MSG_Message_t Msg;
    uint32 Time[2];
} CFE_MSG_TelemetryHeader_t;
typedef union {
    CFE_MSG_Message_t Msg;
    uint64 Aligned;
} CFE_SB_Buffer_t;
typedef uint32 CFE_SB_PipeId_t;
typedef uint32 CFE_ES_CDSHandle_t;

#define CFE_MSG_PTR(header) (&(header).Msg)
#define CFE_SB_PEND_FOREVER (-1)
#define CFE_ES_RunStatus_APP_RUN 1u
#define CFE_ES_RunStatus_APP_ERROR 3u
#define CFE_EVS_EventFilter_BINARY 0
typedef enum {
    CFE_EVS_EventType_DEBUG = 1,
    CFE_EVS_EventType_INFORMATION = 2,
    CFE_EVS_EventType_ERROR = 3,
    CFE_EVS_EventType_CRITICAL = 4
} CFE_EVS_EventType_Enum_t;

static inline CFE_SB_MsgId_t CFE_SB_ValueToMsgId(CFE_SB_MsgId_Atom_t value) {
    return (CFE_SB_MsgId_t){value};
}
static inline CFE_SB_MsgId_Atom_t CFE_SB_MsgIdToValue(CFE_SB_MsgId_t id) {
    return id.Value;
}

bool CFE_ES_RunLoop(uint32 *RunStatus);
void CFE_ES_ExitApp(uint32 ExitStatus);
CFE_Status_t CFE_ES_RegisterCDS(CFE_ES_CDSHandle_t *HandlePtr, size_t BlockSize, const char *Name);
CFE_Status_t CFE_ES_CopyToCDS(CFE_ES_CDSHandle_t Handle, const void *DataToCopy);
CFE_Status_t CFE_ES_RestoreFromCDS(void *RestoreToMemory, CFE_ES_CDSHandle_t Handle);
CFE_Status_t CFE_EVS_Register(const void *Filters, uint16 NumEventFilters, uint16 FilterScheme);
CFE_Status_t CFE_EVS_SendEvent(uint16 EventID, CFE_EVS_EventType_Enum_t EventType, const char *Spec, ...);
CFE_Status_t CFE_MSG_Init(CFE_MSG_Message_t *MsgPtr, CFE_SB_MsgId_t MsgId, CFE_MSG_Size_t Size);
CFE_Status_t CFE_MSG_GetMsgId(const CFE_MSG_Message_t *MsgPtr, CFE_SB_MsgId_t *MsgId);
CFE_Status_t CFE_MSG_GetSize(const CFE_MSG_Message_t *MsgPtr, CFE_MSG_Size_t *Size);
CFE_Status_t CFE_SB_CreatePipe(CFE_SB_PipeId_t *PipeIdPtr, uint16 Depth, const char *PipeName);
CFE_Status_t CFE_SB_Subscribe(CFE_SB_MsgId_t MsgId, CFE_SB_PipeId_t PipeId);
CFE_Status_t CFE_SB_ReceiveBuffer(CFE_SB_Buffer_t **BufPtr, CFE_SB_PipeId_t PipeId, int32 TimeOut);
CFE_Status_t CFE_SB_TransmitMsg(const CFE_MSG_Message_t *MsgPtr, bool IsOrigination);
void CFE_SB_TimeStampMsg(CFE_MSG_Message_t *MsgPtr);

#endif
