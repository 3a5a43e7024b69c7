//! The known name most like a mistyped one.

/// The member of `known` most like `name`, or nothing if `known` is empty.
pub(super) fn nearest<'a, S: AsRef<str>>(name: &str, known: &'a [S]) -> Option<&'a str> {
    known
        .iter()
        .map(AsRef::as_ref)
        .max_by(|left, right| likeness(name, left).total_cmp(&likeness(name, right)))
}

/// Jaro-Winkler similarity, 0 to 1, and one more if one name is part of the other.
///
/// Most mistakes in our names are parts left out (`noise` for `noise_rad_s`, `bias` for
/// `gyro_bias`), which no measure of letters changed finds.
pub(super) fn likeness(left: &str, right: &str) -> f64 {
    let (left, right) = (left.to_lowercase(), right.to_lowercase());
    let is_part = left.contains(&right) || right.contains(&left);
    strsim::jaro_winkler(&left, &right) + f64::from(is_part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn part_of_a_name_finds_the_whole() {
        let known = ["axis", "spin_inertia_kg_m2", "speed_rad_s"];
        assert_eq!(nearest("spin_inertia", &known), Some("spin_inertia_kg_m2"));
        assert_eq!(nearest("Axes", &known), Some("axis"));
        let known = ["torque_n_m", "gyro_bias"];
        assert_eq!(nearest("bias", &known), Some("gyro_bias"));
    }

    #[test]
    fn nothing_known_gives_nothing() {
        assert_eq!(nearest::<&str>("axis", &[]), None);
    }
}
