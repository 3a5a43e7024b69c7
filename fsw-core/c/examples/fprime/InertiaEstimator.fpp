module Gnc {

  @ Gyro sample with the drive of the body at its instant
  struct GyroSample {
    timeUs: U64 @< microseconds
    rateRadS: [3] F32 @< body rate, rad/s, body axes
    wheelSpeedRadS: [4] F32 @< relative to the body, rad/s
    torqueNM: [3] F32 @< external torque, N m, body axes
  }

  port GyroSamplePort(ref sample: GyroSample)

  @ Inertia estimation by fsw-core
  queued component InertiaEstimator {
    async input port sampleIn: GyroSamplePort
    @ Rate group: work in slices, telemetry
    sync input port schedIn: Svc.Sched

    telemetry Status: U32 @< fsw_status
    telemetry Directions: U32 @< observed directions, 0 to 6
    telemetry Jxx: F32 @< kg m2
    telemetry Jyy: F32 @< kg m2
    telemetry Jzz: F32 @< kg m2
    telemetry Rejected: U32 @< samples that did not enter the state

    event Refused(code: I32) severity warning high format "fsw-core refused with code {}"

    @ Keeps the state in a file
    async command SAVE
    @ Continues from the file
    async command RESTORE

    time get port timeCaller
    telemetry port tlmOut
    event port logOut
    text event port logTextOut
    command recv port cmdIn
    command reg port cmdRegOut
    command resp port cmdRespOut
  }
}
