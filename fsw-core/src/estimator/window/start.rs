//! Where passes start: what a solution says of its front, and the first point.

use super::linear_start::{self, Kind};
use super::pass::Residuals;
use super::solution::Solving;
use super::unknowns::Point;
use super::work::{Starting, Work};
use super::{BLOCKS_TO_SEE, Window, contradicts};
use crate::Reset;
use crate::math::{Vec3, scalar::Real};
use crate::prior::Prior;
use crate::tensor::Inertia;

/// No pass before so many blocks: fewer equations than a few per unknown say little.
const BLOCKS_TO_START: usize = 16;
/// Fast motion that nothing drives shows no size, and need not be waited for longer than this: a throw
/// lasts no longer than a few blocks.
const BLOCKS_TO_TUMBLE: usize = 10;
/// Blocks that turn so far are fast motion, rad.
const FAST_TURN: f64 = 0.3;
/// With a past to start from, so many will do: a pass crosses the first of them.
const BLOCKS_TO_RESUME: usize = 3;
/// A front whose squared residuals exceed what the noise makes of them by this factor hasn't
/// found the solution yet: it is tried again, from its own point, and ever more
/// rarely from the linear start.
const UNEXPLAINED: f64 = 1.5;
/// A solution within so many sigmas of its pass's own point isn't worth another.
const SETTLED_SIGMA: f64 = 0.01;
/// Within so many, what linearising left out doesn't show in a chi-square test.
const CLOSE_SIGMA: f64 = 1.0;
/// Within so many for each unknown, it doesn't show in residuals. A pass whose
/// data have grown by half since its point was found moves by as much, and not because of that.
const NEAR_SIGMA: f64 = 2.5;
/// Drag that noise alone imitates once in 10⁵ windows: chi-square of three degrees of freedom.
const DRAG_SHOWN: f64 = 26.0;
/// A pass that has yet to step so many sigmas squared may err by as many times that in a sum of squares.
const UNSURE: f64 = 4.0;
/// An element of more typical inertias than this is a pass that went astray.
const ASTRAY: f64 = 10.0;
/// And so is a body this much thinner than its size: four times its determinant over the cube of its
/// trace is about the share of the smallest moment in the trace, and a rod of one to a hundred has
/// 2e-4.
const THIN: f64 = 1.0e-4;
/// A point may break the triangle inequality by this share of the trace.
const UNPHYSICAL: f64 = 0.05;
/// A linear start larger or smaller than the typical inertia by this factor is another body.
const OTHER_SIZE: f64 = 3.0;
/// A step that leads astray is halved so often before it is given up.
const HALVINGS: u32 = 5;
/// Rows beyond the unknowns that a front, and those it went on from, have seen before it tells spikes: three
/// times as many as the most unknowns.
const ARMED_DEGREES: u32 = 45;
/// And before it needs no linear start any more: three times as many again.
const SURE_DEGREES: u32 = 135;
/// Rows that a settled front takes in until it is looked at again: eight blocks.
const REST_ROWS: u32 = 24;

/// What a solution says of its front.
enum Finding {
    /// The data contradict what was known before.
    PastContradicted,
    /// The torque changes with the motion.
    Drag,
    /// Another pass would change nothing.
    Settled,
    /// Another pass is needed. How near the point is to its solution.
    Unsettled(Distance),
}

/// How far a point is from its solution.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Distance {
    /// So far that its linearisation may be wrong.
    Far,
    /// Near enough to take in more.
    Near,
    /// So near that few rows are needed to tell spikes.
    Close,
}

impl<T: Real, const W: usize, const N: usize, const U: usize> Window<T, W, N, U> {
    /// The front is solved: what follows from that.
    pub(super) fn judge(&mut self, solving: &Solving<T>) {
        self.work = Work::Idle;
        self.forget_the_linear_start();
        let finding = self.finding(solving);
        self.note_how_near(&finding);
        match finding {
            Some(Finding::PastContradicted) => {
                self.past = None;
                self.watch.event = Some(Reset::Changed);
            }
            Some(Finding::Drag) => self.has_drag = true,
            Some(Finding::Settled) => {
                let rows = self.passes.front().map_or(0, |front| front.residuals().rows);
                self.rests_until = rows.saturating_add(REST_ROWS);
            }
            Some(Finding::Unsettled(_)) => self.work = Work::Choosing,
            None => {}
        }
    }

