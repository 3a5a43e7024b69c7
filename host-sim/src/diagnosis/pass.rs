//! One pass of the fit: motion and sensitivities along the record, residuals, normal equations.
//!
//! The record is cut into segments with an initial momentum each, which is eliminated from the normal equations. Short
//! segments make the fit nearly linear from any start; one segment uses all that the motion shows.

use nalgebra::{DMatrix, DVector, Matrix3, Matrix3x6, Matrix3xX, Vector3, Vector6};

use super::model::{Column, Drive};
use super::record::Record;

/// Largest rate of a motion that is still followed, rad/s.
const FASTEST_RAD_S: f64 = 1e3;
/// Unknowns of a segment alone: its initial momentum.
const LOCAL: usize = 3;
/// Unknowns common to all segments, in front of the further ones: the inertia.
pub(super) const INERTIA_UNKNOWNS: usize = 6;
const INERTIA: usize = INERTIA_UNKNOWNS;

/// First rows of the segments, and the end of the last.
#[derive(Clone, Debug)]
pub(super) struct Segments {
    pub starts: Vec<usize>,
    pub end: usize,
}

/// Values of the unknowns, over the scale.
#[derive(Clone, Debug)]
pub(super) struct Point {
    /// Elements of the inertia.
    pub inertia: Vector6<f64>,
    /// Further unknowns.
    pub further: Vec<f64>,
    /// Momentum at the start of each segment.
    pub momentum: Vec<Vector3<f64>>,
}

/// Normal equations of a pass, of inertia and further unknowns.
pub(super) struct Equations {
    pub chi_square: f64,
    pub normal: DMatrix<f64>,
    pub gradient: DVector<f64>,
    /// Of each segment: `A_hh⁻¹ g_h` and `A_hh⁻¹ A_hc`.
    local: Vec<(Vector3<f64>, Matrix3xX<f64>)>,
    /// Sum of squares over rows that are not in use, in sigmas.
    pub unused_squares: f64,
    /// Predicted body rate of each row, and measured less predicted reading, zero for a row that is not in use, rad/s.
    pub rows: Vec<[Vector3<f64>; 2]>,
}

impl Equations {
    /// Shift of the initial momentum of a segment for this step of the common unknowns.
    pub(super) fn momentum_step(&self, segment: usize, step: &DVector<f64>) -> Vector3<f64> {
        let (alone, by_common) = &self.local[segment];
        alone - by_common * step
    }
}

/// Tensor of six elements.
pub(super) fn tensor(j: &Vector6<f64>) -> Matrix3<f64> {
    Matrix3::new(j[0], j[3], j[4], j[3], j[1], j[5], j[4], j[5], j[2])
}

/// `G(ω)`: the matrix of `J ω` by the elements of `J`.
pub(super) fn of_elements(w: &Vector3<f64>) -> Matrix3x6<f64> {
    Matrix3x6::new(
        w.x, 0.0, 0.0, w.y, w.z, 0.0, //
        0.0, w.y, 0.0, w.x, 0.0, w.z, //
        0.0, 0.0, w.z, 0.0, w.x, w.y,
    )
}

/// `m v`, in the caller: nalgebra's product of this size is a call.
#[inline(always)]
fn product(m: &Matrix3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(
        m.m11 * v.x + m.m12 * v.y + m.m13 * v.z,
        m.m21 * v.x + m.m22 * v.y + m.m23 * v.z,
        m.m31 * v.x + m.m32 * v.y + m.m33 * v.z,
    )
}

/// Motion and sensitivities of one segment.
pub(super) struct Trajectory<'a> {
    record: &'a Record,
    drive: &'a Drive,
    inverse: Matrix3<f64>,
    momentum: Vector3<f64>,
    /// `∂H` by local, inertia and further unknowns.
    sensitivity: Vec<Vector3<f64>>,
}

impl<'a> Trajectory<'a> {
    /// Motion from this momentum, with the sensitivities to it.
    pub(super) fn new(
        record: &'a Record,
        drive: &'a Drive,
        inverse: Matrix3<f64>,
        momentum: Vector3<f64>,
    ) -> Self {
        let mut sensitivity = vec![Vector3::zeros(); LOCAL + INERTIA + drive.columns.len()];
        for i in 0..LOCAL {
            sensitivity[i][i] = 1.0;
        }
        Self { record, drive, inverse, momentum, sensitivity }
    }

