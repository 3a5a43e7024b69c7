//! Waits with a bound: a register that never changes stops no image.

/// Polls `done` up to `polls` times; `None` if it stays false.
pub fn wait(polls: u32, mut done: impl FnMut() -> bool) -> Option<()> {
    for _ in 0..polls {
        if done() {
            return Some(());
        }
    }
    None
}

/// Polls `done` for up to `limit_us` of the wrapping microsecond counter `count_us`; `None` if it stays false.
///
/// With a stopped counter the wait ends after `limit_us` times `polls_per_us`. One poll takes several cycles: the cycles of
/// the core in a microsecond are enough.
pub fn wait_at_most(
    limit_us: u32,
    polls_per_us: u32,
    count_us: impl Fn() -> u32,
    mut done: impl FnMut() -> bool,
) -> Option<()> {
    let start = count_us();
    let mut in_time = None;
    wait(limit_us.saturating_mul(polls_per_us), || {
        if done() {
            in_time = Some(());
        }
        in_time.is_some() || count_us().wrapping_sub(start) >= limit_us
    });
    in_time
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::cell::Cell;

    #[test]
    fn wait_ends_with_its_condition_or_its_polls() {
        let polls = Cell::new(0);
        let third = || {
            polls.set(polls.get() + 1);
            polls.get() == 3
        };
        assert_eq!(wait(10, third), Some(()));
        assert_eq!(wait(10, || false), None);
    }

    #[test]
    fn timed_wait_ends_by_its_condition_its_counter_or_its_polls() {
        let count = Cell::new(u32::MAX - 5); // wraps during the wait
        let running = || {
            count.set(count.get().wrapping_add(1));
            count.get()
        };
        assert_eq!(wait_at_most(100, 50, running, || count.get() == 7), Some(()));
        assert_eq!(wait_at_most(100, 50, running, || false), None);
        assert_eq!(wait_at_most(100, 50, || 0, || false), None, "a stopped counter");
    }
}
