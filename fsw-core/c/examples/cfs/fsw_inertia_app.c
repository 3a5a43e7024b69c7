/* cFS application: inertia estimation by fsw-core's window estimator.
 *
 * Software bus in: gyro samples, housekeeping request, save request. Out: estimate as telemetry. The state is kept in
 * the critical data store and continues after a processor reset of the application.
 *
 * Priority below that of the attitude control: each step costs thousands of instructions, the work in slices takes what
 * time is left. */
#include "fsw_inertia_app.h"
#include <string.h>

#define EVENT_STARTED 1
#define EVENT_REFUSED 2
#define EVENT_STORE 3

/* Slices of work after each sample: bounded, so that the pipe is served again in time. */
#define SLICES_PER_SAMPLE 4

/* One sigma of a gyro sample, rad/s. */
#define GYRO_NOISE_RAD_S 1e-4f

static struct {
    fsw_window Window;
    FSW_INERTIA_Store_t Store;
    FSW_INERTIA_Tlm_t Tlm;
    CFE_SB_PipeId_t Pipe;
    CFE_ES_CDSHandle_t CDS;
    uint32 NextWord;
} App;

/* Call-backs of fsw_window_save and fsw_window_restore: words to and from the copy of the data store. */
static int32_t WriteWord(void *context, uint32_t word) {
    FSW_INERTIA_Store_t *store = context;
    if (store->Length == FSW_WINDOW_WORDS) {
        return 0;
    }
    store->Words[store->Length++] = word;
    return 1;
}

static int32_t ReadWord(void *context, uint32_t *word) {
    const FSW_INERTIA_Store_t *store = context;
    if (App.NextWord >= store->Length || App.NextWord >= FSW_WINDOW_WORDS) {
        return 0;
    }
    *word = store->Words[App.NextWord++];
    return 1;
}

static void Configure(fsw_window_config *config) {
    static const float diagonals[FSW_WHEELS][3] = {{1, 1, 1}, {-1, 1, 1}, {-1, -1, 1}, {1, -1, 1}};
    config->struct_size = sizeof(*config);
    (void)fsw_window_config_defaults(config, GYRO_NOISE_RAD_S);
    memcpy(config->wheels.axis, diagonals, sizeof diagonals);
    for (int i = 0; i < FSW_WHEELS; i++) {
        config->wheels.spin_inertia_kg_m2[i] = 2.1e-5f; /* kg m² */
    }
    config->slices_per_step = 0; /* fsw_window_work() instead */
}

static CFE_Status_t StartEstimator(void) {
    fsw_window_config config;
    char why[80];
    Configure(&config);
    const fsw_result result = fsw_window_init(&App.Window, sizeof App.Window, &config);
    if (result != FSW_RESULT_OK) {
        (void)fsw_window_config_check(&config, why, sizeof why);
        CFE_EVS_SendEvent(EVENT_REFUSED, CFE_EVS_EventType_CRITICAL, "FSW_INERTIA: init refused, code %d: %s", (int)result, why);
        return CFE_STATUS_EXTERNAL_RESOURCE_FAIL;
    }
    return CFE_SUCCESS;
}

/* Registers the critical data store; continues from it where it exists. */
static void OpenStore(void) {
    const CFE_Status_t status = CFE_ES_RegisterCDS(&App.CDS, sizeof App.Store, "INERTIA");
    if (status != CFE_ES_CDS_ALREADY_EXISTS) {
        CFE_EVS_SendEvent(EVENT_STORE, CFE_EVS_EventType_INFORMATION, "FSW_INERTIA: CDS is new, status 0x%08lx", (unsigned long)status);
        return;
    }
    fsw_result result = FSW_RESULT_MEDIUM;
    App.NextWord = 0;
    if (CFE_ES_RestoreFromCDS(&App.Store, App.CDS) == CFE_SUCCESS) {
        result = fsw_window_restore(&App.Window, ReadWord, &App.Store);
    }
    /* After a refusal the estimator is the one that StartEstimator has started. */
    CFE_EVS_SendEvent(EVENT_STORE, CFE_EVS_EventType_INFORMATION, "FSW_INERTIA: %s, code %d",
                      result == FSW_RESULT_OK ? "state restored" : "state not restored", (int)result);
}

static void Save(void) {
    App.Store.Length = 0;
    const fsw_result result = fsw_window_save(&App.Window, WriteWord, &App.Store);
    if (result != FSW_RESULT_OK || CFE_ES_CopyToCDS(App.CDS, &App.Store) != CFE_SUCCESS) {
        CFE_EVS_SendEvent(EVENT_STORE, CFE_EVS_EventType_ERROR, "FSW_INERTIA: state not saved, code %d", (int)result);
    }
}

