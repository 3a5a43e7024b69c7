//! Mutations of text files: tokens, lines, bytes.

use rand::RngExt;
use rand_pcg::Pcg64;

use super::one_of;

/// Values in place of a number or a word.
const TOKENS: [&str; 28] = [
    "0",
    "-0.0",
    "1",
    "-1",
    "1e5",
    "-1e5",
    "1e-30",
    "1e30",
    "1e308",
    "1e400",
    "-1e400",
    "nan",
    "NaN",
    "inf",
    "-inf",
    "0x10",
    "1_000",
    "1,5",
    "true",
    "\"\"",
    "\"x\"",
    "[]",
    "{}",
    "[[1.0]]",
    "18446744073709551616",
    "\u{feff}",
    "\0",
    "9999-12-31T23:59:59.999Z",
];

/// The text with one to twenty changes.
pub fn mutate(random: &mut Pcg64, seed: &str) -> Vec<u8> {
    let mut text = seed.to_owned();
    for _ in 0..one_of(random, &[1, 1, 2, 3, 5, 20]) {
        text = match random.random_range(0..6) {
            0 | 1 => with_token(random, &text),
            2 | 3 => with_lines(random, &text),
            4 => with_key_of_another(random, &text),
            _ => with_bytes(random, &text),
        };
    }
    text.into_bytes()
}

/// One word or number replaced.
fn with_token(random: &mut Pcg64, text: &str) -> String {
    let is_token = |c: char| c.is_alphanumeric() || matches!(c, '.' | '-' | '_' | '+');
    let mut starts = Vec::new();
    let mut before = false;
    for (at, letter) in text.char_indices() {
        if is_token(letter) && !before {
            starts.push(at);
        }
        before = is_token(letter);
    }
    if starts.is_empty() {
        return text.to_owned();
    }
    let start = one_of(random, &starts);
    let length = text[start..].find(|c| !is_token(c)).unwrap_or(text.len() - start);
    let token = one_of(random, &TOKENS);
    format!("{}{token}{}", &text[..start], &text[start + length..])
}

/// A line removed, repeated or moved.
fn with_lines(random: &mut Pcg64, text: &str) -> String {
    let mut lines: Vec<&str> = text.split('\n').collect();
    let at = random.random_range(0..lines.len());
    let line = lines[at];
    match random.random_range(0..3) {
        0 => drop(lines.remove(at)),
        1 => lines.insert(random.random_range(0..=lines.len()), line),
        _ => {
            lines.remove(at);
            lines.insert(random.random_range(0..=lines.len()), line);
        }
    }
    lines.join("\n")
}

/// The value of one line under the key of another one.
fn with_key_of_another(random: &mut Pcg64, text: &str) -> String {
    let pairs: Vec<(&str, &str)> = text.lines().filter_map(|line| line.split_once('=')).collect();
    if pairs.is_empty() {
        return text.to_owned();
    }
    let ((key, _), (_, value)) = (one_of(random, &pairs), one_of(random, &pairs));
    format!("{key}={value}\n{text}")
}

/// A character replaced, inserted or removed.
fn with_bytes(random: &mut Pcg64, text: &str) -> String {
    let mut letters: Vec<char> = text.chars().collect();
    let letter = char::from(random.random::<u8>());
    let at = random.random_range(0..=letters.len());
    match random.random_range(0..3) {
        0 => letters.insert(at, letter),
        _ if at == letters.len() => {}
        1 => letters[at] = letter,
        _ => drop(letters.remove(at)),
    }
    letters.into_iter().collect()
}
