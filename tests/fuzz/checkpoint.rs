//! Checkpoints: words of a real one, some of them changed, and words of any content.

use fsw_core::checkpoint::{FromWords, Persist, ToWords, transfer};
use fsw_core::estimator::Estimator;
use fsw_core::hardware::Disturbance;
use fsw_target::flight::craft::WHEELS;
use rand::RngExt;
use rand_pcg::Pcg64;

use super::step::{Case, Filter, Regression, SmallWindow};
use super::{Executed, numbers, once_in, one_of};

/// Words that hold any of the estimators.
const WORDS: usize = 16_384;

/// Restores an estimator, and flies on where the words are accepted.
pub fn execute(random: &mut Pcg64) -> Executed {
    let case = Case::new(random);
    let Some(wheels) = case.wheels(random) else { return Ok(0) };
    match random.random_range(0..3) {
        0 => match SmallWindow::new(case.window(random), wheels) {
            Ok(window) => restore(&case, random, window),
            Err(_) => Ok(0),
        },
        1 => match Regression::new(case.regression(random), wheels) {
            Ok(regression) => restore(&case, random, regression),
            Err(_) => Ok(0),
        },
        _ => {
            let (config, hardware) = (case.filter(random), case.hardware(random));
            match Filter::considering(config, wheels, &hardware, &Disturbance::none()) {
                Ok(filter) => restore(&case, random, filter),
                Err(_) => Ok(0),
            }
        }
    }
}

/// Saves an estimator in flight, changes its words, restores it, and flies on without a judgement of numbers: words
/// that were changed are any state. A panic is the finding.
fn restore<E>(case: &Case, random: &mut Pcg64, mut estimator: E) -> Executed
where
    E: Estimator<f32, WHEELS> + Persist,
{
    if random.random::<bool>() {
        // An error in flight is a finding of the target `step`, and not of this one.
        let _ = case.fly(random, &mut estimator);
    }
    let mut words = vec![0; WORDS];
    let mut medium = ToWords::new(&mut words);
    // A rejected state decides nothing: rates of tens of rad/s at 1 Hz, which alias, leave numbers in a fit that are not
    // finite until it is replaced. The flight computer counts a checkpoint that is not saved.
    if transfer(&mut estimator, &mut medium).is_err() {
        return Ok(0);
    }
    let length = medium.written();
    words.truncate(length);
    change(random, &mut words);
    if transfer(&mut estimator, &mut FromWords::new(&words)).is_ok() {
        let _ = case.fly(random, &mut estimator);
    }
    Ok(1)
}

fn change(random: &mut Pcg64, words: &mut Vec<u32>) {
    for _ in 0..one_of(random, &[0, 1, 1, 2, 8, 100]) {
        let at = random.random_range(0..words.len());
        words[at] = match random.random_range(0..4) {
            0 => words[at] ^ (1 << random.random_range(0..32)),
            1 => random.random(),
            2 => random.random_range(0..8),
            _ => numbers::extreme(random).to_bits(),
        };
    }
    if once_in(random, 10) {
        words.truncate(random.random_range(0..words.len()));
    }
}
