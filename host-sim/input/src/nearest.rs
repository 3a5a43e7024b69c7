//! The known name most similar to a mistyped one.

/// Least likeness of a suggestion. Mistyped names have 0.85 and more, unrelated ones mostly below 0.6.
const PLAUSIBLE: f64 = 0.75;
/// Shortest part of a name that matches the whole, characters.
const SHORTEST_PART: usize = 3;

/// The member of `known` most similar to `name`; none if no member is plausible.
pub fn nearest<'a, S: AsRef<str>>(name: &str, known: &'a [S]) -> Option<&'a str> {
    known
        .iter()
        .map(AsRef::as_ref)
        .filter(|known| likeness(name, known) >= PLAUSIBLE)
        .max_by(|left, right| likeness(name, left).total_cmp(&likeness(name, right)))
}

/// Jaro-Winkler similarity, 0 to 1, plus 1 if one name is part of the other.
///
/// The most frequent mistake is an omitted part (`noise` for `noise_rad_s`, `bias` for
/// `gyro_bias`), which an edit distance does not find.
pub fn likeness(left: &str, right: &str) -> f64 {
    let (left, right) = (left.to_lowercase(), right.to_lowercase());
    let shorter = left.chars().count().min(right.chars().count());
    let is_part = shorter >= SHORTEST_PART && (left.contains(&right) || right.contains(&left));
    strsim::jaro_winkler(&left, &right) + f64::from(is_part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn part_of_a_name_matches_the_whole() {
        let known = ["axis", "spin_inertia_kg_m2", "speed_rad_s"];
        assert_eq!(nearest("spin_inertia", &known), Some("spin_inertia_kg_m2"));
        assert_eq!(nearest("Axes", &known), Some("axis"));
        let known = ["torque_n_m", "gyro_bias"];
        assert_eq!(nearest("bias", &known), Some("gyro_bias"));
    }

    #[test]
    fn implausible_names_are_not_suggested() {
        let known = ["wheel", "wheels", "gyro", "torque", "prior", "filter", "disturbance"];
        for (name, expected) in [
            ("wheeel", Some("wheel")),
            ("gyros", Some("gyro")),
            ("torqe", Some("torque")),
            ("xyzzy", None),
            ("r", None),
            ("magnetometer", None),
        ] {
            assert_eq!(nearest(name, &known), expected, "{name}");
        }
    }

    #[test]
    fn no_known_name_gives_none() {
        assert_eq!(nearest::<&str>("axis", &[]), None);
    }
}
