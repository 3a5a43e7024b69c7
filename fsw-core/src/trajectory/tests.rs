//! Motion and derivatives of blocks against short blocks, finite differences, and what has no effect.

use super::unknowns::{Belief, FIRST_GROUP, shape_of, to_shape};
use super::*;
use crate::blocks::block::Block;
use crate::math::skew;
use std::vec::Vec;

/// All groups, with three wheels about the body axes.
const UNKNOWNS: usize = 51;
const PLACES: [Group; 14] = [
    Group::Torque,
    Group::Bias,
    Group::Drag,
    Group::GyroScale,
    Group::GyroUpper,
    Group::GyroLower,
    Group::Wheel(0),
    Group::Wheel(1),
    Group::Wheel(2),
    Group::Common,
    Group::Field(0),
    Group::Field(1),
    Group::Field(2),
    Group::Axes,
];

fn all() -> Groups<f64> {
    let mut groups = Groups { hardware: 3, ..Groups::none() };
    for (place, group) in groups.place.iter_mut().zip(PLACES) {
        *place = Some((group, Belief::Zero));
    }
    groups
}

fn point() -> Point<f64, UNKNOWNS> {
    let mut point = Point::sphere(Vec3::new(0.1, -0.07, 0.08));
    point.set_place(0, &Vec3::new(0.0007, -0.0003, 0.001));
    point.set_place(1, &Vec3::new(0.01, 0.02, -0.01));
    point.set_place(2, &Vec3::new(0.007, -0.003, 0.01));
    for place in 3..9 {
        let size = 0.003 * place as f64;
        point.set_place(place, &Vec3::new(size, -0.7 * size, 0.4 * size));
    }
    point.set_place(9, &Vec3::new(0.05, 0.02, -0.01));
    point.set_shape(&[0.04, -0.03, 0.03, -0.05, 0.02]);
    point.set_scale(0.9);
    point
}

/// Wheels that swing, and a constant torque, over blocks of this length.
fn spans(duration_s: f64, count: usize) -> Vec<Span<f64, 3>> {
    let wheels = |t: f64| Vec3::new(0.03 * (0.5 * t).sin(), 0.02, 0.03 * (0.4 * t).cos());
    let mean = |t: f64| {
        let i = |w: f64, f: fn(f64) -> f64| (f(w * (t + duration_s)) - f(w * t)) / (w * duration_s);
        Vec3::new(-0.03 * i(0.5, f64::cos), 0.02, 0.03 * i(0.4, f64::sin))
    };
    (0..count)
        .map(|k| {
            let t = k as f64 * duration_s;
            let block = Block {
                duration_s,
                wheels_n_m_s: mean(t),
                wheels_end_n_m_s: wheels(t + duration_s),
                impulse_n_m_s: Vec3::new(0.007, -0.003, 0.003) * duration_s,
                ..Block::empty()
            };
            // So many that their mean is that over time.
            Span { block, wheels_at_start: wheels(t), samples: 1e6, before: None, after: None }
        })
        .collect()
}

/// Prediction for a block: mean reading, and the derivatives by columns.
struct Prediction {
    rate_rad_s: Vec3<f64>,
    sensitivity: [Vec3<f64>; UNKNOWNS],
}

fn fly(
    point: &Point<f64, UNKNOWNS>,
    spans: &[Span<f64, 3>],
) -> (Trajectory<f64, 3, UNKNOWNS, 0>, Vec<Prediction>) {
    let mut trajectory = Trajectory::blank();
    assert!(trajectory.start(point, &all(), &Mat::identity()));
    let mut cross = |span: &Span<f64, 3>| {
        // At one attitude for all points: C has no derivatives.
        let half_turn = Vec3::new(0.1, -0.06, 0.08) * (span.block.duration_s * 0.5);
        trajectory.turn_axes(&half_turn);
        trajectory.set_torque(point);
        let crossing = trajectory.cross(span);
        trajectory.turn_axes(&half_turn);
        let rows: [[f64; UNKNOWNS]; 3] =
            core::array::from_fn(|axis| trajectory.mean_sensitivity(&crossing, axis));
        Prediction {
            rate_rad_s: trajectory.mean_rate_rad_s(&crossing),
            sensitivity: core::array::from_fn(|c| Vec3::from_fn(|r, _| rows[r][c])),
        }
    };
    let predictions = spans.iter().map(&mut cross).collect();
    (trajectory, predictions)
}

/// Remainder of the parabola of wheels that swing by a quarter of a radian in a block, 1e-3 of
/// their 0.03 in the fourth power, over forty blocks.
const PARABOLA: f64 = 5e-6;
/// Error of the sensitivities at the end after forty blocks of steps of 0.42 rad.
const END: f64 = 1e-5;
/// The same of those to torque, drag and scale, whose forcing is taken at its mean.
const END_OF_FORCING: f64 = 2e-3;
/// Size of n⁻¹, and so of the sensitivities.
const INVERSE: f64 = 3.0;
/// Share of the largest derivative of a column by which one errs where the drive swings by 2 rad in a block.
const SWING: f64 = 0.05;
/// Error of their means by the trapezoid: a twelfth of the turn's square, 1.5e-2, of which a third
/// enters.
const MEAN: f64 = 6e-3;

