//! The flight computer on simulated parts, commanded by a simulated ground station.

mod manoeuvre;
mod operation;
mod security;
mod start;
mod upsets;
mod world;