static void TakeSample(const FSW_INERTIA_Sample_t *message) {
    fsw_sample sample = {.struct_size = sizeof sample, .time_us = message->TimeUs};
    fsw_outcome outcome = {.struct_size = sizeof outcome};
    fsw_remaining remaining;
    memcpy(sample.rate_rad_s, message->RateRadS, sizeof sample.rate_rad_s);
    memcpy(sample.wheel_speed_rad_s, message->WheelSpeedRadS, sizeof sample.wheel_speed_rad_s);
    memcpy(sample.torque_n_m, message->TorqueNM, sizeof sample.torque_n_m);
    if (fsw_window_step(&App.Window, &sample, &outcome) != FSW_RESULT_OK) {
        return; /* the estimator is initialised and the sizes are right: not reached */
    }
    App.Tlm.Samples += outcome.used_sample;
    App.Tlm.Rejected += 1 - outcome.used_sample;
    (void)fsw_window_work(&App.Window, SLICES_PER_SAMPLE, &remaining);
}

static void SendTelemetry(void) {
    fsw_estimate estimate = {.struct_size = sizeof estimate};
    if (fsw_window_estimate(&App.Window, &estimate) != FSW_RESULT_OK) {
        return;
    }
    App.Tlm.BuildFingerprint = fsw_build_fingerprint();
    App.Tlm.Status = (uint32)estimate.status;
    App.Tlm.ObservedDirections = estimate.observed_directions;
    memcpy(App.Tlm.InertiaKgM2, estimate.inertia_kg_m2, sizeof App.Tlm.InertiaKgM2);
    memcpy(App.Tlm.SigmaKgM2, estimate.sigma_kg_m2, sizeof App.Tlm.SigmaKgM2);
    CFE_SB_TimeStampMsg(CFE_MSG_PTR(App.Tlm.TelemetryHeader));
    CFE_SB_TransmitMsg(CFE_MSG_PTR(App.Tlm.TelemetryHeader), true);
}

static CFE_Status_t Init(void) {
    memset(&App.Tlm, 0, sizeof App.Tlm);
    CFE_Status_t status = CFE_EVS_Register(NULL, 0, CFE_EVS_EventFilter_BINARY);
    if (status == CFE_SUCCESS) {
        status = StartEstimator();
    }
    if (status == CFE_SUCCESS) {
        OpenStore();
        status = CFE_SB_CreatePipe(&App.Pipe, FSW_INERTIA_PIPE_DEPTH, "INERTIA");
    }
    static const CFE_SB_MsgId_Atom_t subscribed[] = {FSW_INERTIA_SAMPLE_MID, FSW_INERTIA_HK_MID, FSW_INERTIA_SAVE_MID};
    for (int i = 0; i < 3 && status == CFE_SUCCESS; i++) {
        status = CFE_SB_Subscribe(CFE_SB_ValueToMsgId(subscribed[i]), App.Pipe);
    }
    if (status == CFE_SUCCESS) {
        status = CFE_MSG_Init(CFE_MSG_PTR(App.Tlm.TelemetryHeader), CFE_SB_ValueToMsgId(FSW_INERTIA_TLM_MID), sizeof App.Tlm);
    }
    CFE_EVS_SendEvent(EVENT_STARTED, CFE_EVS_EventType_INFORMATION, "FSW_INERTIA: fsw-core %s, status 0x%08lx", fsw_version(),
                      (unsigned long)status);
    return status;
}

static void Dispatch(const CFE_SB_Buffer_t *buffer) {
    CFE_SB_MsgId_t id;
    CFE_MSG_Size_t size;
    if (CFE_MSG_GetMsgId(&buffer->Msg, &id) != CFE_SUCCESS || CFE_MSG_GetSize(&buffer->Msg, &size) != CFE_SUCCESS) {
        return;
    }
    switch (CFE_SB_MsgIdToValue(id)) {
    case FSW_INERTIA_SAMPLE_MID:
        if (size == sizeof(FSW_INERTIA_Sample_t)) {
            TakeSample((const FSW_INERTIA_Sample_t *)(const void *)buffer);
        }
        break;
    case FSW_INERTIA_HK_MID:
        SendTelemetry();
        break;
    case FSW_INERTIA_SAVE_MID:
        Save();
        break;
    default:
        break;
    }
}

void FSW_INERTIA_AppMain(void) {
    uint32 run = Init() == CFE_SUCCESS ? CFE_ES_RunStatus_APP_RUN : CFE_ES_RunStatus_APP_ERROR;
    while (CFE_ES_RunLoop(&run)) {
        CFE_SB_Buffer_t *buffer;
        if (CFE_SB_ReceiveBuffer(&buffer, App.Pipe, CFE_SB_PEND_FOREVER) == CFE_SUCCESS) {
            Dispatch(buffer);
        }
    }
    CFE_ES_ExitApp(run);
}
