//! The defmt logger: every frame goes to RTT and to the serial port of the log.
//!
//! RTT never blocks: without a probe its buffer fills, and further frames are dropped. The serial port takes
//! about 87 µs per byte at 115200 baud, with interrupts masked: log at a low rate, from the flight loop
//! at the most frequent.

use super::rtt::{self, UpWriter};
use core::cell::RefCell;
use critical_section::{Mutex, RestoreState};
use defmt::Encoder;

/// Outputs, and the current frame.
struct State {
    encoder: Encoder,
    rtt: UpWriter,
    output: Option<fn(u8)>,
    /// Interrupt mask before the current frame.
    restore: RestoreState,
}

static STATE: Mutex<RefCell<State>> = Mutex::new(RefCell::new(State {
    encoder: Encoder::new(),
    rtt: UpWriter::new(),
    output: None,
    restore: RestoreState::invalid(),
}));

/// Copies the log to `output`, byte by byte, from the next line on. Earlier lines went to RTT only.
pub fn init(output: fn(u8)) {
    with_state(|state| state.output = Some(output));
}

#[defmt::global_logger]
struct GlobalLogger;

// SAFETY: `acquire` masks interrupts until the `release` that defmt pairs with it, and there is one
// core: frames neither mix nor nest.
#[allow(unsafe_code, reason = "a defmt logger is an unsafe trait")]
unsafe impl defmt::Logger for GlobalLogger {
    fn acquire() {
        // SAFETY: `release` restores the state stored here.
        let restore = unsafe { critical_section::acquire() };
        with_state(|state| {
            state.restore = restore;
            state.rtt.begin();
            let State { encoder, rtt, output, .. } = state;
            encoder.start_frame(|bytes| send(rtt, *output, bytes));
        });
    }

    unsafe fn write(bytes: &[u8]) {
        with_state(|State { encoder, rtt, output, .. }| {
            encoder.write(bytes, |bytes| send(rtt, *output, bytes));
        });
    }

    unsafe fn flush() {
        // The serial port is unbuffered, and RTT must not wait for a probe.
    }

    unsafe fn release() {
        let mut restore = RestoreState::invalid();
        with_state(|state| {
            let State { encoder, rtt, output, .. } = state;
            encoder.end_frame(|bytes| send(rtt, *output, bytes));
            state.rtt.commit(&rtt::CONTROL_BLOCK);
            restore = state.restore;
        });
        // SAFETY: `restore` is the state of the `acquire` of this frame.
        unsafe { critical_section::release(restore) };
    }
}

fn send(rtt: &mut UpWriter, output: Option<fn(u8)>, bytes: &[u8]) {
    for &byte in bytes {
        rtt.push(&rtt::CONTROL_BLOCK, &rtt::BUFFER, byte);
        if let Some(output) = output {
            output(byte);
        }
    }
}

/// Runs `work` on the state, which is free at every call of defmt. After a fault inside this file the line is
/// lost, without a second failure.
fn with_state(work: impl FnOnce(&mut State)) {
    critical_section::with(|section| {
        if let Ok(mut state) = STATE.borrow(section).try_borrow_mut() {
            work(&mut state);
        }
    });
}
