//! Rates of the gate on flights with white noise: false alarms, detection, bridging, noise.

use super::*;
use crate::dynamics::gyrostat::Gyrostat;
use crate::dynamics::interval::{Drive, Interval};
use crate::dynamics::step::runge_kutta_4;
use crate::persist::{Archive, Words};
use crate::tensor::Inertia;
use proptest::prelude::*;
use std::vec::Vec;

type Gate = OutlierGate<f32, (Vec3<f32>, Vec3<f32>)>;

/// Normal random numbers: xorshift and Box-Muller, the same on every machine.
struct Dice(u64);

impl Dice {
    fn flat(&mut self) -> f64 {
        for shift in [13, -7, 17] {
            self.0 ^= if shift > 0 { self.0 << shift } else { self.0 >> -shift };
        }
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        let (a, b) = (self.flat().max(1e-300), self.flat());
        libm::sqrt(-2.0 * libm::log(a)) * libm::cos(core::f64::consts::TAU * b)
    }

    fn vector(&mut self, sigma: f64) -> Vec3<f64> {
        Vec3::from_fn(|_, _| sigma * self.normal())
    }
}

/// Even samples of a motion.
#[derive(Clone)]
struct Flight {
    period_s: f64,
    noise_rad_s: f64,
    rates_rad_s: Vec<Vec3<f64>>,
}

impl Flight {
    /// Integrates a body under a torque (N m) of time and rate.
    fn of(
        inertia: [f64; 6],
        start: Vec3<f64>,
        (period_s, noise_rad_s, samples): (f64, f64, usize),
        torque: impl Fn(f64, &Vec3<f64>) -> Vec3<f64>,
    ) -> Self {
        const STEPS: usize = 10;
        let body = Gyrostat::new(&Inertia::new(inertia)).unwrap();
        let (mut rate, step_s) = (start, period_s / STEPS as f64);
        let mut rates_rad_s = std::vec![start];
        for k in 1..(samples - 1) * STEPS + 1 {
            let torque_n_m = torque(k as f64 * step_s, &rate);
            let drive = Drive { torque_n_m, wheel_momentum_n_m_s: Vec3::zeros() };
            let interval = Interval { duration_s: step_s, start: drive, middle: drive, end: drive };
            rate = runge_kutta_4(&body, &rate, &interval);
            if k % STEPS == 0 {
                rates_rad_s.push(rate);
            }
        }
        Self { period_s, noise_rad_s, rates_rad_s }
    }

    fn rest(samples: usize) -> Self {
        Self { period_s: 0.1, noise_rad_s: 1e-3, rates_rad_s: std::vec![Vec3::zeros(); samples] }
    }

    /// Torque-free, 1 rad/s, 10 Hz.
    fn tumble(samples: usize) -> Self {
        let start = Vec3::new(0.7, 0.4, -0.6);
        Self::of([1.5, 1.2, 1.8, 0.1, -0.2, 0.05], start, (0.1, 1e-3, samples), |_, _| {
            Vec3::zeros()
        })
    }

    /// The STSAT-3 body from rest, torque pulses about each axis in turn, 10 Hz.
    fn spin_up() -> Self {
        let inertia = [14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016];
        Self::of(inertia, Vec3::zeros(), (0.1, 1.8e-4, 6000), |t, _| {
            let sign = if libm::fmod(t, 40.0) < 20.0 { 0.02 } else { -0.02 };
            match (t / 40.0) as u32 % 4 {
                _ if t < 30.0 => Vec3::zeros(),
                0 => Vec3::new(sign, 0.0, 0.0),
                1 => Vec3::new(0.0, sign, 0.3 * sign),
                2 => Vec3::new(0.0, -sign, sign),
                _ => Vec3::new(sign, sign, 0.0),
            }
        })
    }

    /// Thrown by hand from rest, 10 rad/s with drag, 200 Hz.
    fn throw(samples: usize) -> Self {
        let inertia = [1.1e-3, 1.9e-3, 2.6e-3, 1e-4, -5e-5, 2e-5];
        Self::of(inertia, Vec3::zeros(), (0.005, 4e-3, samples), |t, rate| match t {
            0.0..0.3 => Vec3::zeros(),
            0.3..0.5 => Vec3::new(0.04, 0.07, -0.05) * libm::sin((t - 0.3) * 15.7),
            _ => rate * (-1e-5 * rate.norm()),
        })
    }

