//! Gyro noise of the synthetic flights, reproducible.

/// Xorshift generator of 32 bits (Marsaglia, J. Stat. Softw. 8(14), 2003).
pub struct Noise {
    state: u32,
}

impl Noise {
    /// The generator at its fixed seed.
    pub fn new() -> Self {
        Self { state: 2_463_534_242 } // Marsaglia's seed
    }

    fn uniform(&mut self) -> f32 {
        self.state ^= self.state << 13;
        self.state ^= self.state >> 17;
        self.state ^= self.state << 5;
        self.state as f32 / u32::MAX as f32
    }

    /// Approximately normal number of zero mean and unit variance: the sum of twelve uniform numbers,
    /// minus six.
    pub fn standard(&mut self) -> f32 {
        (0..12).map(|_| self.uniform()).sum::<f32>() - 6.0
    }
}
