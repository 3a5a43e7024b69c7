//! Whiteness of a filter's innovations outside of transients of noise.
//!
//! Input: each innovation that updated the filter, and each spike. Output: white or not.
//!
//! Noise that is larger for some seconds has many spikes, and innovations below their limit that are larger than the
//! noise, too. They shift no estimate, but in the means of [`Whiteness`] they would count for minutes after the end. A
//! fault that shifts the mean ([`shift`](super::shift)) does shift the estimate: it stays in the test.
//!
//! | 8 or more of the last 32 innovations are spikes | innovation | white |
//! |---|---|---|
//! | no | enters the test | as the test says |
//! | begins | the test goes back to the state that was kept | `false` |
//! | goes on | left out | `false` |
//! | for longer than is allowed | enters the test | as the test says |
//!
//! A state is kept each 96 innovations that enter, where none of the last 32 is a spike: larger noise has its first spike
//! within some samples. White noise has one in 10⁴ samples; isolated ones of 10 % are 8 in 32 once in 100.
//!
//! An error of the model causes transients too, and recurs. What may be left out is therefore bounded, onsets included:
//! 512 innovations, an onset and 30 s at 10 Hz, and one for each eight that enter.

use super::innovation::Innovation;
use super::whiteness::Whiteness;
use crate::math::scalar::Real;

/// Spikes of the last 32 innovations that make a transient.
const TRANSIENT: u32 = 8;
/// Innovations that enter the test from one state that is kept to the next.
const BETWEEN: u16 = 96;
/// Innovations that may be left out, and innovations that enter for one more of them.
const LEFT_OUT: u16 = 512;
const FOR_ONE: u16 = 8;

/// Test of the innovations of a filter, without those of transients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Undisturbed<T: Real> {
    test: Whiteness<T>,
    /// An earlier state of the test, and the innovations since then.
    kept: Whiteness<T>,
    since: u16,
    /// Spikes of the last 32 innovations, the newest as the lowest bit.
    spikes: u32,
    left_out: u16,
}

crate::persist!([T: Real] Undisturbed<T> { test, kept, since, spikes, left_out });

impl<T: Real> Default for Undisturbed<T> {
    fn default() -> Self {
        let test = Whiteness::default();
        Self { test, kept: test, since: 0, spikes: 0, left_out: 0 }
    }
}

impl<T: Real> Undisturbed<T> {
    /// Discards all innovations, as after a restart of the filter. What has been left out counts on: faults that recur
    /// across restarts are not transients.
    pub fn restart(&mut self) {
        *self = Self { left_out: self.left_out, ..Self::default() };
    }

    /// Adds an innovation that updated the filter, as [`Whiteness::add`].
    #[inline]
    pub fn add(&mut self, innovation: &Innovation<T>, noise_rad_s: T, explained: T) {
        self.spikes <<= 1;
        if self.is_disturbed() {
            self.left_out = self.left_out.saturating_add(1);
            return;
        }
        self.test.add(innovation, noise_rad_s, explained);
        self.since = self.since.saturating_add(1);
        if self.since.is_multiple_of(FOR_ONE) {
            self.left_out = self.left_out.saturating_sub(1);
        }
        if self.since >= BETWEEN && self.spikes == 0 {
            (self.kept, self.since) = (self.test, 0);
        }
    }

    /// Notes a spike.
    pub fn refuse(&mut self) {
        let before = self.spikes.count_ones();
        self.spikes = self.spikes << 1 | 1;
        if before < TRANSIENT && self.is_disturbed() {
            self.test = self.kept;
            self.left_out = self.left_out.saturating_add(self.since);
            self.since = 0;
        }
    }

    /// True where the innovations outside of transients are white; false in a transient; `None` before there are
    /// enough of them.
    pub fn is_white(&self) -> Option<bool> {
        if self.is_disturbed() { Some(false) } else { self.test.is_white() }
    }

