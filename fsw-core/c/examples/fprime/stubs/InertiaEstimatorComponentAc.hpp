// STUB of the base class that F Prime's autocoder generates from InertiaEstimator.fpp, for compiling and running the
// example without F Prime. Not a part of F Prime: ports, queue and dictionary are reduced to what the component uses.
#ifndef INERTIA_ESTIMATOR_COMPONENT_AC_STUB_HPP
#define INERTIA_ESTIMATOR_COMPONENT_AC_STUB_HPP

#include <cstddef>
#include <cstdint>
#include <cstdio>

using U8 = uint8_t;
using U32 = uint32_t;
using U64 = uint64_t;
using I32 = int32_t;
using F32 = float;
using FwIndexType = int16_t;
using FwSizeType = U64;
using FwOpcodeType = U32;

namespace Fw {
struct CmdResponse {
    enum T { OK, EXECUTION_ERROR };
};
}  // namespace Fw

namespace Gnc {

struct GyroSample {
    U64 timeUs;
    F32 rateRadS[3];
    F32 wheelSpeedRadS[4];
    F32 torqueNM[3];
};

class InertiaEstimatorComponentBase {
  public:
    // In F Prime these arrive by ports.
    void sample(GyroSample& sample) { this->sampleIn_handler(0, sample); }
    void cycle() { this->schedIn_handler(0, 0); }
    void save() { this->SAVE_cmdHandler(0, 0); }
    void restore() { this->RESTORE_cmdHandler(1, 0); }

  protected:
    enum MsgDispatchStatus { MSG_DISPATCH_OK, MSG_DISPATCH_EMPTY };

    explicit InertiaEstimatorComponentBase(const char*) {}
    virtual ~InertiaEstimatorComponentBase() = default;

    virtual void sampleIn_handler(FwIndexType portNum, GyroSample& sample) = 0;
    virtual void schedIn_handler(FwIndexType portNum, U32 context) = 0;
    virtual void SAVE_cmdHandler(FwOpcodeType opCode, U32 cmdSeq) = 0;
    virtual void RESTORE_cmdHandler(FwOpcodeType opCode, U32 cmdSeq) = 0;

    // The queue of the stub is empty: samples are handled as they arrive.
    MsgDispatchStatus doDispatch() { return MSG_DISPATCH_EMPTY; }

    void tlmWrite_Status(U32 value) { this->m_status = value; }
    void tlmWrite_Directions(U32 value) { std::printf("status %u, %u directions\n", this->m_status, value); }
    void tlmWrite_Jxx(F32) {}
    void tlmWrite_Jyy(F32) {}
    void tlmWrite_Jzz(F32) {}
    void tlmWrite_Rejected(U32) {}
    void log_WARNING_HI_Refused(I32 code) { std::printf("refused: %d\n", code); }
    void cmdResponse_out(FwOpcodeType opCode, U32, Fw::CmdResponse::T response) {
        std::printf("command %u: %s\n", opCode, response == Fw::CmdResponse::OK ? "OK" : "error");
    }

  private:
    U32 m_status = 0;
};

}  // namespace Gnc

#endif
