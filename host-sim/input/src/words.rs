//! Lists and numbers as error messages print them.

/// The names, separated by commas.
pub fn list<S: AsRef<str>>(names: &[S]) -> String {
    names.iter().map(AsRef::as_ref).collect::<Vec<_>>().join(", ")
}

/// `[1, 2, 3]`, each number with at most four significant digits.
pub fn numbers(values: &[f64]) -> String {
    let texts: Vec<String> = values.iter().map(|value| short(*value)).collect();
    format!("[{}]", texts.join(", "))
}

/// ` (did you mean …?)`, or nothing.
pub fn suggestion(nearest: Option<&str>) -> String {
    nearest.map_or(String::new(), |name| format!(" (did you mean `{name}`?)"))
}

/// Four significant digits hide the rounding errors of eigenvalues; an exponent appears only below
/// 1e-3 and from 1e6.
pub fn short(value: f64) -> String {
    let rounded = format!("{value:.3e}").parse().unwrap_or(value);
    if rounded != 0.0 && !(1e-3..1e6).contains(&f64::abs(rounded)) {
        format!("{rounded:e}")
    } else {
        format!("{rounded}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_significant_digits() {
        assert_eq!(numbers(&[0.1 + 0.2, -1.0, 1.234_56e-7]), "[0.3, -1, 1.235e-7]");
    }
}
