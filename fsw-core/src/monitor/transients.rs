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
//! | begins | the test goes back to an earlier state: without the last 96 to 192 that entered | `false` |
//! | goes on | left out | `false` |
//! | for longer than is allowed | enters the test | as the test says |
//!
//! Eight spikes take up to 32 samples. White noise has one spike in 10⁴ samples; isolated ones of 10 % are 8 in 32 once in
//! 100.
//!
//! An error of the model causes transients too, and recurs. What may be left out is therefore bounded, onsets included:
//! 512 innovations, an onset and 30 s at 10 Hz, and one for each eight that enter.

use super::innovation::Innovation;
use super::whiteness::Whiteness;
use crate::math::scalar::Real;

/// Spikes of the last 32 innovations that make a transient.
const TRANSIENT: u32 = 8;
/// Innovations that enter the test between two states that are kept.
const BETWEEN: u8 = 96;
/// Innovations that may be left out, and innovations that enter for one more of them.
const LEFT_OUT: u16 = 512;
const FOR_ONE: u8 = 8;

/// Test of the innovations of a filter, without those of transients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Undisturbed<T: Real> {
    test: Whiteness<T>,
    /// Earlier states of the test, the older one first.
    earlier: [Whiteness<T>; 2],
    /// Innovations since the newer of them, and from the older to the newer.
    since: u8,
    between: u8,
    /// Spikes of the last 32 innovations, the newest as the lowest bit.
    spikes: u32,
    left_out: u16,
}

crate::persist!([T: Real] Undisturbed<T> { test, earlier, since, between, spikes, left_out });

impl<T: Real> Default for Undisturbed<T> {
    fn default() -> Self {
        let test = Whiteness::default();
        Self { test, earlier: [test; 2], since: 0, between: 0, spikes: 0, left_out: 0 }
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
        if self.since >= BETWEEN {
            self.keep();
        }
    }

    /// Notes a spike.
    pub fn refuse(&mut self) {
        let was_disturbed = self.is_disturbed();
        self.spikes = self.spikes << 1 | 1;
        if !was_disturbed && self.is_disturbed() {
            self.go_back();
        }
    }

    /// Leaves out the onset of a transient.
    #[inline(never)]
    fn go_back(&mut self) {
        let [older, newer] = &mut self.earlier;
        self.test = *older;
        *newer = *older;
        let onset = u16::from(self.since) + u16::from(self.between);
        self.left_out = self.left_out.saturating_add(onset);
        (self.since, self.between) = (0, 0);
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

    /// Keeps the present state of the test.
    #[inline(never)]
    fn keep(&mut self) {
        let [older, newer] = &mut self.earlier;
        *older = *newer;
        *newer = self.test;
        (self.since, self.between) = (0, self.since);
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

    /// Errors in a third of all innovations, and refusals with them: from the fourth transient on the test has them.
    #[test]
    fn transients_that_recur_are_no_longer_left_out() {
        let mut test = Undisturbed::default();
        let mut white = [None; 8];
        for white in &mut white {
            add(&mut test, 1.0, 100);
            *white = test.is_white();
            add(&mut test, 2.0, 20);
            refuse(&mut test, 10);
            add(&mut test, 2.0, 30);
        }
        assert_eq!(white[..3], [Some(true); 3]);
        assert_eq!(white[5..], [Some(false); 3]);
    }
}
