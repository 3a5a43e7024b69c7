//! Fit of a model to a record: Levenberg-Marquardt over segments that grow to the whole record.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3, Vector6};

use super::model::{Drive, Signal, Unknown};
use super::pass::{Equations, INERTIA_UNKNOWNS, Point, Segments, pass, tensor};
use super::record::{MARGIN, Record};
use super::start::starts;
use crate::input::craft::Prior;

/// Numbers of segments, one stage after the other.
const STAGES: [usize; 3] = [16, 4, 1];
/// Fewest rows of a segment.
const SHORTEST: usize = 24;
/// Steps of each stage, at most.
const STEPS: usize = 8;
/// Relative decrease of chi-square at which a stage ends.
const SETTLED: f64 = 1e-4;
/// Sigma of each element over the scale before the data: any rigid body of about that scale.
const ANY_BODY: f64 = 100.0;

/// Unknowns of a fit and their prior sigma.
#[derive(Clone, Debug, Default)]
pub(super) struct Unknowns {
    pub names: Vec<Unknown>,
    pub sigma: Vec<f64>,
    /// Signals of the modal inertia, over the scale.
    pub modal: Vec<Signal>,
}

impl Unknowns {
    pub(super) fn of(names: Vec<Unknown>) -> Self {
        let sigma = names.iter().map(|name| name.widest()).collect();
        Self { names, sigma, modal: Vec::new() }
    }
}

/// A fitted model.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    /// Sum of squared residuals over the noise, of priors, and of the distance to a physical tensor.
    pub chi_square: f64,
    /// Further unknowns, and one sigma of each, scaled by the residuals.
    pub values: Vec<f64>,
    pub sigmas: Vec<f64>,
    /// Sum of squares of rows that are not in use.
    pub unused_squares: f64,
    /// Number of scalar readings.
    pub readings: f64,
    scale_kg_m2: f64,
    point: Point,
}

/// A record, what is fitted to it, and the prior of the inertia.
pub(super) struct Problem<'a> {
    pub record: &'a Record,
    pub unknowns: &'a Unknowns,
    pub prior: Option<&'a Prior>,
    scale_kg_m2: f64,
}

impl<'a> Problem<'a> {
    pub(super) fn new(
        record: &'a Record,
        unknowns: &'a Unknowns,
        prior: Option<&'a Prior>,
    ) -> Self {
        let scale_kg_m2 = scale_kg_m2(record, prior);
        Self { record, unknowns, prior, scale_kg_m2 }
    }

    /// The fit over the first stage only, in short segments.
    pub(super) fn coarse(&self) -> Option<Fit> {
        let segments = self.segments(STAGES[0]);
        let zeros = vec![0.0; self.unknowns.names.len()];
        let drive = self.drive(&zeros);
        let points = starts(self.record, &drive, &segments).into_iter().filter_map(|inertia| {
            let momentum = self.momenta(&drive, &segments, &inertia);
            let point = Point { inertia, further: zeros.clone(), momentum };
            Some((self.equations(&segments, &point)?, point))
        });
        let (equations, point) = points.min_by(|a, b| a.0.chi_square.total_cmp(&b.0.chi_square))?;
        self.descend(&segments, equations, point)
    }

    /// The later stages, from a fit of the first.
    pub(super) fn whole(&self, coarse: &Fit) -> Option<Fit> {
        let Point { mut inertia, mut further, .. } = coarse.point.clone();
        inertia *= coarse.scale_kg_m2 / self.scale_kg_m2;
        let mut known: Option<(Vec<usize>, Vec<Vector3<f64>>)> = None;
        let mut fit = None;
        for count in &STAGES[1..] {
            let segments = self.segments(*count);
            let of_start = |start: &usize| {
                let (starts, momenta) = known.as_ref()?;
                Some(momenta[starts.iter().position(|s| s == start)?])
            };
            let earlier: Option<Vec<_>> = segments.starts.iter().map(of_start).collect();
            let drive = self.drive(&further);
            let momentum = earlier.unwrap_or_else(|| self.momenta(&drive, &segments, &inertia));
            let point = Point { inertia, further, momentum };
            let equations = self.equations(&segments, &point)?;
            let next = self.descend(&segments, equations, point)?;
            (inertia, further) = (next.point.inertia, next.point.further.clone());
            known = Some((segments.starts, next.point.momentum.clone()));
            fit = Some(next);
        }
        fit
    }