    /// A front near its solution tells spikes, once it has seen enough.
    fn note_how_near(&mut self, finding: &Option<Finding>) {
        let distance = match finding {
            Some(Finding::Settled) => Distance::Close,
            Some(Finding::Unsettled(distance)) => *distance,
            _ => return,
        };
        let Some(front) = self.passes.front() else { return };
        let degrees = self.ended.degrees().saturating_add(front.residuals().degrees());
        let is_near = distance != Distance::Far;
        let enough = if distance == Distance::Close { ARMED_DEGREES } else { SURE_DEGREES };
        self.watch.is_armed |= is_near && degrees >= enough;
        let if_so = |is_so: bool| if is_so { front.next() } else { 0 };
        self.watch.near_at = if_so(is_near);
        self.watch.close_at = if_so(distance == Distance::Close);
        self.has_started_over &= distance != Distance::Close;
        self.has_explained |= is_near;
    }

    /// Linear least squares isn't needed any more once a front that tells spikes has explained many rows.
    fn forget_the_linear_start(&mut self) {
        let Some(front) = self.passes.front() else { return };
        let residuals = front.residuals();
        let is_sure = self.watch.is_armed && self.is_at_noise(residuals);
        if is_sure && residuals.degrees() >= SURE_DEGREES && self.linear().is_some() {
            self.beginning = super::Beginning::Found;
        }
    }

    /// What a solution says of its front. A sum of squares is known as surely as the step is small.
    fn finding(&self, solving: &Solving<T>) -> Option<Finding> {
        let front = self.passes.front()?;
        let noise = self.scale_rad_s(front.residuals());
        let within = |square: T, sigma: f64| square < noise * noise * T::lit(sigma * sigma);
        let solved_square = self.passes.other().information().size_square();
        let step = solved_square.min(front.information().size_square());
        let surely = |square: T| square - step * T::lit(UNSURE);
        if !self.has_found(front.residuals()) {
            return Some(Finding::Unsettled(Distance::Far));
        }
        if self.past.is_some() && contradicts(surely(solving.past_square()), noise) {
            return Some(Finding::PastContradicted);
        }
        let drag_square = solving.drag_square();
        if self.shows_drag(front.residuals(), drag_square, surely(drag_square)) {
            return Some(Finding::Drag);
        }
        Some(if within(solved_square, SETTLED_SIGMA) {
            Finding::Settled
        } else {
            let near_square = noise * noise * T::lit(NEAR_SIGMA * NEAR_SIGMA * U as f64);
            Finding::Unsettled(match step {
                _ if within(step, CLOSE_SIGMA) => Distance::Close,
                _ if step < near_square => Distance::Near,
                _ => Distance::Far,
            })
        })
    }

    /// Whether a torque that is looked for changes with the motion, by the sum of squares that drag of
    /// zero leaves, and what of that is sure. Where the noise is measured from residuals there is more
    /// than noise in them: a pass never settles, and their correlation counts instead.
    fn shows_drag(&self, residuals: &Residuals<T>, square: T, surely: T) -> bool {
        let noise = self.scale_rad_s(residuals);
        let shown = noise * noise * self.inflation(residuals) * T::lit(DRAG_SHOWN);
        let is_given = self.config.gyro_noise_rad_s.is_some();
        let is_asked_for = self.config.disturbance_torque_n_m.is_some();
        is_asked_for && !self.has_drag && (if is_given { surely } else { square }) > shown
    }

    /// Whether a pass leaves no more than the noise does, as given or as measured.
    fn is_at_noise(&self, residuals: &Residuals<T>) -> bool {
        let noise = self.noise_rad_s();
        residuals.mean_square() < noise * noise * T::lit(UNEXPLAINED)
    }

    /// Whether a pass is at the noise; or where that isn't given, and so may be more than third
    /// differences show, leaves no more than the front.
    pub(super) fn has_found(&self, residuals: &Residuals<T>) -> bool {
        let ours = residuals.mean_square();
        let front = self.passes.front().map_or(T::zero(), |f| f.residuals().mean_square());
        let is_given = self.config.gyro_noise_rad_s.is_some();
        self.is_at_noise(residuals) || (!is_given && ours.is_finite() && ours <= front)
    }

