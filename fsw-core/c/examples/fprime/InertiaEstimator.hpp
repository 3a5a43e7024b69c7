// F Prime component: inertia estimation by fsw-core's window estimator. Model: InertiaEstimator.fpp.
#ifndef GNC_INERTIA_ESTIMATOR_HPP
#define GNC_INERTIA_ESTIMATOR_HPP

#include "InertiaEstimatorComponentAc.hpp"
#include "fsw_core.h"

namespace Gnc {

class InertiaEstimator final : public InertiaEstimatorComponentBase {
  public:
    explicit InertiaEstimator(const char* compName);

    //! Starts the estimator: once, before the tasks. Returns false where fsw-core refuses the configuration.
    bool configure(const fsw_window_config& config);

  private:
    void sampleIn_handler(FwIndexType portNum, GyroSample& sample) override;
    void schedIn_handler(FwIndexType portNum, U32 context) override;
    void SAVE_cmdHandler(FwOpcodeType opCode, U32 cmdSeq) override;
    void RESTORE_cmdHandler(FwOpcodeType opCode, U32 cmdSeq) override;

    //! Sends an event for each refusal. Returns true for OK.
    bool check(fsw_result result);

    fsw_window m_window;
    U32 m_rejected;
};

}  // namespace Gnc

#endif