    /// Readings with noise, one seed each.
    fn readings(&self, seed: u64) -> Vec<Vec3<f32>> {
        let mut dice = Dice(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
        (0..20).for_each(|_| {
            dice.flat();
        });
        let noisy = self.rates_rad_s.iter().map(|rate| rate + dice.vector(self.noise_rad_s));
        noisy.map(|rate| rate.map(|x| x as f32)).collect()
    }
}

/// All samples through a gate, in order.
fn judge(gate: &mut Gate, period_s: f64, readings: &[Vec3<f32>], floor: f64) -> Vec<bool> {
    filter(gate, period_s, readings, floor).iter().map(|j| j.is_accepted).collect()
}

fn filter<P: Copy + Blank>(
    gate: &mut OutlierGate<f32, P>,
    period_s: f64,
    readings: &[Vec3<f32>],
    floor: f64,
) -> Vec<Judged<f32, P>> {
    let mut judged = Vec::new();
    for rate in readings {
        judged.extend(gate.push(period_s as f32, *rate, P::blank(), floor as f32));
        judged.extend(std::iter::from_fn(|| gate.ready()));
    }
    judged.extend(std::iter::from_fn(|| gate.drain()));
    assert_eq!(judged.len(), readings.len());
    judged
}

/// Number of samples that a gate of its own refuses in each of some flights.
fn false_alarms(flight: &Flight, seeds: u64) -> u32 {
    let mut refused = 0;
    for floor in [0.0, flight.noise_rad_s] {
        for seed in 0..seeds {
            let mut gate = Gate::new();
            judge(&mut gate, flight.period_s, &flight.readings(seed), floor);
            refused += gate.refused();
        }
    }
    refused
}

/// 2e5 samples each, noise unknown and known.
#[test]
fn white_noise_raises_no_alarm() {
    assert!(false_alarms(&Flight::rest(100_000), 1) < 5);
    assert!(false_alarms(&Flight::tumble(100_000), 1) < 5);
    assert!(false_alarms(&Flight::spin_up(), 16) < 10);
    assert!(false_alarms(&Flight::throw(1000), 100) < 10);
}

fn flights() -> [Flight; 4] {
    [Flight::rest(400), Flight::tumble(400), Flight::spin_up(), Flight::throw(600)]
}

/// Spikes of 20, 100 and 1000 sigma on one axis, half of them among samples 3 to 10.
#[test]
fn a_spike_is_refused_wherever_it_is() {
    let (mut caught, mut innocent, mut total) = (0, 0, 0);
    for flight in flights() {
        for (floor, sigmas) in [(0.0, 20.0), (0.0, 100.0), (0.0, 1e3), (1.0, 20.0), (1.0, 1e3)] {
            for seed in 0..200u64 {
                let mut readings = flight.readings(seed);
                readings.truncate(400);
                let late = (seed * 7919 % 388) as usize + 11;
                let place = if seed % 2 == 0 { 3 + (seed / 2 % 8) as usize } else { late };
                readings[place][seed as usize % 3] += (sigmas * flight.noise_rad_s) as f32;
                let floor = floor * flight.noise_rad_s;
                let verdicts = judge(&mut Gate::new(), flight.period_s, &readings, floor);
                let refused = verdicts.iter().filter(|is_accepted| !**is_accepted).count();
                caught += usize::from(!verdicts[place]);
                innocent += refused - usize::from(!verdicts[place]);
                total += 1;
            }
        }
    }
    assert!(1000 * caught >= 995 * total, "{caught} of {total}");
    assert!(innocent < total / 100, "{innocent} of {total}");
}

/// Spoils samples, and marks them.
fn spoil(
    flight: &Flight,
    seed: u64,
    mut fault: impl FnMut(&mut Dice, &mut Vec3<f32>) -> bool,
) -> (Vec<Vec3<f32>>, Vec<bool>) {
    let (mut readings, mut dice) = (flight.readings(seed), Dice(seed * 77 + 5));
    (0..20).for_each(|_| {
        dice.flat();
    });
    let spoilt = readings.iter_mut().map(|rate| fault(&mut dice, rate)).collect();
    (readings, spoilt)
}

/// Shares of refused samples among the spoilt and among the others, ratio of the measured noise to
/// the true one, RMS error of the bridged rates in sigmas.
fn shares(
    flight: &Flight,
    fault: impl FnMut(&mut Dice, &mut Vec3<f32>) -> bool + Clone,
) -> [f64; 4] {
    let mut of = [[0.0; 2]; 2];
    let (mut noise, mut bridge) = (0.0, 0.0);
    for seed in 0..20 {
        let (readings, spoilt) = spoil(flight, seed, fault.clone());
        let mut gate = Gate::new();
        let judged = filter(&mut gate, flight.period_s, &readings, 0.0);
        noise += f64::from(gate.noise_rad_s()) / flight.noise_rad_s / 20.0;
        for ((judged, is_spoilt), truth) in judged.iter().zip(spoilt).zip(&flight.rates_rad_s) {
            of[usize::from(is_spoilt)][usize::from(judged.is_accepted)] += 1.0;
            if !judged.is_accepted {
                let error = judged.rate_rad_s.map(f64::from) - truth;
                bridge += error.dot(&error) / (3.0 * flight.noise_rad_s * flight.noise_rad_s);
            }
        }
    }
    let [[innocent, accepted], [caught, missed]] = of;
    let rms = libm::sqrt(bridge / (innocent + caught).max(1.0));
    [caught / (caught + missed).max(1.0), innocent / (innocent + accepted), noise, rms]
}

/// 3 % of outliers of 20 sigma on one axis; 10 % of zeros, single and in bursts of five.
#[test]
fn many_outliers_are_refused_and_measure_no_noise() {
    let flight = Flight::tumble(3000);
    let sigma = flight.noise_rad_s;
    let outliers = move |dice: &mut Dice, rate: &mut Vec3<f32>| {
        let is_spoilt = dice.flat() < 0.03;
        let (axis, sign) =
            ((dice.flat() * 3.0) as usize, if dice.flat() < 0.5 { 1.0 } else { -1.0 });
        rate[axis] += if is_spoilt { (20.0 * sign * sigma) as f32 } else { 0.0 };
        is_spoilt
    };
    let zeros = |length: u32| {
        let mut left = 0;
        move |dice: &mut Dice, rate: &mut Vec3<f32>| {
            if left == 0 && dice.flat() < 0.1 / f64::from(length) {
                left = length;
            }
            let is_spoilt = left > 0;
            if is_spoilt {
                left -= 1;
                *rate = Vec3::zeros();
            }
            is_spoilt
        }
    };
    let results = [shares(&flight, outliers), shares(&flight, zeros(1)), shares(&flight, zeros(5))];
    for [caught, innocent, noise, bridge] in results {
        assert!(caught > 0.985 && innocent < 1e-3, "{results:?}");
        assert!((noise - 1.0).abs() < 0.05, "{results:?}");
        assert!(bridge < 10.0, "{results:?}");
    }
}

/// Quanta of a hundredth to ten sigmas: most readings repeat at the end of that.
#[test]
fn quantised_readings_are_accepted() {
    for flight in flights() {
        for quanta in [0.01, 0.1, 1.0, 3.0, 5.0, 10.0] {
            let quantum = quanta * flight.noise_rad_s;
            let round = move |_: &mut Dice, rate: &mut Vec3<f32>| {
                *rate = rate.map(|x| (libm::round(f64::from(x) / quantum) * quantum) as f32);
                false
            };
            let [_, refused, ..] = shares(&flight, round);
            assert!(refused < 5e-4, "{quanta} {refused}");
        }
    }
}

/// Noise ten times larger and smaller again; a jump that stays; a kink; a jump into exact rest.
#[test]
fn changes_of_the_motion_cost_few_samples() {
    let mut readings = Flight::rest(2000).readings(1);
    readings[500..1000].iter_mut().for_each(|rate| *rate *= 10.0);
    readings[1200..1500].iter_mut().for_each(|rate| rate.x += 1.0);
    readings[1500..].iter_mut().enumerate().for_each(|(k, rate)| rate.y += 0.1 * k as f32);
    let verdicts = judge(&mut Gate::new(), 0.1, &readings, 0.0);
    let refused = |range: core::ops::Range<usize>| verdicts[range].iter().filter(|a| !**a).count();
    assert!(refused(500..600) < 60, "{}", refused(500..600));
    assert!(refused(600..2000) < 5, "{}", refused(600..2000));
    readings[300..].fill(Vec3::zeros());
    readings[..300].iter_mut().for_each(|rate| rate.z += 0.5);
    let verdicts = judge(&mut Gate::new(), 0.1, &readings, 1e-3);
    assert!(verdicts[300..316].iter().all(|a| !a) && verdicts[316..].iter().all(|a| *a));
}

/// A jump of all axes to other noise: the run limit ends the refusals.
#[test]
fn a_run_of_refused_samples_is_bounded() {
    let mut readings = Flight::rest(400).readings(3);
    let mut dice = Dice(99);
    readings[200..].iter_mut().for_each(|rate| *rate = dice.vector(1.0).map(|x| x as f32));
    let verdicts = judge(&mut Gate::new(), 0.1, &readings, 1e-3);
    let longest = verdicts.split(|a| *a).map(<[bool]>::len).max().unwrap();
    assert!(longest <= usize::from(RUN_LIMIT), "{longest}");
    assert!(verdicts[230..].iter().filter(|a| !**a).count() < 10);
}

/// Holes of one, two, three and forty samples: all samples come out in order, those of short holes with a rate that is known.
#[test]
fn samples_without_a_reading_keep_their_place() {
    let flight = Flight::tumble(1600);
    let readings = flight.readings(0);
    let is_absent = |k: usize| {
        let of_hole = k % 400;
        let length = [1, 2, 3, 40][k / 400];
        (200..200 + length).contains(&of_hole)
    };
    let mut gate = OutlierGate::<f32, u32>::new();
    let mut judged = Vec::new();
    for (k, rate) in readings.iter().enumerate() {
        if is_absent(k) {
            gate.add_absent(0.1, k as u32);
        } else {
            gate.add(0.1, *rate, k as u32, 0.0);
        }
        judged.extend(gate.advance());
        judged.extend(std::iter::from_fn(|| gate.ready()));
    }
    judged.extend(std::iter::from_fn(|| gate.drain()));
    assert_eq!((judged.len(), gate.refused()), (1600, 0));
    for (k, sample) in judged.iter().enumerate() {
        assert_eq!((sample.payload, sample.is_absent), (k as u32, is_absent(k)));
        let is_known = !is_absent(k) || k < 800;
        assert_eq!((sample.is_accepted, sample.is_known), (!is_absent(k), is_known), "{k}");
        assert!(sample.rate_rad_s.iter().all(|x| x.is_finite()));
    }
}

/// Steps of 10 % jitter and of lost rows: the fourth difference takes true times.
#[test]
fn uneven_time_stamps_are_no_outliers() {
    let flight = Flight::tumble(60_000);
    let (mut gate, mut dice) = (OutlierGate::<f32, u32>::new(), Dice(7));
    let (mut last, mut accepted) = (0, 0);
    let readings = flight.readings(0);
    for (k, rate) in readings.iter().enumerate() {
        if k > 0 && (k - last < 4 || dice.flat() < 0.5) {
            continue;
        }
        let elapsed_s = (0.1 * (k - last) as f64 / 8.0) as f32;
        last = k;
        accepted += usize::from(gate.push(elapsed_s, *rate, 0, 0.0).is_some_and(|j| j.is_accepted));
    }
    assert!(gate.refused() < 5 && accepted > 10_000, "{} {accepted}", gate.refused());
}

/// White noise of one sigma, 300 and 3000 samples: bias and deviation.
#[test]
fn the_measured_noise_is_unbiased() {
    for (samples, deviation) in [(300, 0.045), (3000, 0.025)] {
        let flight = Flight::tumble(samples);
        let (mut sum, mut squares) = (0.0, 0.0);
        for seed in 0..200 {
            let mut gate = Gate::new();
            judge(&mut gate, flight.period_s, &flight.readings(seed), 0.0);
            let error = f64::from(gate.noise_rad_s()) / flight.noise_rad_s - 1.0;
            sum += error / 200.0;
            squares += error * error / 200.0;
        }
        assert!(sum.abs() < 0.02, "{samples} {sum}");
        assert!(squares < deviation * deviation, "{samples} {squares}");
    }
}

/// Constant readings, then noise, then constant again.
#[test]
fn repeated_readings_measure_no_noise_and_recover() {
    let mut readings = std::vec![Vec3::new(0.1f32, 0.2, 0.3); 300];
    let mut gate = Gate::new();
    judge(&mut gate, 0.1, &readings, 0.0);
    assert_eq!((gate.noise_rad_s(), gate.refused()), (0.0, 0));
    readings.extend(Flight::rest(2000).readings(0).iter().map(|r| r + Vec3::new(0.1, 0.2, 0.3)));
    let verdicts = judge(&mut gate, 0.1, &readings, 0.0);
    assert!(verdicts[340..].iter().all(|a| *a));
    assert!((gate.noise_rad_s() - 1e-3).abs() < 1e-4);
}

/// Samples leave in order, once, whether the caller asks for all that are ready or not.
#[test]
fn every_sample_leaves_once_and_in_order() {
    let flight = Flight::tumble(500);
    let (readings, _) = spoil(&flight, 0, |dice, rate| {
        let is_spoilt = dice.flat() < 0.3;
        *rate *= if is_spoilt { 0.0 } else { 1.0 };
        is_spoilt
    });
    for asks in [true, false] {
        let mut gate = OutlierGate::<f64, u32>::new();
        let mut order = Vec::new();
        for (k, rate) in readings.iter().enumerate() {
            order.extend(gate.push(0.1, rate.map(f64::from), k as u32, 1e-3));
            if asks {
                order.extend(std::iter::from_fn(|| gate.ready()));
            }
            if !asks {
                assert!(k + 1 - order.len() < PLACES);
            }
        }
        order.extend(std::iter::from_fn(|| gate.drain()));
        assert!(gate.drain().is_none());
        if asks {
            assert!(order.iter().enumerate().all(|(k, judged)| judged.payload == k as u32));
            assert_eq!(order.len(), readings.len());
        }
    }
}

/// After a gap nothing is predicted across it; the scales stay.
#[test]
fn a_restart_keeps_the_scales() {
    let readings = Flight::rest(100).readings(0);
    let mut gate = Gate::new();
    judge(&mut gate, 0.1, &readings, 0.0);
    gate.restart();
    let moved: Vec<_> = readings.iter().map(|rate| rate + Vec3::repeat(1.0)).collect();
    assert_eq!(judge(&mut gate, 0.1, &moved, 0.0), std::vec![true; 100]);
    assert!(size_of::<Gate>() <= 700, "{}", size_of::<Gate>());
}

/// Words of a corrupted memory.
struct Random<'a>(&'a mut Dice, u32);

