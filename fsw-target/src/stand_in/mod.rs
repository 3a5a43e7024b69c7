//! Sensors from elsewhere: a recorded flight, or a board at the far end of a serial line.

pub mod recording;
pub mod replay;
pub mod tunnel;
