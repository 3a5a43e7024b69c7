//! Motion and sensitivities under commanded wheel momentum, by Runge-Kutta steps of fixed length, and the
//! exact gradient of any function of them by the adjoint of each step.
//!
//! With the axial momentum `hᵢ` of each wheel, commanded as a function of time, and the total momentum
//! `p` in body axes (see [`spacecraft`](crate::truth::spacecraft) for the other symbols):
//!
//! ```text
//! ω = J_b⁻¹ (p − Σ hᵢ aᵢ),   ṗ = −ω × p + τ,   q̇ = ½ q ⊗ (0, ω)
//! Y = ∂(J ω + h_w)/∂θ,       Ẏ = p × S − ω × Y + E_τ,   S = ∂ω/∂θ = J⁻¹ (Y − N)
//! ```
//!
//! `N` is the part of `Y` that another inertia or wheel contributes at the same rate and wheel speed:
//! the column of `G(ω)` of an element, `Iₛ Ω a` of a spin inertia, `Iₛ Ω e` of a tilt along `e`. Since
//! `J S = Y − N`, this is the variational equation of [`bound`](crate::truth::bound), with no derivative of
//! the wheel speed.
//!
//! `τ = Σ cⱼ dⱼ` is the known torque of the pairs of thrusters with the levels `cⱼ`, and the column of its scale has
//! `E_τ = τ`.
//!
//! Assumptions: no other external torque, constant inertia, rigid body.
//!
//! The adjoint: for a step `y₁ = Φ(y₀, h)` and a function `f(y₁)`, `∂f/∂y₀ = (∂Φ/∂y₀)ᵀ ∂f/∂y₁`, applied
//! from the last step to the first. The cost is about four times that of the motion, for any number of
//! parameters.

use nalgebra::{Matrix3, Vector3};

use super::columns::{Columns, Kind};
use super::command::Command;
use super::problem::{DesignWheel, Pair};
use crate::input::craft::hardware::tilt_directions;
use crate::truth::bound::hardware::Error;

/// Elements of the state before the columns: momentum 3, quaternion 4 (scalar first).
const MOTION: usize = 7;
const P: usize = 0;
const Q: usize = 3;

/// Contribution `N` of a column.
enum Contribution {
    /// None: rate and torque.
    None,
    /// `G(ω)` of an element, times the unit of the inertia.
    Inertia(usize),
    /// `Σ Iₛ Ω d` over wheels and their directions.
    Wheels(Vec<(usize, Vector3<f64>)>),
}

/// A spacecraft of one inertia, and the columns of its information.
pub(super) struct Model<'a> {
    wheels: &'a [DesignWheel],
    pairs: &'a [Pair],
    columns: &'a Columns,
    contributions: Vec<Contribution>,
    inertia: Matrix3<f64>,
    inverse: Matrix3<f64>,
    body: Matrix3<f64>,
    body_inverse: Matrix3<f64>,
    unit_kg_m2: f64,
}

/// Rate, attitude, acceleration and sensitivities at one instant.
pub(super) struct Output {
    pub rate: Vector3<f64>,
    pub attitude: [f64; 4],
    pub acceleration: Vector3<f64>,
    /// `∂ω/∂θ` of the columns with a differential equation.
    pub sensitivities: Vec<Vector3<f64>>,
}

/// Derivatives of a function by the quantities of one instant.
#[derive(Clone)]
pub(super) struct Seed {
    pub rate: Vector3<f64>,
    pub attitude: [f64; 4],
    pub acceleration: Vector3<f64>,
    pub sensitivities: Vec<Vector3<f64>>,
    /// By the momentum of each wheel and the level of each pair.
    pub momentum: Vec<f64>,
    /// By the torque of each wheel and the level of each pair.
    pub torque: Vec<f64>,
}

impl Seed {
    pub(super) fn zero(channels: usize, dynamic: usize) -> Self {
        Self {
            rate: Vector3::zeros(),
            attitude: [0.0; 4],
            acceleration: Vector3::zeros(),
            sensitivities: vec![Vector3::zeros(); dynamic],
            momentum: vec![0.0; channels],
            torque: vec![0.0; channels],
        }
    }
}

