//! Panic handlers of the language and of defmt.

use super::{Failure, Kind, end_image};
use core::panic::PanicInfo;

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    // The location identifies the panic; its message would link all of core::fmt.
    let (at, from) = match info.location() {
        Some(place) => {
            defmt::error!("panicked at {=str}:{=u32}", place.file(), place.line());
            (place.line(), place.file().as_ptr() as u32)
        }
        None => {
            defmt::error!("panicked");
            (0, 0)
        }
    };
    end_image(Failure { kind: Kind::Panic, at, from })
}

/// End of `defmt::panic!` and similar macros, which have logged. Without this handler defmt links a panic
/// of `core`, the only one in an image that has no other (its feature `avoid-default-panic` removes
/// that link).
#[defmt::panic_handler]
fn defmt_panic() -> ! {
    end_image(Failure { kind: Kind::Panic, at: 0, from: 0 })
}