    /// Where the next pass starts: from the front's solution, or where it hasn't explained the data for
    /// long from the linear start.
    pub(super) fn choose(&mut self) {
        self.work = Work::Idle;
        let Some(front) = self.passes.front() else { return };
        let step = self.passes.other().information().solve();
        let found = step.and_then(|step| plausible_point(front.point(), step));
        let is_found = self.is_at_noise(front.residuals());
        // What goes astray once it was at the noise is tried afresh soon.
        self.attempts = if is_found { 0 } else { self.attempts.saturating_add(1) };
        // No inertia will, if one did before. Once: what isn't explained then either has another cause, such as
        // a torque that nobody models.
        let has_changed = !is_found && self.has_explained && !self.explains(front.residuals());
        if has_changed && !self.has_started_over {
            self.watch.event = Some(Reset::Lockout);
            return;
        }
        let is_guided = is_found || self.linear().is_none() || !self.attempts.is_power_of_two();
        match found {
            Some(point) if is_guided => self.work = Work::Beginning(point),
            otherwise => self.begin_linear_start(Kind::Driven, otherwise),
        }
    }

    /// Begins to solve the linear start; without one, the other point is where to start.
    fn begin_linear_start(&mut self, kind: Kind, otherwise: Option<Point<T>>) {
        let noise = self.noise_rad_s();
        self.work = match &self.beginning {
            super::Beginning::Linear(linear) => {
                let room = self.passes.both().1.room();
                let solving = linear_start::Solving::begin(kind, linear, noise, room);
                Work::Starting(Starting { kind, solving, otherwise })
            }
            _ => otherwise.map_or(Work::Idle, Work::Beginning),
        };
    }

    /// Where a first pass starts: from the past, from linear least squares once there is enough
    /// motion, and where that doesn't come, from a sphere.
    pub(super) fn look_for_a_start(&mut self) {
        if self.blocks.len() < BLOCKS_TO_RESUME {
            return;
        }
        if let Some(inertia) = self.past.as_ref().and_then(sharp_inertia) {
            self.typical_kg_m2 = (inertia[0] + inertia[1] + inertia[2]) * T::lit(1.0 / 3.0);
            self.work = self.at_rest_from(inertia.map(|x| x / self.typical_kg_m2));
        } else if self.blocks.len() >= BLOCKS_TO_START {
            self.begin_linear_start(Kind::Driven, None);
        } else if self.blocks.len() >= BLOCKS_TO_TUMBLE && self.tumbles() {
            self.begin_linear_start(Kind::Homogeneous, None);
        }
    }

    /// Whether the body turns fast, and nothing drives it.
    fn tumbles(&self) -> bool {
        let noise = self.noise_rad_s();
        let is_free = |linear: &super::LinearStart<T, U>| {
            linear.size_kg_m2(noise).is_none() && linear.is_clear(noise)
        };
        self.blocks.turn_by(T::lit(FAST_TURN)) && self.linear().is_some_and(is_free)
    }

    /// The linear start has a solution.
    pub(super) fn start_from(&mut self, starting: &Starting<T>, start: &linear_start::Solution<T>) {
        if !start.inertia.is_positive_definite() {
            return self.start_otherwise(starting);
        }
        match starting.kind {
            // In units of its own mean moment any inertia is a homogeneous one.
            Kind::Homogeneous => {
                self.typical_kg_m2 = self.prior_unit_kg_m2().unwrap_or(T::one());
                let inertia = start.inertia.elements_kg_m2();
                self.work = Work::Beginning(Point::new(start.momentum_n_m_s, inertia));
            }
            Kind::Driven => self.work = Work::Beginning(self.driven_point(start)),
        }
    }

    /// The point of linear least squares; its size is the unit where nothing has one yet.
    fn driven_point(&mut self, start: &linear_start::Solution<T>) -> Point<T> {
        let size = start.inertia.trace_kg_m2() * T::lit(1.0 / 3.0);
        let is_near = size < self.typical_kg_m2 * T::lit(OTHER_SIZE)
            && size * T::lit(OTHER_SIZE) > self.typical_kg_m2;
        if self.passes.front().is_none() || !is_near {
            // A front in other units can't be compared; and it explains nothing.
            self.passes.drop_front();
            self.typical_kg_m2 = size;
        }
        let per = T::one() / self.typical_kg_m2;
        Point {
            momentum: start.momentum_n_m_s * per,
            torque: start.torque_n_m * per,
            bias: start.bias_rad_s,
            drag: Vec3::zeros(),
            inertia: start.inertia.elements_kg_m2().map(|x| x * per),
        }
    }

