//! On-board estimation of a spacecraft's inertia tensor, one gyro sample per step.
//!
//! Input: body rate from a gyro, wheel speeds, external torque. Output: the six elements of the inertia
//! tensor with their covariance, the observed directions, and a status. No allocation, no unsafe code,
//! no panic; every step costs a bounded amount of work. Everything is generic over [`Real`], `f32` or
//! `f64`; single precision is what flies.
//!
//! # Flow of a sample
//!
//! ```text
//!  1 sample      time-tagged body rate, wheel speeds, external torque, attitude
//!       │
//!  2 gate        finite? in range? in order? stuck? a gap? ──► rejected, with the reason
//!       │
//!  3 estimator   step(sample) -> Outcome; finish() at the end of a log
//!       │          window      outlier gate ─► block averages ─► batch fit, in slices of work
//!       │          joint_ekf   predict, innovation, correct; aligned by a momentum integral
//!       │          ekf_sgf     rate EKF ─► Savitzky-Golay derivative ─► least squares
//!       │          momentum    angular momentum conserved in inertial space
//!       │
//!  4 monitor     outliers, innovation statistics, observed directions, nearest physical tensor
//!       │
//!  5 outcome     updated, coasting or reset, with the reason: after every step
//!    estimate    tensor, covariance, observed directions, status: at the rate of telemetry
//!       │
//!  6 checkpoint  state of the estimator to and from non-volatile memory, bit for bit
//! ```
//!
//! The firmware and the simulator call the same [`Estimator::step`].
//!
//! # Example
//!
//! A motion of three sines, and the torque that it takes; the estimator starts without a prior.
//!
//! ```
//! use fsw_core::estimator::window::{Config, Window};
//! use fsw_core::{Estimator, Inertia, Sample, Status, Vec3, WheelArray};
//!
//! let j = Inertia::new([1.5, 1.2, 1.8, 0.1, -0.2, 0.05]).matrix_kg_m2(); // truth
//! let w = Vec3::new(0.9, 0.6, 0.4); // rad/s
//! let config = Config { is_torque_smooth: true, ..Config::new(1e-4) }; // gyro noise, rad/s
//! let mut window = Window::<f32, 0, 512, 9>::new(config, WheelArray::new([], [])?)?;
//! for k in 0..600 {
//!     let t = 0.1 * k as f32;
//!     let rate = w.map(|w| 0.05 * (w * t).sin());
//!     let acceleration = w.map(|w| 0.05 * w * (w * t).cos());
//!     let torque_n_m = j * acceleration + rate.cross(&(j * rate));
//!     let (time_us, rate_rad_s, wheel_speed_rad_s) = (k * 100_000, rate, []);
//!     let sample = Sample { time_us, rate_rad_s, wheel_speed_rad_s, torque_n_m, attitude: None };
//!     window.step(&sample);
//! }
//! window.finish(); // work that is due: end of the log
//! let estimate = window.estimate();
//! assert_eq!(estimate.status, Status::Converged);
//! assert!((estimate.inertia.elements_kg_m2()[3] - 0.1).abs() < 0.002); // Jxy, kg m²
//! # Ok::<(), fsw_core::ConfigError>(())
//! ```
//!
//! [`docs`] has the pages: theory, hardware, the window estimator, accuracy, the C interface.
//!
//! `cargo run --example window` prints the result of this program. `csv_replay` replays a recorded
//! log, `custom_loop` embeds an estimator in a control loop.
//!
//! # Use
//!
//! 1. **Wheels.** [`WheelArray::new`] takes spin axes in body axes and spin inertias. The number of
//!    wheels is a compile-time constant; zero wheels are permitted.
//! 2. **Configuration.** Each estimator has a `Config` with defaults for a stated gyro noise. A
//!    constructor rejects a value out of its range and names the field ([`ConfigError`]).
//! 3. **Step.** [`Estimator::step`] takes each gyro sample as it arrives, at the rate of the gyro, and
//!    returns an [`Outcome`]. A sample that is not usable is an outcome too, and needs no filter before
//!    the estimator.
//! 4. **Work.** `Window` refines its fit in slices of bounded cost: one with each step, further ones
//!    by [`Window::work`](estimator::window::Window::work) in idle time. [`Estimator::finish`]
//!    completes all work, at the end of a log.
//! 5. **Estimate.** [`Estimator::estimate`] is valid at any time. It costs an eigenproblem of six and
//!    belongs to the rate of telemetry.
//! 6. **Checkpoint.** [`checkpoint::transfer`] writes the whole state to a medium, and reads it back
//!    after a reset of the computer.
//!
//! # Choice of an estimator
//!
//! | estimator | prior | attitude | gyro noise | disturbance torque, gyro bias | after a change of the inertia |
//! |---|---|---|---|---|---|
//! | [`Window`](estimator::window::Window) | none needed | not used | stated or measured | can be unknowns, with drag | distinguished from fault and model error, estimated anew |
//! | [`JointEkf`](estimator::joint_ekf::JointEkf) | none needed, or given | not used | stated | considered, with errors of the hardware | lock-out, estimated anew |
//! | [`EkfSgf`](estimator::ekf_sgf::EkfSgf) | nominal inertia | not used | stated | not modelled | lock-out |
//! | [`Momentum`](estimator::momentum::Momentum) | none | needed | stated | not modelled | not detected |
//!
//! `Window` is the default: it reaches the Cramér-Rao bound without a prior. It takes 44 KiB and idle
//! time of the processor; `JointEkf`, a published filter in factorised form, takes 2.7 KiB and completes
//! its work within the step. The other two reproduce published methods for comparison.
//!
//! # Reading an estimate
//!
//! | [`Status`] | meaning | reaction |
//! |---|---|---|
//! | `Converged` | six directions observed, residuals explained | use the tensor with its covariance |
//! | `Partial` | some directions observed | use the observed elements; excite the other axes |
//! | `Unobservable` | no direction observed | excite the body |
//! | `Diverged` | residuals not explained | do not use the numbers; look for an unmodelled torque |
//!
//! `Converged` is a statement about the model too: with [`Estimate::residuals_white`] equal to
//! `Some(false)` the residuals hold more than noise, and the sigma is too small.
//!
//! A direction is observed once the data have reduced its sigma to a tenth of the range before the
//! data ([`monitor::observability`]); a prior alone observes nothing. Observability depends on the motion: rates about all three axes
//! must vary independently, and a known torque or a known wheel momentum must set the scale. Motion
//! without both determines the ratios of the elements alone ([`Estimate::over_trace`]).
//!
//! # Layers
//!
//! A module depends on the layers above it in this table, never on one below.
//!
//! | layer | modules | depends on |
//! |---|---|---|
//! | errors | [`error`] | nothing |
//! | algebra | [`math`]: scalar, UD factors, square-root information, eigenvalues, Savitzky-Golay | errors |
//! | words | [`persist`](mod@persist): state as a stream of words | algebra |
//! | physics | [`tensor`], [`dynamics`], [`attitude`] | algebra, words |
//! | input | [`sample`], [`gate`] | physics |
//! | vocabulary | [`outcome`], [`prior`], [`estimate`]; [`monitor`] | input, physics |
//! | batch fit | blocks: averages of samples; trajectory: their prediction and its derivatives; fit: Gauss-Newton, prior knowledge. Each depends on those before it | vocabulary, physics |
//! | systems | [`estimator`]: `window`, `joint_ekf`, `ekf_sgf`, `momentum`, independent of each other | all above |
//! | storage | [`checkpoint`]: transfer and fingerprint of a state | words |
//!
//! `math` does not depend on checkpoints, `dynamics` not on `sample`, `monitor` not on `estimator`.
//! Nothing depends on hardware, a clock or a file system.
//!
//! # Conventions
//!
//! * **Frame.** Body axes at the spacecraft's centre of mass. Rates are those of the body relative to
//!   inertial space. Names leave the frame out; a second frame is named where it appears
//!   ([`attitude`]).
//! * **Units.** SI. Public names carry quantity and unit: `rate_rad_s`, `inertia_kg_m2`.
//! * **Elements** are ordered `Jxx Jyy Jzz Jxy Jxz Jyz`. The moments of inertia (MOI) are the diagonal
//!   entries, the products of inertia (POI) the off-diagonal ones, `Jxy = −∫ x y dm`.
//! * **Wheels** are included in `J` as if locked; their speeds are relative to the body.
//! * **Noise** is one sigma. Gyro noise is white and per sample.
//! * **Time** is in whole microseconds, subtracted as integers before it becomes a float.
//!
//! # Numerical rules
//!
//! * Covariances are factorised (`U D Uᵀ`, or a square root of the information), so that single
//!   precision suffices.
//! * Quantities are scaled to the size of the body where products of small inertias could underflow
//!   in `f32`.
//! * Functions come from `libm`, and no operation is fused: host and target agree bit for bit.
//! * Loops have bounds known at compile time, and no step waits for convergence.
//! * Comparisons are written so that NaN leads to a rejection or a reset.
//!
//! Equation of motion of the gyrostat:
//!
//! `J ω̇ + ḣ_w + ω × (J ω + h_w) = τ`, `h_w = Σᵢ Iₛᵢ Ωᵢ aᵢ`.
//!
//! # Symbols
//!
//! | symbol | quantity | unit | in the code |
//! |---|---|---|---|
//! | `ω` | body rate | rad/s | `rate_rad_s` |
//! | `ω̇` | angular acceleration | rad/s² | `acceleration_rad_s2` |
//! | `J` | inertia tensor, 3×3 | kg m² | [`Inertia`] |
//! | `j` | its six elements | kg m² | `elements_kg_m2` |
//! | `Ω`, `Iₛ`, `a` | wheel speed, spin inertia, unit spin axis | rad/s, kg m², – | `wheel_speed_rad_s`, [`WheelArray`] |
//! | `h_w` | momentum of the wheels relative to the body | N m s | `wheel_momentum_n_m_s` |
//! | `H` | total angular momentum, `J ω + h_w` | N m s | `momentum` |
//! | `τ` | external torque | N m | `torque_n_m` |
//! | `q` | attitude quaternion, scalar last | – | [`Quaternion`] |
//! | `G(v)` | regressor, `J v = G(v) j` | unit of `v` | [`tensor::regressor`] |
//! | `v^×` | matrix of the cross product, `v^× b = v × b` | unit of `v` | [`math::skew`] |
//! | `Δt` | interval between two samples | s | `duration_s` |
//! | `A`, `B` | transition of rate and inertia errors over an interval | –, rad/s per kg m² | [`dynamics::step::Transition`] |
//! | `z`, `ν`, `S` | measurement, innovation, innovation covariance | rad/s, rad/s, rad²/s² | [`Innovation`] |
//! | `P` | covariance, `U D Uᵀ` | unit² | [`math::ud::Ud`] |
//! | `R`, `d` | square-root information, `R x = d` | 1/unit, – | [`math::square_root_information`] |
//! | `K` | Kalman gain | – | `gain` |
//! | `σ` | standard deviation | unit | `sigma` |
//! | NIS | normalised innovation squared, `νᵀ S⁻¹ ν` | – | [`Innovation::nis`] |
//! | `θ` | unknowns of a window | scaled | [`estimator::window`] |
//! | `n`, `q`, `κ` in `window` | tensor over its trace, its shape, inverse trace | –, –, 1/(kg m²) | [`estimator::window::unknowns`] |
//!
//! # Terms
//!
//! | term | meaning |
//! |---|---|
//! | alignment | first estimate of the inertia from the motion, without a prior |
//! | block | average over a few samples, the unit of storage of `window` |
//! | coasting | a step without an update of the estimate |
//! | consistent | errors agree with the stated covariance |
//! | Cramér-Rao bound | smallest covariance of any unbiased estimator for a given motion and noise |
//! | excitation | motion that makes directions of the inertia observable |
//! | front | last fit of `window`, which takes in further blocks |
//! | gap | interval between samples too long for a prediction |
//! | gyrostat | rigid body with spinning wheels |
//! | lock-out | series of rejected samples that shows the estimate itself to be wrong |
//! | NEES | normalised estimation error squared per degree of freedom, `(ĵ − j)ᵀ P⁻¹ (ĵ − j) / 6` |
//! | observed direction | combination of the six elements whose sigma the data have reduced to a tenth |
//! | pass | one Gauss-Newton iteration over the blocks of a window |
//! | physical | possible for a rigid body: positive definite, triangle inequality |
//! | residual | measured minus predicted rate, after an update |
//! | slice | part of the work of `window`, of bounded cost |
//! | spike | sample beyond the limit in sigmas of its prediction, by a filter or by neighbouring samples |
//! | test ratio | innovation over its sigma |
//! | window | stretch of motion that is fitted as a whole |
//!
//! # Sources
//!
//! Cited under their key throughout the workspace.
//!
//! Estimators:
//!
//! * \[Bellar2019\] A. Bellar, M. A. Si Mohammed, *Satellite inertia parameters estimation based
//!   on extended Kalman filter*, J. Aerosp. Technol. Manag. 11, e1619, 2019.
//! * \[ElHariry2026\] M. El Hariry et al., *When does excitation design help spacecraft inertia
//!   identification? A first-principles study of the observability-accuracy link*, draft, 2026.
//! * \[Kim2010\] D. H. Kim, D.-G. Choi, H.-S. Oh, *Inertia estimation of spacecraft based on
//!   modified law of conservation of angular momentum*, J. Astron. Space Sci. 27(4), 353-357, 2010.
//! * \[Kim2013\] D. Kim, slides on moments of inertia by extended Kalman filter, causal
//!   Savitzky-Golay filter and recursive least squares, Annual Technical Symposium, May 2013.
//! * \[Kim2016\] D. Kim, S. Yang, S. Lee, *Rigid body inertia estimation using extended Kalman and
//!   Savitzky-Golay filters*, Math. Probl. Eng. 2016, 2962671.
//!
//! Body:
//!
//! * \[Likins1970\] P. W. Likins, *Dynamics and control of flexible space vehicles*, JPL TR 32-1329, 1970.
//!
//! Algebra:
//!
//! * \[Agee1972\] W. S. Agee, R. H. Turner, *Triangular decomposition of a positive definite matrix
//!   plus a symmetric dyad with application to Kalman filtering*, White Sands Missile Range, Technical
//!   Report 38, 1972.
//! * \[Bierman1977\] G. J. Bierman, *Factorization Methods for Discrete Sequential Estimation*,
//!   Academic Press, 1977.
//! * \[Gentleman1973\] W. M. Gentleman, *Least squares computations by Givens transformations without
//!   square roots*, J. Inst. Maths Applics 12, 329-336, 1973; as a program *Algorithm AS 75*, Appl.
//!   Statist. 23, 448-454, 1974.
//! * \[Golub2013\] G. H. Golub, C. F. Van Loan, *Matrix Computations*, 4th edition, Johns Hopkins
//!   University Press, 2013.
//! * \[Gorry1990\] P. A. Gorry, *General least-squares smoothing and differentiation by the convolution
//!   (Savitzky-Golay) method*, Anal. Chem. 62, 570-573, 1990.
//! * \[Hildreth1957\] C. Hildreth, *A quadratic programming procedure*, Naval Res. Logist. Q. 4,
//!   79-85, 1957.
//! * \[BarShalom2001\] Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications to
//!   Tracking and Navigation*, Wiley, 2001.
//! * \[Huang2010\] G. P. Huang, A. I. Mourikis, S. I. Roumeliotis, *Observability-based rules for designing consistent
//!   EKF SLAM estimators*, Int. J. Robotics Res. 29, 502-528, 2010.
//! * \[Kay1993\] S. M. Kay, *Fundamentals of Statistical Signal Processing: Estimation Theory*,
//!   Prentice Hall, 1993.
//! * \[Kelley1960\] J. E. Kelley, *The cutting-plane method for solving convex programs*, J. SIAM 8,
//!   703-712, 1960.
//! * \[Savitzky1964\] A. Savitzky, M. J. E. Golay, *Smoothing and differentiation of data by simplified
//!   least squares procedures*, Anal. Chem. 36, 1627-1639, 1964.
//! * \[Schmidt1966\] S. F. Schmidt, *Application of state-space methods to navigation problems*, Advances in Control
//!   Systems 3, 293-340, Academic Press, 1966.
//! * \[Thornton1976\] C. L. Thornton, *Triangular covariance factorizations for Kalman filtering*,
//!   JPL TM 33-798, 1976.
//!
//! Integration:
//!
//! * \[Hairer1993\] E. Hairer, S. P. Nørsett, G. Wanner, *Solving Ordinary Differential Equations I*,
//!   2nd edition, Springer, 1993.
//! * \[Iserles1999\] A. Iserles, S. P. Nørsett, *On the solution of linear differential equations in Lie
//!   groups*, Phil. Trans. R. Soc. A 357, 983-1019, 1999.
//! * \[Magnus1954\] W. Magnus, *On the exponential solution of differential equations for a linear
//!   operator*, Comm. Pure Appl. Math. 7, 649-673, 1954.
//! * \[Prince1981\] P. J. Prince, J. R. Dormand, *High order embedded Runge-Kutta formulae*, J. Comput.
//!   Appl. Math. 7, 67-75, 1981.
//!
//! Statistics:
//!
//! * \[Birge1932\] R. T. Birge, *The calculation of errors by the method of least squares*, Phys. Rev. 40, 207-227, 1932.
//! * \[Brown1975\] R. L. Brown, J. Durbin, J. M. Evans, *Techniques for testing the constancy of
//!   regression relationships over time*, J. R. Stat. Soc. B 37, 149-192, 1975.
//! * \[Davies1977\] R. B. Davies, *Hypothesis testing when a nuisance parameter is present only under the
//!   alternative*, Biometrika 64, 247-254, 1977.
//! * \[Knuth1997\] D. E. Knuth, *The Art of Computer Programming, Volume 2: Seminumerical
//!   Algorithms*, 3rd edition, Addison-Wesley, 1997.
//! * \[Laurent2000\] B. Laurent, P. Massart, *Adaptive estimation of a quadratic functional by model
//!   selection*, Ann. Stat. 28, 1302-1338, 2000.
//! * \[Page1954\] E. S. Page, *Continuous inspection schemes*, Biometrika 41, 100-115, 1954.
//! * \[Siegmund1985\] D. Siegmund, *Sequential Analysis: Tests and Confidence Intervals*, Springer,
//!   1985.
//! * \[Marsaglia2003\] G. Marsaglia, *Xorshift RNGs*, J. Stat. Softw. 8(14), 2003.
//!
//! Hardware and links:
//!
//! * \[BMI088\] Bosch Sensortec, *BMI088 data sheet*, BST-BMI088-DS001.
//! * \[DS8626\] STMicroelectronics, *STM32F405xx, STM32F407xx data sheet*, DS8626.
//! * \[RM0090\] STMicroelectronics, *STM32F405/415, 407/417, 427/437, 429/439 reference manual*, RM0090.
//! * \[PM0214\] STMicroelectronics, *STM32 Cortex-M4 MCUs and MPUs programming manual*, PM0214.
//! * \[CCSDS133\] CCSDS 133.0-B-2, *Space Packet Protocol*, 2020.
//! * \[CCSDS232\] CCSDS 232.1-B, *Communications Operation Procedure-1*.
//! * \[deBoor2001\] C. de Boor, *A Practical Guide to Splines*, revised edition, Springer, 2001.
//! * \[Cheshire1999\] S. Cheshire, M. Baker, *Consistent overhead byte stuffing*, IEEE/ACM Trans.
//!   Netw. 7, 159-172, 1999.
#![no_std]
#![forbid(unsafe_code)]

pub mod docs;

pub mod sample;

pub mod gate;

mod blocks;
mod fit;
mod trajectory;

pub mod estimator;

pub mod monitor;

pub mod hardware;

pub mod manoeuvre;

pub mod estimate;
pub mod outcome;
pub mod prior;

pub mod checkpoint;
pub mod persist;

pub mod attitude;
pub mod dynamics;
pub mod error;
pub mod math;
pub mod tensor;

pub use attitude::Quaternion;
pub use dynamics::wheels::WheelArray;
pub use error::ConfigError;
pub use estimate::{Estimate, Status};
pub use estimator::Estimator;
pub use math::{Mat, Vec3, scalar::Real};
pub use monitor::innovation::Innovation;
pub use outcome::{Coasting, Outcome, Reset};
pub use prior::Prior;
pub use sample::Sample;
pub use tensor::Inertia;

#[cfg(test)]
extern crate std;