fn vector(state: &[f64], at: usize) -> Vector3<f64> {
    Vector3::new(state[at], state[at + 1], state[at + 2])
}

fn add(target: &mut [f64], at: usize, value: &Vector3<f64>) {
    for i in 0..3 {
        target[at + i] += value[i];
    }
}

/// `G(ω)` of an element: symmetric in the sense that its transpose applied to a vector is the same map.
fn regressor(element: usize, w: &Vector3<f64>) -> Vector3<f64> {
    match element {
        0 => Vector3::new(w.x, 0.0, 0.0),
        1 => Vector3::new(0.0, w.y, 0.0),
        2 => Vector3::new(0.0, 0.0, w.z),
        3 => Vector3::new(w.y, w.x, 0.0),
        4 => Vector3::new(w.z, 0.0, w.x),
        _ => Vector3::new(0.0, w.z, w.y),
    }
}

impl<'a> Model<'a> {
    /// The spacecraft with this inertia, kg m²; none if the inertia without its wheels has no inverse.
    pub(super) fn new(
        (wheels, pairs): (&'a [DesignWheel], &'a [Pair]),
        columns: &'a Columns,
        inertia: Matrix3<f64>,
        unit_kg_m2: f64,
    ) -> Option<Self> {
        let body = wheels.iter().fold(inertia, |j, wheel| {
            j - wheel.axis * wheel.axis.transpose() * wheel.spin_inertia_kg_m2
        });
        let contributions = columns.all[..columns.dynamic]
            .iter()
            .map(|column| contribution(column.kind, wheels))
            .collect();
        Some(Self {
            wheels,
            pairs,
            columns,
            contributions,
            inertia,
            inverse: inertia.try_inverse()?,
            body,
            body_inverse: body.try_inverse()?,
            unit_kg_m2,
        })
    }

    /// Torque of the pairs, of the channels after the wheels, N m.
    fn known_torque(&self, channels: &[f64]) -> Vector3<f64> {
        let pairs = self.pairs.iter().zip(&channels[self.wheels.len()..]);
        pairs.map(|(pair, level)| pair.torque_n_m * *level).sum()
    }

    /// Adjoint of [`Self::known_torque`].
    fn pull_known_torque(&self, seed: &Vector3<f64>, channels: &mut [f64]) {
        for (pair, level) in self.pairs.iter().zip(&mut channels[self.wheels.len()..]) {
            *level += pair.torque_n_m.dot(seed);
        }
    }

    fn dimension(&self) -> usize {
        MOTION + 3 * self.columns.dynamic
    }

    fn rate(&self, p: &Vector3<f64>, h: &[f64]) -> Vector3<f64> {
        let wheels = self.wheels.iter().zip(h);
        self.body_inverse * wheels.fold(*p, |sum, (wheel, h)| sum - wheel.axis * *h)
    }

    /// `Iₛ Ω` of a wheel, N m s.
    fn relative(&self, wheel: usize, w: &Vector3<f64>, h: &[f64]) -> f64 {
        let DesignWheel { axis, spin_inertia_kg_m2, .. } = &self.wheels[wheel];
        h[wheel] - spin_inertia_kg_m2 * axis.dot(w)
    }

    /// `N` of a column.
    fn contribution(&self, column: usize, w: &Vector3<f64>, h: &[f64]) -> Vector3<f64> {
        match &self.contributions[column] {
            Contribution::None => Vector3::zeros(),
            Contribution::Inertia(element) => regressor(*element, w) * self.unit_kg_m2,
            Contribution::Wheels(wheels) => wheels
                .iter()
                .map(|(wheel, direction)| direction * self.relative(*wheel, w, h))
                .sum(),
        }
    }

    /// Adjoint of [`Self::contribution`].
    fn pull_contribution(
        &self,
        column: usize,
        seed: &Vector3<f64>,
        rate: &mut Vector3<f64>,
        momentum: &mut [f64],
    ) {
        match &self.contributions[column] {
            Contribution::None => {}
            Contribution::Inertia(element) => *rate += regressor(*element, seed) * self.unit_kg_m2,
            Contribution::Wheels(wheels) => {
                for (wheel, direction) in wheels {
                    let along = direction.dot(seed);
                    let DesignWheel { axis, spin_inertia_kg_m2, .. } = &self.wheels[*wheel];
                    momentum[*wheel] += along;
                    *rate -= axis * (spin_inertia_kg_m2 * along);
                }
            }
        }
    }

