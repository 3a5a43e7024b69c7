//! Vertical scale of a panel, linear or logarithmic.

use std::ops::Range;

/// Map from values to heights.
pub(super) struct Scale {
    /// Lower and upper end. Powers of ten on a logarithmic scale.
    pub range: Range<f64>,
    /// True if heights are decimal logarithms.
    pub is_logarithmic: bool,
}

impl Scale {
    /// Height of a value.
    pub fn height(&self, value: f64) -> f64 {
        match self.is_logarithmic {
            // A value without a logarithm lies below any scale.
            true => value.max(f64::MIN_POSITIVE).log10(),
            false => value,
        }
    }

    /// Height of a value, limited to the range.
    pub fn height_inside(&self, value: f64) -> f64 {
        self.height(value).clamp(self.range.start, self.range.end)
    }
}