    pub(super) fn momentum(&self) -> Vector3<f64> {
        self.momentum
    }

    /// Derivative of the momentum by the one at the start.
    pub(super) fn transition(&self) -> Matrix3<f64> {
        Matrix3::from_columns(&self.sensitivity[..LOCAL])
    }

    fn rate(&self, row: usize) -> Vector3<f64> {
        product(&self.inverse, &(self.momentum - self.drive.momentum.at[row]))
    }

    /// Moves to the next row: momentum by the classical Runge-Kutta rule, sensitivities by the transition matrix at
    /// midway, `Φ = 1 + A Δt + (A Δt)²/2` with `A = [H]× J⁻¹ − [ω]×`.
    pub(super) fn advance(&mut self, row: usize) {
        let (time, drive) = (&self.record.time_s, self.drive);
        let step_s = time[row + 1] - time[row];
        let (h, torque) = (&drive.momentum, &drive.torque);
        let middle_torque = (torque[row] + torque[row + 1]) * 0.5;
        let slope = |momentum: &Vector3<f64>, wheels: &Vector3<f64>, torque: &Vector3<f64>| {
            torque - product(&self.inverse, &(momentum - wheels)).cross(momentum)
        };
        let now = self.momentum;
        let half_s = 0.5 * step_s;
        let k1 = slope(&now, &h.at[row], &torque[row]);
        let k2 = slope(&(now + k1 * half_s), &h.middle[row], &middle_torque);
        let k3 = slope(&(now + k2 * half_s), &h.middle[row], &middle_torque);
        let k4 = slope(&(now + k3 * step_s), &h.at[row + 1], &torque[row + 1]);
        let middle = now + k2 * half_s;
        self.momentum = now + (k1 + (k2 + k3) * 2.0 + k4) * (step_s / 6.0);
        self.advance_sensitivity(row, step_s, &middle);
    }

    fn advance_sensitivity(&mut self, row: usize, step_s: f64, middle: &Vector3<f64>) {
        let drive = self.drive;
        let rate = self.inverse * (middle - drive.momentum.middle[row]);
        let by_rate = middle.cross_matrix() * self.inverse;
        let a = (by_rate - rate.cross_matrix()) * step_s;
        let transition = Matrix3::identity() + a + a * a * 0.5;
        let input = (Matrix3::identity() + a * 0.5) * step_s;
        let by_momentum = -(input * by_rate);
        self.sensitivity.iter_mut().for_each(|column| *column = product(&transition, column));
        let direct = of_elements(&rate);
        for i in 0..INERTIA {
            self.sensitivity[LOCAL + i] += product(&by_momentum, &direct.column(i).into_owned());
        }
        for (i, column) in drive.columns.iter().enumerate() {
            let sensitivity = &mut self.sensitivity[LOCAL + INERTIA + i];
            match column {
                Column::Driven(signal, torque) => {
                    *sensitivity += product(&by_momentum, &signal.middle[row]);
                    if let Some(torque) = torque {
                        *sensitivity += product(&input, &(torque[row] + torque[row + 1])) * 0.5;
                    }
                }
                Column::Torque(torque) => {
                    *sensitivity += product(&input, &(torque[row] + torque[row + 1])) * 0.5;
                }
                Column::Reading(..) | Column::Bias(_) => {}
            }
        }
    }

    /// Derivatives of the reading at a row, by all unknowns.
    fn reading_by(&self, row: usize, rate: &Vector3<f64>, out: &mut [Vector3<f64>]) {
        let drive = self.drive;
        let to_reading = drive.reading * self.inverse;
        let direct = of_elements(rate);
        for (k, out) in out.iter_mut().enumerate() {
            let mut of_momentum = self.sensitivity[k];
            if (LOCAL..LOCAL + INERTIA).contains(&k) {
                of_momentum -= direct.column(k - LOCAL);
            }
            let column = k.checked_sub(LOCAL + INERTIA).map(|i| &drive.columns[i]);
            if let Some(Column::Driven(signal, _)) = column {
                of_momentum -= signal.at[row];
            }
            *out = product(&to_reading, &of_momentum);
            match column {
                Some(Column::Reading(i, about)) => out[*i] += rate[*about],
                Some(Column::Bias(i)) => out[*i] += 1.0,
                _ => {}
            }
        }
    }
}