    /// True in a transient.
    fn is_disturbed(&self) -> bool {
        self.spikes.count_ones() >= TRANSIENT && self.left_out < LEFT_OUT
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    /// Adds innovations of alternating sign and this size, in sigmas.
    fn add(test: &mut Undisturbed<f32>, sigmas: f32, samples: u32) {
        for k in 0..samples {
            // Signs without correlation at one lag: + + − −.
            let sign = if k / 2 % 2 == 0 { sigmas } else { -sigmas };
            let rate_rad_s = Vec3::repeat(sign);
            test.add(&Innovation { rate_rad_s, variance_rad2_s2: Vec3::repeat(1.0) }, 1.0, 0.0);
        }
    }

    fn refuse(test: &mut Undisturbed<f32>, samples: u32) {
        (0..samples).for_each(|_| test.refuse());
    }

    #[test]
    fn the_onset_of_a_transient_is_left_out_with_it() {
        let mut test = Undisturbed::default();
        add(&mut test, 1.0, 400);
        assert_eq!(test.is_white(), Some(true));
        // Forty samples before the detection, of which the test alone remains not white for a thousand.
        add(&mut test, 3.0, 40);
        assert_eq!(test.is_white(), Some(false));
        refuse(&mut test, 8);
        for _ in 0..50 {
            add(&mut test, 3.0, 1);
            refuse(&mut test, 1);
            assert_eq!(test.is_white(), Some(false));
        }
        add(&mut test, 1.0, 32);
        assert_eq!(test.is_white(), Some(true));
    }

    #[test]
    fn isolated_spikes_are_no_transient() {
        let (mut test, mut alone) = (Undisturbed::default(), Whiteness::<f32>::default());
        for k in 0..2000u32 {
            if k % 8 == 0 {
                test.refuse();
            }
            let rate_rad_s = Vec3::repeat(if k / 2 % 2 == 0 { 1.2 } else { -1.2 });
            let innovation = Innovation { rate_rad_s, variance_rad2_s2: Vec3::repeat(1.0) };
            test.add(&innovation, 1.0, 0.0);
            alone.add(&innovation, 1.0, 0.0);
            assert_eq!(test.is_white(), alone.is_white(), "{k}");
        }
        assert_eq!(test.is_white(), Some(false));
    }

    /// Errors in a third of all innovations, and spikes with them: once 512 are left out the test has them.
    #[test]
    fn transients_that_recur_are_no_longer_left_out() {
        let mut test = Undisturbed::default();
        let mut white = [None; 30];
        for white in &mut white {
            add(&mut test, 1.0, 100);
            *white = test.is_white();
            add(&mut test, 2.0, 20);
            refuse(&mut test, 10);
            add(&mut test, 2.0, 30);
        }
        assert_eq!(white[..3], [Some(true); 3]);
        assert_eq!(white[27..], [Some(false); 3]);
    }

    /// Exactly the spikes that make a transient: the test has its state before the onset once it is over, and all
    /// innovations before that.
    #[test]
    fn the_shortest_transient_is_left_out_too() {
        let mut test = Undisturbed::default();
        add(&mut test, 1.0, 400);
        add(&mut test, 3.0, 40);
        refuse(&mut test, TRANSIENT);
        assert_eq!(test.is_white(), Some(false));
        add(&mut test, 1.0, 32 - TRANSIENT + 1);
        assert_eq!(test.is_white(), Some(true));
    }

    #[test]
    fn what_is_left_out_is_limited_across_restarts() {
        let mut test = Undisturbed::<f32>::default();
        let mut left_out = 0;
        while left_out < u32::from(LEFT_OUT) {
            refuse(&mut test, TRANSIENT);
            assert!(test.is_disturbed(), "{left_out}");
            add(&mut test, 3.0, 16);
            left_out += 16;
            test.restart();
            assert_eq!(test, Undisturbed { left_out: left_out as u16, ..Undisturbed::default() });
        }
        refuse(&mut test, TRANSIENT);
        assert!(!test.is_disturbed());
    }
}
