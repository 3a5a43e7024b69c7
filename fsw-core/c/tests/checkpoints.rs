//! State words by call-back: a restored estimator continues bit for bit, and invalid words are refused.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]
#![allow(unsafe_code, reason = "calls of the C interface")]

mod flights;

use core::ffi::{c_int, c_void};
use flights::{Rows, wheel_slew};
use fsw_core_c::joint_ekf::*;
use fsw_core_c::sizes::*;
use fsw_core_c::window::*;
use fsw_core_c::*;

/// Medium of a fixed length.
struct Medium {
    words: Vec<u32>,
    capacity: usize,
    next: usize,
}

impl Medium {
    fn new(capacity: usize) -> Self {
        Self { words: Vec::new(), capacity, next: 0 }
    }

    fn of(words: Vec<u32>) -> Self {
        Self { capacity: words.len(), words, next: 0 }
    }

    fn context(&mut self) -> *mut c_void {
        (&raw mut *self).cast()
    }
}

unsafe extern "C" fn write(context: *mut c_void, word: u32) -> c_int {
    // SAFETY: the medium that the test passes.
    let medium = unsafe { &mut *context.cast::<Medium>() };
    let has_place = medium.words.len() < medium.capacity;
    if has_place {
        medium.words.push(word);
    }
    has_place.into()
}

unsafe extern "C" fn read(context: *mut c_void, word: *mut u32) -> c_int {
    // SAFETY: the medium that the test passes, and a valid word.
    unsafe {
        let medium = &mut *context.cast::<Medium>();
        let Some(next) = medium.words.get(medium.next) else { return 0 };
        medium.next += 1;
        *word = *next;
    }
    1
}

fn sized<T>() -> T {
    // SAFETY: structs of numbers, and of enums with a variant of zero.
    unsafe {
        let mut value: T = std::mem::zeroed();
        (&raw mut value).cast::<u32>().write(size_of::<T>() as u32);
        value
    }
}

fn window() -> Box<fsw_window> {
    let mut memory = Box::new(fsw_window { memory: [0; FSW_WINDOW_SIZE_U64] });
    let mut config = sized::<fsw_window_config>();
    // SAFETY: valid pointers.
    unsafe {
        assert_eq!(fsw_window_config_defaults(&mut config, 1e-4), fsw_result::Ok);
        config.wheels = flights::pyramid();
        let memory = (&raw mut *memory).cast();
        assert_eq!(fsw_window_init(memory, FSW_WINDOW_SIZE, &config), fsw_result::Ok);
    }
    memory
}

fn fly(window: &mut fsw_window, rows: &Rows) {
    for row in rows {
        // SAFETY: valid pointers.
        let result = unsafe { fsw_window_step(window, &flights::sample(row), &mut sized()) };
        assert_eq!(result, fsw_result::Ok);
    }
}

fn estimate(window: &fsw_window) -> String {
    let mut estimate = sized::<fsw_estimate>();
    // SAFETY: valid pointers.
    assert_eq!(unsafe { fsw_window_estimate(window, &mut estimate) }, fsw_result::Ok);
    format!("{estimate:?}")
}

fn saved(window: &mut fsw_window) -> Vec<u32> {
    let mut medium = Medium::new(FSW_WINDOW_WORDS);
    // SAFETY: valid pointers.
    let result = unsafe { fsw_window_save(window, Some(write), medium.context()) };
    assert_eq!(result, fsw_result::Ok);
    medium.words
}

fn restore(window: &mut fsw_window, words: Vec<u32>) -> fsw_result {
    // SAFETY: valid pointers.
    unsafe { fsw_window_restore(window, Some(read), Medium::of(words).context()) }
}

#[test]
fn a_restored_window_continues_bit_for_bit() {
    let rows = wheel_slew();
    let (mut first, mut second) = (window(), window());
    fly(&mut first, &rows[..300]);
    let words = saved(&mut first);
    assert_eq!(words[0], fsw_window_fingerprint());
    assert_eq!(restore(&mut second, words), fsw_result::Ok);
    fly(&mut first, &rows[300..]);
    fly(&mut second, &rows[300..]);
    assert_eq!(estimate(&first), estimate(&second));
    assert_eq!(saved(&mut first), saved(&mut second));
}