/// Sums of one segment: normal matrix, lower triangle by rows, and gradient.
struct Sums {
    normal: Vec<f64>,
    gradient: Vec<f64>,
    chi_square: f64,
    unused: f64,
}

impl Sums {
    fn add(&mut self, by: &[Vector3<f64>], residual: &Vector3<f64>, weight: f64) {
        self.chi_square += weight * residual.norm_squared();
        let size = by.len();
        for i in 0..size {
            let of_row = by[i] * weight;
            self.gradient[i] += of_row.dot(residual);
            for k in 0..=i {
                self.normal[i * size + k] += of_row.dot(&by[k]);
            }
        }
    }
}

/// The pass at a point; none where the motion runs away.
pub(super) fn pass(
    record: &Record,
    drive: &Drive,
    segments: &Segments,
    point: &Point,
) -> Option<Equations> {
    let inverse = tensor(&point.inertia).try_inverse()?;
    let common = INERTIA + drive.columns.len();
    let mut equations = Equations {
        chi_square: 0.0,
        normal: DMatrix::zeros(common, common),
        gradient: DVector::zeros(common),
        local: Vec::with_capacity(segments.starts.len()),
        unused_squares: 0.0,
        rows: Vec::with_capacity(record.len()),
    };
    for (segment, start) in segments.starts.iter().enumerate() {
        let end = segments.starts.get(segment + 1).copied().unwrap_or(segments.end);
        let mut trajectory = Trajectory::new(record, drive, inverse, point.momentum[segment]);
        let sums = segment_sums(&mut trajectory, *start..end, &mut equations.rows)?;
        eliminate(&sums, common, &mut equations)?;
    }
    Some(equations)
}

fn segment_sums(
    trajectory: &mut Trajectory<'_>,
    rows: std::ops::Range<usize>,
    predicted: &mut Vec<[Vector3<f64>; 2]>,
) -> Option<Sums> {
    let (record, size) = (trajectory.record, trajectory.sensitivity.len());
    let mut by = vec![Vector3::zeros(); size];
    let mut sums = Sums {
        normal: vec![0.0; size * size],
        gradient: vec![0.0; size],
        chi_square: 0.0,
        unused: 0.0,
    };
    let per_variance = 1.0 / (record.noise_rad_s * record.noise_rad_s);
    let last = rows.end - 1;
    for row in rows {
        let rate = trajectory.rate(row);
        if !rate.iter().all(|x| x.abs() < FASTEST_RAD_S) {
            return None;
        }
        let drive = trajectory.drive;
        let residual = record.rate_rad_s[row] - drive.reading * rate - drive.bias;
        if record.weight[row] > 0.0 {
            trajectory.reading_by(row, &rate, &mut by);
            sums.add(&by, &residual, record.weight[row] * per_variance);
        } else {
            sums.unused += residual.norm_squared() * per_variance;
        }
        let is_used = record.weight[row] > 0.0;
        predicted.push([rate, if is_used { residual } else { Vector3::zeros() }]);
        if row < last {
            trajectory.advance(row);
        }
    }
    Some(sums)
}

/// Adds the sums of a segment without its initial momentum: Schur complement.
fn eliminate(sums: &Sums, common: usize, equations: &mut Equations) -> Option<()> {
    let size = LOCAL + common;
    let normal = |i: usize, k: usize| sums.normal[i.max(k) * size + i.min(k)];
    let local = Matrix3::from_fn(&normal);
    // A segment whose readings are all refused has no information on its momentum.
    let local =
        (local + Matrix3::identity() * (1e-12 * local.trace().max(1e-300))).try_inverse()?;
    let cross = Matrix3xX::from_fn(common, |i, k| normal(i, LOCAL + k));
    let gradient = Vector3::from_fn(|i, _| sums.gradient[i]);
    let by_common = local * &cross;
    let alone = local * gradient;
    let taken = cross.transpose() * &by_common;
    let taken_gradient = cross.transpose() * alone;
    for i in 0..common {
        for k in 0..common {
            equations.normal[(i, k)] += normal(LOCAL + i, LOCAL + k) - taken[(i, k)];
        }
        equations.gradient[i] += sums.gradient[LOCAL + i] - taken_gradient[i];
    }
    equations.chi_square += sums.chi_square;
    equations.unused_squares += sums.unused;
    equations.local.push((alone, by_common));
    Some(())
}

