//! Reports in a headless browser: every plot painted, read out and zoomed, at the width of a phone and of a desk, light
//! and dark, without an error and without a request.
//!
//! Skipped with a message where no Chromium is installed.

#[cfg(test)]
mod browser;
#[cfg(test)]
mod pages;