impl Words for Random<'_> {
    fn transfer(&mut self, word: &mut u32) -> bool {
        // One word in some is spoilt, by one bit or wholly.
        let (pick, bits) = (self.0.flat(), (self.0.flat() * 4_294_967_296.0) as u32);
        if pick * f64::from(self.1) < 1.0 {
            *word = if bits & 1 == 0 { bits } else { *word ^ 1 << (bits >> 27) };
        }
        true
    }
}

proptest! {
    /// Any bits in the state and in the samples: no panic, no loop without end, every call bounded.
    #[test]
    fn random_bits_never_panic(
        seed in 1u64..u64::MAX,
        share in 1u32..40,
        words in prop::collection::vec(prop::array::uniform6(any::<u32>()), 40),
    ) {
        let mut dice = Dice(seed);
        let mut gate = Gate::new();
        let readings = Flight::rest(30).readings(seed);
        for rate in &readings {
            gate.push(0.1, *rate, Blank::blank(), 0.0);
        }
        let mut medium = Random(&mut dice, share);
        let mut archive = Archive::new(&mut medium);
        Persist::persist(&mut gate, &mut archive); // rejected or not: the state is partly overwritten
        let _ = archive.finish();
        for word in words {
            let [t, x, y, z, floor, _] = word.map(f32::from_bits);
            gate.push(t, Vec3::new(x, y, z), Blank::blank(), floor);
            for _ in 0..3 {
                gate.ready();
            }
        }
        for _ in 0..PLACES {
            gate.drain();
        }
        prop_assert!(gate.drain().is_none());
    }

    /// 300 samples after any samples within the range of the gyro the gate works again.
    #[test]
    fn the_gate_recovers_from_any_samples(
        words in prop::collection::vec(prop::array::uniform4(-100.0..100.0f32), 1..30),
    ) {
        let mut gate = Gate::new();
        for [t, x, y, z] in words {
            gate.push(t.abs() * 1e-2, Vec3::new(x, y, z), Blank::blank(), 0.0);
        }
        while gate.drain().is_some() {}
        let mut readings = Flight::rest(400).readings(1);
        readings[350].x += 1.0;
        let verdicts = judge(&mut gate, 0.1, &readings, 1e-3);
        prop_assert!(verdicts[300..].iter().enumerate().all(|(k, a)| *a == (k != 50)));
    }
}