#[cfg(test)]
mod tests {
    use super::super::fit::Unknowns;
    use super::super::model::Unknown;
    use super::super::record::Wheel;
    use super::*;

    /// A tumbling body with two wheels and a torque that change with time.
    fn record() -> Record {
        const ROWS: usize = 60;
        let time_s: Vec<f64> = (0..ROWS).map(|row| row as f64 * 0.05).collect();
        let speed = |frequency: f64| time_s.iter().map(|t| 100.0 * (frequency * t).sin()).collect();
        Record {
            rate_rad_s: vec![Vector3::new(0.1, -0.2, 0.3); ROWS],
            wheel_rad_s: vec![speed(0.7), speed(1.1)],
            torque_n_m: time_s.iter().map(|t| Vector3::new(0.1, 0.2, -0.1) * t.cos()).collect(),
            weight: vec![1.0; ROWS],
            wheels: [Vector3::x(), Vector3::new(0.0, 0.6, 0.8)]
                .map(|axis| Wheel { axis, inertia_kg_m2: 1e-3 })
                .into(),
            noise_rad_s: 1e-3,
            time_s,
        }
    }

    fn unknowns() -> Vec<Unknown> {
        vec![
            Unknown::GyroScale(0),
            Unknown::GyroAxes(1, 2),
            Unknown::Bias(2),
            Unknown::WheelInertia(1),
            Unknown::WheelAxis(0, 1),
            Unknown::Delay,
            Unknown::TorqueScale,
            Unknown::Torque(1),
        ]
    }

    /// Gradient without the initial momentum: `∂χ²/∂p = −2 g` where the momentum follows by `−A_hh⁻¹ A_hc` per step.
    #[test]
    fn gradient_agrees_with_differences_of_chi_square() {
        /// Step of each unknown, and the agreement: the sensitivities are those of one midpoint step per row.
        const STEP: f64 = 1e-5;
        const AGREEMENT: f64 = 2e-3;
        let (record, unknowns) = (record(), Unknowns::of(unknowns()));
        let segments = Segments { starts: vec![0], end: record.len() };
        let further = vec![0.01, -0.02, 0.01, 0.02, 0.01, 0.004, 0.03, 0.01];
        let inertia = Vector6::new(1.0, 1.3, 1.6, 0.1, -0.05, 0.02);
        let start = Point { inertia, further, momentum: vec![Vector3::new(0.2, 0.1, 0.4)] };
        let at = |point: &Point| {
            let drive = Drive::new(&record, &unknowns.names, &point.further, &[], 1.0);
            pass(&record, &drive, &segments, point).unwrap()
        };
        let found = at(&start);
        for i in 0..start.further.len() + INERTIA {
            let chi_square = |step: f64| {
                let mut point = start.clone();
                let mut common = DVector::zeros(start.further.len() + INERTIA);
                common[i] = step;
                match i.checked_sub(INERTIA) {
                    None => point.inertia[i] += step,
                    Some(place) => point.further[place] += step,
                }
                point.momentum[0] -= &found.local[0].1 * common;
                at(&point).chi_square
            };
            let slope = (chi_square(STEP) - chi_square(-STEP)) / (2.0 * STEP);
            let expected = -2.0 * found.gradient[i];
            let size = found.gradient.amax();
            assert!((slope - expected).abs() < AGREEMENT * size, "{i}: {slope} {expected}");
        }
    }

    #[test]
    fn motion_without_torque_keeps_the_size_of_its_momentum() {
        let mut record = record();
        record.torque_n_m.fill(Vector3::zeros());
        let drive = Drive::new(&record, &[], &[], &[], 1.0);
        let inertia = Vector6::new(1.0, 1.3, 1.6, 0.1, -0.05, 0.02);
        let inverse = tensor(&inertia).try_inverse().unwrap();
        let momentum = Vector3::new(0.2, 0.1, 0.4);
        let mut trajectory = Trajectory::new(&record, &drive, inverse, momentum);
        let before = trajectory.momentum.norm();
        (0..record.len() - 1).for_each(|row| trajectory.advance(row));
        assert!((trajectory.momentum.norm() - before).abs() < 1e-8 * before);
    }
}