    /// The linear start has none.
    pub(super) fn start_otherwise(&mut self, starting: &Starting<T>) {
        self.work = Work::Idle;
        if let Some(point) = starting.otherwise {
            self.work = Work::Beginning(point);
        }
        if self.passes.front().is_some() || self.blocks.len() < BLOCKS_TO_TUMBLE {
            return;
        }
        let noise = self.noise_rad_s();
        let Some(linear) = self.linear() else { return };
        let size = linear.size_kg_m2(noise);
        if starting.kind == Kind::Driven && size.is_none() && linear.is_clear(noise) {
            return self.begin_linear_start(Kind::Homogeneous, None);
        }
        if self.blocks.len() < BLOCKS_TO_SEE {
            return;
        }
        if let Some(prior) = self.prior().or(size.map(Prior::of_size)) {
            self.typical_kg_m2 = mean_moment(&prior);
            self.work = self.at_rest_from(prior.inertia_kg_m2.map(|x| x / self.typical_kg_m2));
        }
    }

    /// The prior, unless the data contradict it.
    fn prior(&self) -> Option<Prior<T>> {
        self.config.prior.filter(|_| self.past.is_some())
    }

    fn prior_unit_kg_m2(&self) -> Option<T> {
        self.prior().as_ref().map(mean_moment)
    }

    /// A point of this inertia, in typical ones, with the momentum that the first block shows.
    fn at_rest_from(&self, inertia: [T; 6]) -> Work<T, U> {
        let Some(first) = self.blocks.block(0) else { return Work::Idle };
        let drive = first.drive_n_m_s * (T::one() / self.typical_kg_m2);
        let momentum = Inertia::new(inertia).matrix_kg_m2() * first.rate_rad_s + drive;
        Work::Beginning(Point::new(momentum, inertia))
    }
}

fn mean_moment<T: Real>(prior: &Prior<T>) -> T {
    Inertia::new(prior.inertia_kg_m2).trace_kg_m2() * T::lit(1.0 / 3.0)
}

/// What the past says of the inertia, kg m², if it is sharp enough to start from.
fn sharp_inertia<T: Real>(past: &super::past::Past<T>) -> Option<[T; 6]> {
    let inertia = past.inertia()?;
    let variances = past.information.variances()?;
    let mean_moment = (inertia[0] + inertia[1] + inertia[2]) * T::lit(1.0 / 3.0);
    let sharp = mean_moment * T::lit(super::solution::VAGUE);
    let is_sharp = variances.iter().all(|v| *v < sharp * sharp);
    (is_sharp && Inertia::new(inertia).is_positive_definite()).then_some(inertia)
}

/// A point a step further, or as far on the way to it as a body could be.
fn plausible_point<T: Real, const U: usize>(from: &Point<T>, mut step: [T; U]) -> Option<Point<T>> {
    for _ in 0..HALVINGS {
        let point = from.plus(&step);
        if is_plausible(&point) {
            return Some(point);
        }
        step = step.map(|x| x * T::lit(0.5));
    }
    None
}

/// Whether a pass from there has a chance: of a body or nearly so, not far too thin, and no larger than
/// the unit allows.
fn is_plausible<T: Real>(point: &Point<T>) -> bool {
    let inertia = Inertia::new(point.inertia);
    let trace = inertia.trace_kg_m2();
    let [_, _, determinant] = inertia.leading_minors();
    // ½ tr(J) 1 − J is that of a body; a little more than half leaves room for noise.
    let [xx, yy, zz, xy, xz, yz] = point.inertia;
    let most = trace * T::lit(0.5 + UNPHYSICAL);
    let shape = Inertia::new([most - xx, most - yy, most - zz, -xy, -xz, -yz]);
    inertia.is_positive_definite()
        && shape.is_positive_definite()
        && determinant > T::lit(THIN) * trace * trace * trace
        && point.inertia.iter().all(|x| x.abs() < T::lit(ASTRAY))
}