/// A queue of readings whose payload is their number.
fn queued(readings: impl IntoIterator<Item = Option<f32>>) -> Queue<f32, u32> {
    let mut queue = Queue::empty();
    for (payload, x) in readings.into_iter().enumerate() {
        queue.add(0.1, x.map(Vec3::repeat), payload as u32);
    }
    queue
}

#[test]
fn a_full_queue_takes_no_sample_and_an_empty_one_no_verdict() {
    let mut queue = queued((0..9).map(|x| Some(x as f32)));
    let before = queue;
    queue.add(0.1, None, 9);
    assert_eq!(queue, before);
    let mut queue = queued([Some(1.0)]);
    queue.judge(true);
    let before = queue;
    queue.judge(true);
    assert_eq!(queue, before);
}

/// A refused sample without accepted neighbours that has to be taken: the next reading stands for it, if there is one.
#[test]
fn a_refused_sample_alone_has_the_rate_of_the_next_one() {
    for (next, rate) in [(Some(2.0), 2.0), (None, 1.0)] {
        let mut queue = queued([Some(1.0), next]);
        queue.judge(false);
        let taken = queue.take(true).unwrap();
        assert_eq!((taken.rate_rad_s.x, taken.is_accepted, taken.is_known), (rate, false, false));
    }
}