#[test]
fn invalid_words_are_refused_by_code() {
    let mut flown = window();
    fly(&mut flown, &wheel_slew()[..300]);
    let (words, before) = (saved(&mut flown), estimate(&flown));
    let fresh = estimate(&window());

    // Another fingerprint: nothing is written.
    let mut other = words.clone();
    other[0] ^= 1;
    assert_eq!(restore(&mut flown, other), fsw_result::Fingerprint);
    assert_eq!(restore(&mut flown, Vec::new()), fsw_result::Medium);
    assert_eq!(estimate(&flown), before);

    // A medium that ends early, and a number that is not finite: started anew.
    assert_eq!(restore(&mut flown, words[..words.len() - 1].to_vec()), fsw_result::Medium);
    assert_eq!(estimate(&flown), fresh);
    let mut broken = words.clone();
    broken.fill(u32::MAX);
    broken[0] = words[0];
    assert_eq!(restore(&mut flown, broken), fsw_result::State);
    assert_eq!(estimate(&flown), fresh);
    assert_eq!(restore(&mut flown, words), fsw_result::Ok);
    assert_eq!(estimate(&flown), before);
}

#[test]
fn a_full_medium_is_refused_and_the_estimator_flies_on() {
    let mut flown = window();
    fly(&mut flown, &wheel_slew()[..300]);
    let (words, before) = (saved(&mut flown), estimate(&flown));
    let mut medium = Medium::new(words.len() - 1);
    // SAFETY: valid pointers.
    let result = unsafe { fsw_window_save(&mut *flown, Some(write), medium.context()) };
    assert_eq!((result, estimate(&flown)), (fsw_result::Medium, before));
}

/// Storage full of blocks: the longest state of this flight, against the stated bound.
#[test]
fn words_of_a_full_window_are_within_the_stated_number() {
    let mut flown = window();
    let rows = wheel_slew();
    let mut most = 0;
    let length_us = rows.last().unwrap().time_us + 100_000;
    for turn in 0..12 {
        let later: Vec<flights::Row> = rows
            .iter()
            .map(|row| flights::Row { time_us: row.time_us + turn * length_us, ..*row })
            .collect();
        fly(&mut flown, &later);
        most = most.max(saved(&mut flown).len());
    }
    println!("window: {most} of {FSW_WINDOW_WORDS} words");
    assert!(most <= FSW_WINDOW_WORDS);
}

#[test]
fn a_restored_filter_continues_bit_for_bit() {
    let start = || {
        let mut memory = Box::new(fsw_joint_ekf { memory: [0; FSW_JOINT_EKF_SIZE_U64] });
        let mut config = sized::<fsw_joint_ekf_config>();
        // SAFETY: valid pointers.
        unsafe {
            assert_eq!(fsw_joint_ekf_config_defaults(&mut config, 1e-4), fsw_result::Ok);
            config.wheels = flights::pyramid();
            config.hardware.gyro_scale = 0.005;
            let memory = (&raw mut *memory).cast();
            assert_eq!(fsw_joint_ekf_init(memory, FSW_JOINT_EKF_SIZE, &config), fsw_result::Ok);
        }
        memory
    };
    let fly = |filter: &mut fsw_joint_ekf, rows: &[flights::Row]| {
        rows.iter().fold(String::new(), |_, row| {
            let mut outcome = sized::<fsw_outcome>();
            // SAFETY: valid pointers.
            let result = unsafe { fsw_joint_ekf_step(filter, &flights::sample(row), &mut outcome) };
            assert_eq!(result, fsw_result::Ok);
            format!("{outcome:?}")
        })
    };
    let rows = wheel_slew();
    let (mut first, mut second) = (start(), start());
    fly(&mut first, &rows[..300]);
    let mut medium = Medium::new(FSW_JOINT_EKF_WORDS);
    // SAFETY: valid pointers.
    unsafe {
        let result = fsw_joint_ekf_save(&mut *first, Some(write), medium.context());
        assert_eq!(result, fsw_result::Ok);
        println!("joint-ekf: {} of {FSW_JOINT_EKF_WORDS} words", medium.words.len());
        let result = fsw_joint_ekf_restore(&mut *second, Some(read), medium.context());
        assert_eq!(result, fsw_result::Ok);
    }
    let ends = [&mut first, &mut second].map(|filter| fly(filter, &rows[300..]));
    assert_eq!(ends[0], ends[1]);
}