/// Two lengths of block, which turn by 0.2 and 0.02 rad.
#[test]
fn long_blocks_agree_with_short_ones() {
    let (long, means) = fly(&point(), &spans(0.5, 40));
    let (short, fine) = fly(&point(), &spans(0.05, 400));
    assert!((long.momentum - short.momentum).norm() < PARABOLA);
    for (k, mean) in means.iter().enumerate() {
        let ten = &fine[10 * k..10 * k + 10];
        let of_ten = ten.iter().map(|p| p.rate_rad_s).sum::<Vec3<f64>>() / 10.0;
        assert!((mean.rate_rad_s - of_ten).norm() < PARABOLA);
    }
}

fn moved(point: &Point<f64, UNKNOWNS>, column: usize, by: f64) -> Point<f64, UNKNOWNS> {
    let mut step = [0.0; UNKNOWNS];
    step[column] = by;
    let mut next = point.stepped(&step);
    next.set_momentum(&(next.momentum() + Vec3::new(step[0], step[1], step[2])));
    next
}

#[test]
fn sensitivities_agree_with_finite_differences() {
    const STEP: f64 = 1e-5;
    let spans = spans(0.5, 40);
    let (end, predictions) = fly(&point(), &spans);
    for c in 0..UNKNOWNS {
        let (up, rates_up) = fly(&moved(&point(), c, STEP), &spans);
        let (down, rates_down) = fly(&moved(&point(), c, -STEP), &spans);
        let of_momentum = (up.momentum - down.momentum) / (2.0 * STEP);
        let size = of_momentum.norm().max(1.0);
        if (42..45).contains(&c) {
            continue; // the axes, no unknowns
        }
        let is_forcing = (3..6).contains(&c) || (9..12).contains(&c) || c > 20;
        let most = if is_forcing { END_OF_FORCING } else { END };
        let error = (end.sensitivity[c] - of_momentum).norm();
        assert!(error < most * size, "{c}: {error} of {size}");
        for (k, prediction) in predictions.iter().enumerate() {
            let of_rate = (rates_up[k].rate_rad_s - rates_down[k].rate_rad_s) / (2.0 * STEP);
            let size = of_rate.norm().max(INVERSE);
            let error = (prediction.sensitivity[c] - of_rate).norm();
            assert!(error < MEAN * size, "{c}, block {k}: {error} of {size}");
        }
    }
}

/// Derivatives of the mean reading along a direction, over the sum of the sizes of their parts: the largest of all blocks.
fn largest_along(direction: &[f64; UNKNOWNS], predictions: &[Prediction]) -> f64 {
    let share = |prediction: &Prediction| {
        let parts = prediction.sensitivity.iter().zip(direction).map(|(by, along)| by * *along);
        let (sum, size) =
            parts.fold((Vec3::zeros(), 0.0), |(sum, size), part| (sum + part, size + norm(&part)));
        norm(&sum) / size
    };
    predictions.iter().map(share).fold(0.0, f64::max)
}

/// A common factor of all spin inertias, of the known torque and of the tensor has no effect, at any point: else a fit
/// would find information on it. Nor has the common error of the wheels against their own ones.
#[test]
fn a_common_scale_of_body_and_drive_has_no_sensitivity() {
    let point = point();
    let (_, predictions) = fly(&point, &spans(0.5, 40));
    let common = point.of_place(9);
    let [mut scaled, mut shared] = [[0.0; UNKNOWNS]; 2];
    for wheel in 6..9 {
        scaled[FIRST_GROUP + 3 * wheel] = 1.0 + point.of_place(wheel).x + common.z;
        shared[FIRST_GROUP + 3 * wheel] = 1.0;
    }
    scaled[FIRST_GROUP + 28] = 1.0 + common.y;
    scaled[UNKNOWNS - 1] = -point.scale();
    shared[FIRST_GROUP + 29] = -1.0;
    for direction in [scaled, shared] {
        let share = largest_along(&direction, &predictions);
        assert!(share < 1e-12, "{share}");
    }
}

/// A turn of gyro, wheels and body as one has no effect, at any point. What is left is of the fourth power of the turn in a
/// step of 0.16 rad, and a twelfth of its square in one of 0.016 rad, which is slow.
#[test]
fn a_turn_of_all_axes_has_no_sensitivity() {
    let mut point = point();
    point.set_place(2, &Vec3::zeros()); // drag is about the body axes
    for (duration_s, most) in [(0.5, 2e-5), (0.05, 1e-5)] {
        let mut spans = spans(duration_s, 40);
        for span in &mut spans {
            span.block.impulse_n_m_s = Vec3::zeros();
        }
        let (trajectory, predictions) = fly(&point, &spans);
        for turn in [Vec3::x(), Vec3::y(), Vec3::z()] {
            let share = largest_along(&turned(&point, &trajectory, &turn), &predictions);
            assert!(share < most, "{duration_s}: {share:e}");
        }
    }
}