/// After a gap nothing of the time before it is returned, or predicts.
#[test]
fn a_restart_leaves_no_sample() {
    let mut gate = OutlierGate::<f32, u32>::new();
    let mut dice = Dice(1);
    let mut push = |gate: &mut OutlierGate<f32, u32>, about: f64, payload| {
        gate.push(0.1, (Vec3::repeat(about) + dice.vector(1e-3)).cast(), payload, 1e-3)
    };
    for k in 0..50 {
        push(&mut gate, 0.0, k);
    }
    assert!(gate.pending().count() > 0);
    gate.restart();
    assert_eq!((gate.pending().count(), gate.refused()), (0, 0));
    // At another rate: none of these is compared with those before.
    let mut returned = Vec::new();
    for k in 50..100 {
        returned.extend(push(&mut gate, 1.0, k));
        returned.extend(core::iter::from_fn(|| gate.ready()));
        assert_eq!(returned.last().map(|last| last.payload + 2), (k >= 52).then_some(k));
    }
    assert_eq!((returned[0].payload, gate.refused()), (50, 0));
    assert!(returned.iter().all(|judged| judged.is_accepted));
}

/// Squares that overflow leave the mean as before the first one: later readings measure the noise.
#[test]
fn the_measured_noise_recovers_from_an_overflow() {
    let mut noise = Noise::<f32>::unknown();
    let infinite = Vec3::repeat(f32::INFINITY);
    // Without seven in a row there are no sixth differences.
    for _ in 0..4 {
        noise.interrupt();
        (0..5).for_each(|_| noise.add(&Vec3::zeros(), Some(infinite), &infinite));
        assert_eq!(noise.sigma_rad_s(), 0.0);
    }
    let mut dice = Dice(1);
    for _ in 0..4000 {
        // Errors of the cubic of one sigma, known at the reading.
        let error = dice.vector(1.0).cast::<f32>();
        noise.add(&dice.vector(1.0).cast(), Some(error.component_mul(&error)), &Vec3::repeat(1.0));
    }
    assert!((noise.sigma_rad_s() - 1.0).abs() < 0.15, "{}", noise.sigma_rad_s());
}

