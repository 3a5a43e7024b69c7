#include "InertiaEstimator.hpp"

#include <cstring>

#include "Os/File.hpp"

namespace Gnc {

namespace {

//! Slices of work in a cycle of the rate group: bounded.
constexpr U32 SLICES_PER_CYCLE = 4;
constexpr const char* STATE_FILE = "inertia.state";

//! Call-backs: words of the state to and from a file.
extern "C" I32 writeWord(void* context, U32 word) {
    FwSizeType size = sizeof word;
    const Os::File::Status status = static_cast<Os::File*>(context)->write(reinterpret_cast<const U8*>(&word), size);
    return status == Os::File::OP_OK && size == sizeof word;
}

extern "C" I32 readWord(void* context, U32* word) {
    FwSizeType size = sizeof *word;
    const Os::File::Status status = static_cast<Os::File*>(context)->read(reinterpret_cast<U8*>(word), size);
    return status == Os::File::OP_OK && size == sizeof *word;
}

}  // namespace

InertiaEstimator::InertiaEstimator(const char* compName)
    : InertiaEstimatorComponentBase(compName), m_window(), m_rejected(0) {}

bool InertiaEstimator::configure(const fsw_window_config& config) {
    return this->check(fsw_window_init(&this->m_window, sizeof this->m_window, &config));
}

void InertiaEstimator::sampleIn_handler(FwIndexType, GyroSample& received) {
    fsw_sample sample = {};
    sample.struct_size = sizeof sample;
    sample.time_us = received.timeUs;
    std::memcpy(sample.rate_rad_s, received.rateRadS, sizeof sample.rate_rad_s);
    std::memcpy(sample.wheel_speed_rad_s, received.wheelSpeedRadS, sizeof sample.wheel_speed_rad_s);
    std::memcpy(sample.torque_n_m, received.torqueNM, sizeof sample.torque_n_m);
    fsw_outcome outcome = {};
    outcome.struct_size = sizeof outcome;
    if (this->check(fsw_window_step(&this->m_window, &sample, &outcome))) {
        this->m_rejected += 1 - outcome.used_sample;
    }
}

void InertiaEstimator::schedIn_handler(FwIndexType, U32) {
    // Samples, in the thread of the rate group.
    while (this->doDispatch() == MSG_DISPATCH_OK) {
    }
    fsw_remaining remaining;
    (void)this->check(fsw_window_work(&this->m_window, SLICES_PER_CYCLE, &remaining));
    fsw_estimate estimate = {};
    estimate.struct_size = sizeof estimate;
    if (this->check(fsw_window_estimate(&this->m_window, &estimate))) {
        this->tlmWrite_Status(static_cast<U32>(estimate.status));
        this->tlmWrite_Directions(estimate.observed_directions);
        this->tlmWrite_Jxx(estimate.inertia_kg_m2[0]);
        this->tlmWrite_Jyy(estimate.inertia_kg_m2[1]);
        this->tlmWrite_Jzz(estimate.inertia_kg_m2[2]);
        this->tlmWrite_Rejected(this->m_rejected);
    }
}

void InertiaEstimator::SAVE_cmdHandler(FwOpcodeType opCode, U32 cmdSeq) {
    Os::File file;
    bool isSaved = file.open(STATE_FILE, Os::File::OPEN_CREATE) == Os::File::OP_OK;
    isSaved = isSaved && this->check(fsw_window_save(&this->m_window, writeWord, &file));
    file.close();
    this->cmdResponse_out(opCode, cmdSeq, isSaved ? Fw::CmdResponse::OK : Fw::CmdResponse::EXECUTION_ERROR);
}

void InertiaEstimator::RESTORE_cmdHandler(FwOpcodeType opCode, U32 cmdSeq) {
    Os::File file;
    bool isRestored = file.open(STATE_FILE, Os::File::OPEN_READ) == Os::File::OP_OK;
    isRestored = isRestored && this->check(fsw_window_restore(&this->m_window, readWord, &file));
    file.close();
    this->cmdResponse_out(opCode, cmdSeq, isRestored ? Fw::CmdResponse::OK : Fw::CmdResponse::EXECUTION_ERROR);
}

bool InertiaEstimator::check(fsw_result result) {
    if (result != FSW_RESULT_OK) {
        this->log_WARNING_HI_Refused(static_cast<I32>(result));
    }
    return result == FSW_RESULT_OK;
}

}  // namespace Gnc