    /// Equal parts of each stretch without gap. Fewer segments start where more did.
    fn segments(&self, count: usize) -> Segments {
        let (first, end) = (MARGIN, self.record.len().saturating_sub(MARGIN));
        let mut bounds = vec![first];
        bounds.extend(self.record.gaps().into_iter().filter(|gap| *gap > first && *gap + 2 < end));
        bounds.push(end);
        let rows = end.saturating_sub(first).max(1);
        let mut segments = Vec::new();
        for pair in bounds.windows(2) {
            let length = pair[1] - pair[0];
            let finest = (STAGES[0] * length / rows).min(length / SHORTEST).max(1);
            // A power of four, so that the later stages keep starts of the first.
            let finest = 4_usize.pow(finest.ilog(4));
            let parts = finest.min(count);
            segments.extend((0..parts).map(|part| pair[0] + part * length / parts));
        }
        Segments { starts: segments, end }
    }

    fn drive(&self, further: &[f64]) -> Drive {
        let Unknowns { names, modal, .. } = self.unknowns;
        Drive::new(self.record, names, further, modal, self.scale_kg_m2)
    }

    /// Momentum at the start of each segment by the reading there.
    fn momenta(
        &self,
        drive: &Drive,
        segments: &Segments,
        inertia: &Vector6<f64>,
    ) -> Vec<Vector3<f64>> {
        let record = self.record;
        let inverse = drive.reading.try_inverse().unwrap_or_else(Matrix3::identity);
        let of_start = |start: &usize| {
            let row = (*start..record.len()).find(|row| record.weight[*row] > 0.0);
            let rate = inverse * (record.rate_rad_s[row.unwrap_or(*start)] - drive.bias);
            tensor(inertia) * rate + drive.momentum.at[*start]
        };
        segments.starts.iter().map(of_start).collect()
    }

    /// Levenberg-Marquardt from a point and its equations.
    fn descend(
        &self,
        segments: &Segments,
        mut equations: Equations,
        mut point: Point,
    ) -> Option<Fit> {
        let mut damping = 1e-6;
        for _ in 0..STEPS {
            let Some(next) = self.stepped(&equations, &point, damping) else { break };
            match self.equations(segments, &next) {
                Some(better) if better.chi_square <= equations.chi_square => {
                    let decrease = equations.chi_square - better.chi_square;
                    let is_settled = decrease < SETTLED * better.chi_square;
                    (point, equations) = (next, better);
                    damping = (damping * 0.1_f64).max(1e-9);
                    if is_settled {
                        break;
                    }
                }
                _ => damping = (damping * 30.0).max(1e-3),
            }
        }
        self.result(point, &equations)
    }

    fn stepped(&self, equations: &Equations, point: &Point, damping: f64) -> Option<Point> {
        let mut normal = equations.normal.clone();
        for i in 0..normal.nrows() {
            normal[(i, i)] *= 1.0 + damping;
        }
        let step = normal.cholesky()?.solve(&equations.gradient);
        let mut next = point.clone();
        next.inertia += step.fixed_rows::<INERTIA_UNKNOWNS>(0);
        for (value, step) in next.further.iter_mut().zip(step.iter().skip(INERTIA_UNKNOWNS)) {
            *value += step;
        }
        for (segment, momentum) in next.momentum.iter_mut().enumerate() {
            *momentum += equations.momentum_step(segment, &step);
        }
        Some(next)
    }

    /// Normal equations of data and priors.
    fn equations(&self, segments: &Segments, point: &Point) -> Option<Equations> {
        let drive = self.drive(&point.further);
        let mut equations = pass(self.record, &drive, segments, point)?;
        let mut add = |place: usize, residual: f64, sigma: f64| {
            let weight = 1.0 / (sigma * sigma);
            equations.normal[(place, place)] += weight;
            equations.gradient[place] += weight * residual;
            equations.chi_square += weight * residual * residual;
        };
        for i in 0..INERTIA_UNKNOWNS {
            add(i, -point.inertia[i], ANY_BODY);
            if let Some(prior) = self.prior {
                let expected = prior.inertia_kg_m2[i] / self.scale_kg_m2;
                let sigma = prior.sigma_kg_m2[i] / self.scale_kg_m2;
                add(i, expected - point.inertia[i], sigma);
            }
        }
        for (i, sigma) in self.unknowns.sigma.iter().enumerate() {
            add(INERTIA_UNKNOWNS + i, -point.further[i], *sigma);
        }
        equations.chi_square.is_finite().then_some(equations)
    }