/// Change of the unknowns by a turn of all axes.
fn turned(
    point: &Point<f64, UNKNOWNS>,
    trajectory: &Trajectory<f64, 3, UNKNOWNS, 0>,
    turn: &Vec3<f64>,
) -> [f64; UNKNOWNS] {
    let by = skew(turn);
    let mut direction = [0.0; UNKNOWNS];
    let mut put = |first: usize, values: &[f64]| {
        direction[first..first + values.len()].copy_from_slice(values);
    };
    put(MOMENTUM, (by * point.momentum()).as_slice());
    put(FIRST_GROUP, (by * point.of_place(0)).as_slice());
    let model = &trajectory.model;
    let n = model.inverse.try_inverse().unwrap();
    let gyro = model.reading * n * -by;
    put(FIRST_GROUP + 9, gyro.diagonal().as_slice());
    put(FIRST_GROUP + 12, &[(0, 1), (0, 2), (1, 2)].map(|at| gyro[at]));
    put(FIRST_GROUP + 15, &[(1, 0), (2, 0), (2, 1)].map(|at| gyro[at]));
    for wheel in 0..3 {
        let by_errors = Mat::<f64, 3, 3>::from_columns(&model.by_errors_of_wheel(wheel));
        let i = usize::from(wheel);
        let errors = by_errors.try_inverse().unwrap() * (by * model.axes.column(i));
        put(FIRST_GROUP + 3 * (6 + i), errors.as_slice());
    }
    let turned = by * n - n * by;
    let elements = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|at| turned[at]);
    put(shape_of(UNKNOWNS), &to_shape(&elements));
    direction
}

/// A step of torque, shape and scale with the momentum at the start that compensates it: the momentum of the body now is
/// that of before, and over the trace in proportion to the scale.
#[test]
fn a_step_with_its_start_leaves_the_momentum_as_it_is() {
    const STEP: f64 = 1e-5;
    let spans = spans(0.5, 40);
    let (end, _) = fly(&point(), &spans);
    let back_to_start = end.back_to_start().unwrap();
    for c in (3..6).chain(45..UNKNOWNS) {
        let start = back_to_start.of(&end.push_of(c)) * STEP;
        let mut next = moved(&point(), c, STEP);
        next.set_momentum(&(next.momentum() - start));
        let (stepped, _) = fly(&next, &spans);
        let expected = end.momentum * (next.scale() / point().scale());
        let error = (stepped.momentum - expected).norm() / STEP;
        assert!(error < END_OF_FORCING * end.push_of(c).norm().max(1.0), "{c}: {error}");
    }
}

/// Wheels that swing by 2 rad in a block, of a body that turns little: the mean of the ends of a block is half of the
/// mean over it.
#[test]
fn sensitivities_follow_a_swing_within_a_block() {
    const STEP: f64 = 1e-5;
    let duration_s = 4.0;
    let spans = spans(duration_s, 12);
    let mut slow = point();
    slow.set_momentum(&Vec3::new(-0.0002, 0.0207, 0.0271));
    slow.set_place(0, &Vec3::zeros());
    slow.set_place(1, &Vec3::zeros());
    let (_, predictions) = fly(&slow, &spans);
    for c in (3..6).chain(12..42).chain(45..UNKNOWNS) {
        let (_, up) = fly(&moved(&slow, c, STEP), &spans);
        let (_, down) = fly(&moved(&slow, c, -STEP), &spans);
        let numeric = |k: usize| (up[k].rate_rad_s - down[k].rate_rad_s) / (2.0 * STEP);
        let size = (0..spans.len()).map(|k| numeric(k).norm()).fold(0.0, f64::max);
        for (k, prediction) in predictions.iter().enumerate() {
            let error = (prediction.sensitivity[c] - numeric(k)).norm();
            assert!(error < SWING * size, "{c}, block {k}: {error:e} of {size:e}");
        }
    }
}

#[test]
fn without_torque_momentum_keeps_its_size() {
    let mut spans = spans(0.5, 200);
    for span in &mut spans {
        span.block.impulse_n_m_s = Vec3::zeros();
    }
    let mut free = point();
    (0..3).for_each(|place| free.set_place(place, &Vec3::zeros()));
    let (end, _) = fly(&free, &spans);
    assert!((end.momentum.norm() - free.momentum().norm()).abs() < 1e-7);
}

/// Neither wheels nor torque: the column of the scale is zero in every bit.
#[test]
fn a_free_body_has_no_sensitivity_to_its_scale() {
    let mut spans = spans(0.5, 50);
    for span in &mut spans {
        span.block = Block { duration_s: 0.5, ..Block::empty() };
        span.wheels_at_start = Momenta::zeros();
    }
    let (end, predictions) = fly(&point(), &spans);
    assert_eq!(end.sensitivity[UNKNOWNS - 1], Vec3::zeros());
    assert!(predictions.iter().all(|p| p.sensitivity[UNKNOWNS - 1] == Vec3::zeros()));
}
