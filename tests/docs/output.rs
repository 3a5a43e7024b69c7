//! Comparison of a printed output with that of a page: words equal, numbers close.

/// Relative tolerance of a number: the last digit of two that are printed.
const RELATIVE: f64 = 0.01;
/// Absolute tolerance: a few roundings of a single-precision inertia of 20 kg m², 2e-6 each, where
/// another machine's mathematical functions round differently.
const ABSOLUTE: f64 = 1e-5;

/// Compares line by line and word by word. A line `…` of the page stands for any lines.
pub fn compare(page: &str, printed: &str) -> Result<(), String> {
    let mut printed = printed.lines();
    let mut is_skipping = false;
    for expected in page.lines() {
        if expected.trim() == "…" {
            is_skipping = true;
            continue;
        }
        let found = if is_skipping {
            printed.find(|line| is_close(expected, line))
        } else {
            printed.next()
        };
        is_skipping = false;
        match found {
            Some(line) if is_close(expected, line) => {}
            Some(line) => return Err(format!("\n  page    {expected}\n  printed {line}")),
            None => return Err(format!("`{expected}` is not printed")),
        }
    }
    match printed.find(|line| !is_skipping && !line.trim().is_empty()) {
        Some(line) => Err(format!("`{line}` is printed, but not in the page")),
        None => Ok(()),
    }
}

fn is_close(expected: &str, printed: &str) -> bool {
    let words = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let (expected, printed) = (words(expected), words(printed));
    expected.len() == printed.len()
        && expected.iter().zip(&printed).all(|(a, b)| is_close_word(a, b))
}

fn is_close_word(expected: &str, printed: &str) -> bool {
    match (expected.parse::<f64>(), printed.parse::<f64>()) {
        (Ok(a), Ok(b)) => {
            (a - b).abs() <= ABSOLUTE + RELATIVE * a.abs() + unit_of_last_digit(expected)
        }
        _ => expected == printed,
    }
}

/// One unit in the last place of a decimal without an exponent; zero with one.
fn unit_of_last_digit(number: &str) -> f64 {
    let decimals = number.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    if number.contains('e') { 0.0 } else { 0.1_f64.powi(decimals as i32) }
}

#[test]
fn numbers_are_compared_as_numbers() {
    assert_eq!(compare("a 1.00 b\n…\nz", "a  1.01 b\nx\ny\nz\n"), Ok(()));
    assert!(compare("a 1.00", "a 1.03").is_err());
    assert!(compare("a 1.00", "b 1.00").is_err());
    assert!(compare("a", "a\nb").is_err());
    assert!(compare("a\nb", "a").is_err());
}