    fn result(&self, point: Point, equations: &Equations) -> Option<Fit> {
        let covariance = inverse(&equations.normal)?;
        let readings = self.record.readings();
        let excess = (equations.chi_square / readings).max(1.0);
        let sigma = |i: usize| (covariance[(i, i)].max(0.0) * excess).sqrt();
        let chi_square = equations.chi_square + distance_to_physical(&point.inertia, &covariance);
        Some(Fit {
            chi_square,
            sigmas: (0..point.further.len()).map(|i| sigma(INERTIA_UNKNOWNS + i)).collect(),
            values: point.further.clone(),
            unused_squares: equations.unused_squares,
            readings,
            scale_kg_m2: self.scale_kg_m2,
            point,
        })
    }
}

fn inverse(normal: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let scale = DVector::from_fn(normal.nrows(), |i, _| 1.0 / normal[(i, i)].sqrt());
    let scaled = DMatrix::from_fn(normal.nrows(), normal.nrows(), |i, k| {
        normal[(i, k)] * scale[i] * scale[k]
    });
    let inverse = scaled.cholesky()?.inverse();
    Some(DMatrix::from_fn(normal.nrows(), normal.nrows(), |i, k| {
        inverse[(i, k)] * scale[i] * scale[k]
    }))
}

/// Chi-square of the nearest physical tensor over that of the fit. A tensor is physical where
/// `½ tr(J) 1 − J` is positive semidefinite; its smallest eigenvalue is `½ tr(J) − vᵀJv`, to first order linear in J.
fn distance_to_physical(j: &Vector6<f64>, covariance: &DMatrix<f64>) -> f64 {
    let t = tensor(j);
    let eigen = (Matrix3::identity() * (0.5 * t.trace()) - t).symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    let value = eigen.eigenvalues[least];
    if value >= 0.0 {
        return 0.0;
    }
    let v = eigen.eigenvectors.column(least);
    let slope = Vector6::new(
        0.5 - v[0] * v[0],
        0.5 - v[1] * v[1],
        0.5 - v[2] * v[2],
        -2.0 * v[0] * v[1],
        -2.0 * v[0] * v[2],
        -2.0 * v[1] * v[2],
    );
    let variance = (slope.transpose() * covariance.fixed_view::<6, 6>(0, 0) * slope)[(0, 0)];
    value * value / variance.max(f64::MIN_POSITIVE)
}

/// Typical moment, kg m²: of the prior; else momentum exchanged or angular impulse over the spread of the rate.
fn scale_kg_m2(record: &Record, prior: Option<&Prior>) -> f64 {
    if let Some(prior) = prior {
        return prior.inertia_kg_m2[..3].iter().sum::<f64>() / 3.0;
    }
    let spread = |values: &[Vector3<f64>]| {
        let mean = values.iter().sum::<Vector3<f64>>() / values.len() as f64;
        let squares = values.iter().map(|value| (value - mean).norm_squared()).sum::<f64>();
        (squares / values.len() as f64).sqrt()
    };
    let mut driven = vec![Vector3::zeros(); record.len()];
    let mut impulse = Vector3::zeros();
    for (row, driven) in driven.iter_mut().enumerate() {
        if row > 0 {
            impulse += record.torque_n_m[row] * (record.time_s[row] - record.time_s[row - 1]);
        }
        *driven = impulse;
        for (wheel, speeds) in record.wheels.iter().zip(&record.wheel_rad_s) {
            *driven -= wheel.axis * (wheel.inertia_kg_m2 * speeds[row]);
        }
    }
    let scale = spread(&driven) / spread(&record.rate_rad_s).max(record.noise_rad_s);
    if scale.is_finite() && scale > 0.0 { scale } else { 1.0 }
}