    /// State at the start: this rate and attitude, wheels with this axial momentum.
    pub(super) fn start(&self, rate: &Vector3<f64>, attitude: [f64; 4], h: &[f64]) -> Vec<f64> {
        let mut state = vec![0.0; self.dimension()];
        let wheels = self.wheels.iter().zip(h);
        let p = wheels.fold(self.body * rate, |sum, (wheel, h)| sum + wheel.axis * *h);
        add(&mut state, P, &p);
        state[Q..Q + 4].copy_from_slice(&attitude);
        for (index, column) in self.columns.all[..self.columns.dynamic].iter().enumerate() {
            let y = match column.kind {
                Kind::Rate(axis) => self.inertia.column(axis).into_owned(),
                _ => self.contribution(index, rate, h),
            };
            add(&mut state, MOTION + 3 * index, &y);
        }
        state
    }

    /// Derivative of the state under wheel momentum `h`.
    fn slope(&self, state: &[f64], h: &[f64], slope: &mut [f64]) {
        let p = vector(state, P);
        let w = self.rate(&p, h);
        let known = self.known_torque(h);
        slope[P..P + 3].copy_from_slice((p.cross(&w) + known).as_slice());
        let [s, x, y, z] = [state[Q], state[Q + 1], state[Q + 2], state[Q + 3]];
        slope[Q] = -0.5 * (x * w.x + y * w.y + z * w.z);
        slope[Q + 1] = 0.5 * (s * w.x + y * w.z - z * w.y);
        slope[Q + 2] = 0.5 * (s * w.y + z * w.x - x * w.z);
        slope[Q + 3] = 0.5 * (s * w.z + x * w.y - y * w.x);
        for column in 0..self.columns.dynamic {
            let at = MOTION + 3 * column;
            let y = vector(state, at);
            let s = self.inverse * (y - self.contribution(column, &w, h));
            let mut change = p.cross(&s) - w.cross(&y);
            match self.columns.all[column].kind {
                Kind::Torque(axis) => change[axis] += self.unit_kg_m2,
                Kind::Hardware(Error::TorqueScale) => change += known,
                _ => {}
            }
            slope[at..at + 3].copy_from_slice(change.as_slice());
        }
    }

    /// Adjoint of [`Self::slope`]: adds the derivatives by state and momentum for derivatives `seed` by the
    /// slope.
    fn pull_slope(
        &self,
        state: &[f64],
        h: &[f64],
        seed: &[f64],
        pulled: &mut [f64],
        momentum: &mut [f64],
    ) {
        let p = vector(state, P);
        let w = self.rate(&p, h);
        let mut by_p = w.cross(&vector(seed, P));
        let mut by_w = vector(seed, P).cross(&p);
        self.pull_known_torque(&vector(seed, P), momentum);
        for column in 0..self.columns.dynamic {
            let at = MOTION + 3 * column;
            let (y, y_seed) = (vector(state, at), vector(seed, at));
            if self.columns.all[column].kind == Kind::Hardware(Error::TorqueScale) {
                self.pull_known_torque(&y_seed, momentum);
            }
            let s = self.inverse * (y - self.contribution(column, &w, h));
            by_p += s.cross(&y_seed);
            by_w += y_seed.cross(&y);
            let through = self.inverse * y_seed.cross(&p);
            add(pulled, at, &(through + w.cross(&y_seed)));
            self.pull_contribution(column, &-through, &mut by_w, momentum);
        }
        pull_quaternion(state, &w, seed, pulled, &mut by_w);
        self.pull_rate(&by_w, &mut by_p, momentum);
        add(pulled, P, &by_p);
    }

    /// Adjoint of [`Self::rate`].
    fn pull_rate(&self, by_w: &Vector3<f64>, by_p: &mut Vector3<f64>, momentum: &mut [f64]) {
        let through = self.body_inverse * by_w;
        *by_p += through;
        for (wheel, momentum) in self.wheels.iter().zip(momentum) {
            *momentum -= wheel.axis.dot(&through);
        }
    }