/// Accepted samples are returned with the second one after them, once the first eight have given the scales.
#[test]
fn an_accepted_sample_is_two_samples_late() {
    let (mut gate, mut dice) = (OutlierGate::<f32, u32>::new(), Dice(1));
    for k in 0..200 {
        let mut last = gate.push(0.1, dice.vector(1e-3).cast(), k, 1e-3);
        assert_eq!(last.is_some(), k >= START as u32 - 1, "{k}");
        while let Some(ready) = gate.ready() {
            last = Some(ready);
        }
        assert!(last.is_none_or(|last| k < 20 || last.payload + 2 == k), "{k}");
    }
}

/// Of the cubic's errors and the sixth differences the smaller ones count: 2 and 1 sigma, either way.
#[test]
fn the_smaller_measure_of_the_noise_counts() {
    for (of_reading, of_cubic) in [(1.0, 2.0), (2.0, 1.0)] {
        let (mut noise, mut dice) = (Noise::<f32>::unknown(), Dice(1));
        for _ in 0..2000 {
            let error = dice.vector(of_cubic).cast::<f32>();
            let squared = error.component_mul(&error);
            noise.add(&dice.vector(of_reading).cast(), Some(squared), &Vec3::repeat(100.0));
        }
        assert!((noise.sigma_rad_s() - 1.0).abs() < 0.1, "{}", noise.sigma_rad_s());
    }
}
