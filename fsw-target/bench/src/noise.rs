//! Noise for the made-up flights: small, and the same in every run.

/// Marsaglia's xorshift of 32 bits (J. Stat. Softw. 8(14), 2003).
pub struct Noise {
    state: u32,
}

impl Noise {
    /// Always the same sequence.
    pub fn new() -> Self {
        Self { state: 2_463_534_242 } // Marsaglia's seed
    }

    fn uniform(&mut self) -> f32 {
        self.state ^= self.state << 13;
        self.state ^= self.state >> 17;
        self.state ^= self.state << 5;
        self.state as f32 / u32::MAX as f32
    }

    /// Zero mean, unit variance, near enough to normal: the sum of twelve uniform numbers, less six.
    pub fn standard(&mut self) -> f32 {
        (0..12).map(|_| self.uniform()).sum::<f32>() - 6.0
    }
}