    /// Quantities at an instant of these momenta and torques of the wheels, and levels of the pairs.
    pub(super) fn output(&self, state: &[f64], h: &[f64], u: &[f64]) -> Output {
        let p = vector(state, P);
        let w = self.rate(&p, h);
        let wheels = self.wheels.iter().zip(u);
        let external = p.cross(&w) + self.known_torque(u);
        let torque = wheels.fold(external, |sum, (wheel, u)| sum - wheel.axis * *u);
        let sensitivity = |column: usize| {
            let y = vector(state, MOTION + 3 * column);
            self.inverse * (y - self.contribution(column, &w, h))
        };
        Output {
            rate: w,
            attitude: [state[Q], state[Q + 1], state[Q + 2], state[Q + 3]],
            acceleration: self.body_inverse * torque,
            sensitivities: (0..self.columns.dynamic).map(sensitivity).collect(),
        }
    }

    /// Adjoint of [`Self::output`].
    fn pull_output(
        &self,
        state: &[f64],
        h: &[f64],
        seed: &Seed,
        pulled: &mut [f64],
        by_h: &mut [f64],
        by_u: &mut [f64],
    ) {
        let p = vector(state, P);
        let w = self.rate(&p, h);
        let (mut by_w, mut by_p) = (seed.rate, Vector3::zeros());
        let by_torque = self.body_inverse * seed.acceleration;
        by_w += by_torque.cross(&p);
        by_p += w.cross(&by_torque);
        for (i, wheel) in self.wheels.iter().enumerate() {
            by_u[i] += seed.torque[i] - wheel.axis.dot(&by_torque);
            by_h[i] += seed.momentum[i];
        }
        for i in self.wheels.len()..seed.torque.len() {
            by_u[i] += seed.torque[i];
            by_h[i] += seed.momentum[i];
        }
        self.pull_known_torque(&by_torque, by_u);
        for (column, by_s) in seed.sensitivities.iter().enumerate() {
            let through = self.inverse * by_s;
            add(pulled, MOTION + 3 * column, &through);
            self.pull_contribution(column, &-through, &mut by_w, by_h);
        }
        for i in 0..4 {
            pulled[Q + i] += seed.attitude[i];
        }
        self.pull_rate(&by_w, &mut by_p, by_h);
        add(pulled, P, &by_p);
    }

    /// States at the instants of a command, the first `start`.
    pub(super) fn fly(&self, command: &Command, start: Vec<f64>) -> Vec<Vec<f64>> {
        let mut states = Vec::with_capacity(command.steps + 1);
        states.push(start);
        let mut stages = Stages::new(self.dimension());
        for step in 0..command.steps {
            stages.run(self, command, step, &states[step]);
            let next = stages.end(&states[step], command.step_s);
            states.push(next);
        }
        states
    }

    /// Adds the derivatives by momentum, on the half steps, and by torque, on the steps, of a function
    /// whose derivatives by the quantities of each instant are `seeds`.
    pub(super) fn pull(
        &self,
        command: &Command,
        states: &[Vec<f64>],
        seeds: &[Seed],
        by_momentum: &mut [f64],
        by_torque: &mut [f64],
    ) {
        let (channels, dimension) = (command.channels(), self.dimension());
        let mut adjoint = vec![0.0; dimension];
        let mut stages = Stages::new(dimension);
        for instant in (0..=command.steps).rev() {
            if instant < command.steps {
                stages.run(self, command, instant, &states[instant]);
                adjoint =
                    stages.pull(self, command, instant, &states[instant], adjoint, by_momentum);
            }
            self.pull_output(
                &states[instant],
                command.momentum(2 * instant),
                &seeds[instant],
                &mut adjoint,
                &mut by_momentum[2 * instant * channels..][..channels],
                &mut by_torque[instant * channels..][..channels],
            );
        }
    }
}

fn contribution(kind: Kind, wheels: &[DesignWheel]) -> Contribution {
    match kind {
        Kind::Inertia(element) => Contribution::Inertia(element),
        Kind::Hardware(Error::WheelInertia(wheel)) => {
            Contribution::Wheels(vec![(wheel, wheels[wheel].axis)])
        }
        Kind::Hardware(Error::WheelAxis(wheel, direction)) => {
            Contribution::Wheels(vec![(wheel, tilt_directions(&wheels[wheel].axis)[direction])])
        }
        Kind::Hardware(Error::CommonWheelInertia) => {
            Contribution::Wheels(wheels.iter().map(|wheel| wheel.axis).enumerate().collect())
        }
        _ => Contribution::None,
    }
}

/// Adjoint of the kinematics `q̇ = ½ q ⊗ (0, ω)`.
fn pull_quaternion(
    state: &[f64],
    w: &Vector3<f64>,
    seed: &[f64],
    pulled: &mut [f64],
    by_w: &mut Vector3<f64>,
) {
    let [s, x, y, z] = [state[Q], state[Q + 1], state[Q + 2], state[Q + 3]];
    let [a, b, c, d] = [seed[Q], seed[Q + 1], seed[Q + 2], seed[Q + 3]].map(|seed| 0.5 * seed);
    pulled[Q] += b * w.x + c * w.y + d * w.z;
    pulled[Q + 1] += -a * w.x - c * w.z + d * w.y;
    pulled[Q + 2] += -a * w.y + b * w.z - d * w.x;
    pulled[Q + 3] += -a * w.z - b * w.y + c * w.x;
    *by_w += Vector3::new(
        -a * x + b * s + c * z - d * y,
        -a * y - b * z + c * s + d * x,
        -a * z + b * y - c * x + d * s,
    );
}

/// Slopes and states of the four stages of a step (classical Runge-Kutta method of order 4).
struct Stages {
    states: [Vec<f64>; 4],
    slopes: [Vec<f64>; 4],
}

/// Share of the step from its start to each stage, and weight of each slope.
const REACH: [f64; 4] = [0.0, 0.5, 0.5, 1.0];
const WEIGHTS: [f64; 4] = [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0];

/// Half step of each stage, counted from the start of the command.
fn half_step(step: usize, stage: usize) -> usize {
    2 * step + [0, 1, 1, 2][stage]
}

impl Stages {
    fn new(dimension: usize) -> Self {
        let four = || std::array::from_fn(|_| vec![0.0; dimension]);
        Self { states: four(), slopes: four() }
    }

    fn run(&mut self, model: &Model<'_>, command: &Command, step: usize, start: &[f64]) {
        for stage in 0..4 {
            for i in 0..start.len() {
                let slope = if stage == 0 { 0.0 } else { self.slopes[stage - 1][i] };
                self.states[stage][i] = start[i] + REACH[stage] * command.step_s * slope;
            }
            let h = command.momentum(half_step(step, stage));
            model.slope(&self.states[stage], h, &mut self.slopes[stage]);
        }
    }

    fn end(&self, start: &[f64], step_s: f64) -> Vec<f64> {
        let of = |i: usize| {
            let slopes = self.slopes.iter().zip(WEIGHTS);
            start[i] + step_s * slopes.map(|(slope, weight)| weight * slope[i]).sum::<f64>()
        };
        (0..start.len()).map(of).collect()
    }

    /// Derivatives by the start of the step from those by its end.
    fn pull(
        &self,
        model: &Model<'_>,
        command: &Command,
        step: usize,
        start: &[f64],
        by_end: Vec<f64>,
        by_momentum: &mut [f64],
    ) -> Vec<f64> {
        let channels = command.channels();
        let mut by_start = by_end.clone();
        let mut later = vec![0.0; start.len()];
        for stage in (0..4).rev() {
            let reach = if stage == 3 { 0.0 } else { REACH[stage + 1] };
            let seed: Vec<f64> = (by_end.iter().zip(&later))
                .map(|(end, later)| command.step_s * (WEIGHTS[stage] * end + reach * later))
                .collect();
            let half = half_step(step, stage);
            later.fill(0.0);
            model.pull_slope(
                &self.states[stage],
                command.momentum(half),
                &seed,
                &mut later,
                &mut by_momentum[half * channels..][..channels],
            );
            by_start.iter_mut().zip(&later).for_each(|(sum, part)| *sum += part);
        }
        by_start
    }
}
