//! The built-in scenarios, by name.

/// The scenario of `run` without an argument.
pub const DEFAULT_SCENARIO: &str = "stsat3-spin-up";

/// The scenario of `faults` without an argument.
pub const FAULTS_SCENARIO: &str = "fault-matrix";

const BUILT_IN: [(&str, &str); 35] = [
    (DEFAULT_SCENARIO, include_str!("../../../scenarios/stsat3-spin-up.toml")),
    (
        "stsat3-spin-up-wrong-prior",
        include_str!("../../../scenarios/stsat3-spin-up-wrong-prior.toml"),
    ),
    (
        "stsat3-spin-up-overconfident-prior",
        include_str!("../../../scenarios/stsat3-spin-up-overconfident-prior.toml"),
    ),
    ("cubesat-pyramid", include_str!("../../../scenarios/cubesat-pyramid.toml")),
    (
        "cubesat-pyramid-disturbed",
        include_str!("../../../scenarios/cubesat-pyramid-disturbed.toml"),
    ),
    ("kim-2010-slew", include_str!("../../../scenarios/kim-2010-slew.toml")),
    ("microsat-slew", include_str!("../../../scenarios/microsat-slew.toml")),
    ("random-spacecraft", include_str!("../../../scenarios/random-spacecraft.toml")),
    (
        "cubesat-pyramid-data-sheet",
        include_str!("../../../scenarios/cubesat-pyramid-data-sheet.toml"),
    ),
    ("microsat-slew-data-sheet", include_str!("../../../scenarios/microsat-slew-data-sheet.toml")),
    (
        "stsat3-spin-up-data-sheet",
        include_str!("../../../scenarios/stsat3-spin-up-data-sheet.toml"),
    ),
    (
        "random-spacecraft-data-sheet",
        include_str!("../../../scenarios/random-spacecraft-data-sheet.toml"),
    ),
    (FAULTS_SCENARIO, include_str!("../../../scenarios/fault-matrix.toml")),
    ("deployment", include_str!("../../../scenarios/deployment.toml")),
    ("break-off", include_str!("../../../scenarios/break-off.toml")),
    ("no-change", include_str!("../../../scenarios/no-change.toml")),
    ("fuel-burn", include_str!("../../../scenarios/fuel-burn.toml")),
    ("bellar-2019", include_str!("../../../scenarios/bellar-2019.toml")),
    ("bellar-2019-campaign", include_str!("../../../scenarios/bellar-2019-campaign.toml")),
    ("kim-2013", include_str!("../../../scenarios/kim-2013.toml")),
    ("kim-2016", include_str!("../../../scenarios/kim-2016.toml")),
    ("elhariry-2026-constant", include_str!("../../../scenarios/elhariry-2026-constant.toml")),
    ("elhariry-2026-sine-x", include_str!("../../../scenarios/elhariry-2026-sine-x.toml")),
    (
        "elhariry-2026-sine-3axis-same",
        include_str!("../../../scenarios/elhariry-2026-sine-3axis-same.toml"),
    ),
    (
        "elhariry-2026-sine-iso-0.005",
        include_str!("../../../scenarios/elhariry-2026-sine-iso-0.005.toml"),
    ),
    (
        "elhariry-2026-sine-iso-0.02",
        include_str!("../../../scenarios/elhariry-2026-sine-iso-0.02.toml"),
    ),
    (
        "elhariry-2026-sine-iso-0.08",
        include_str!("../../../scenarios/elhariry-2026-sine-iso-0.08.toml"),
    ),
    (
        "elhariry-2026-sine-iso-0.2",
        include_str!("../../../scenarios/elhariry-2026-sine-iso-0.2.toml"),
    ),
    (
        "elhariry-2026-sine-multifreq",
        include_str!("../../../scenarios/elhariry-2026-sine-multifreq.toml"),
    ),
    ("elhariry-2026-chirp", include_str!("../../../scenarios/elhariry-2026-chirp.toml")),
    ("elhariry-2026-prbs-a", include_str!("../../../scenarios/elhariry-2026-prbs-a.toml")),
    ("elhariry-2026-prbs-b", include_str!("../../../scenarios/elhariry-2026-prbs-b.toml")),
    ("elhariry-2026-random-a", include_str!("../../../scenarios/elhariry-2026-random-a.toml")),
    ("elhariry-2026-random-b", include_str!("../../../scenarios/elhariry-2026-random-b.toml")),
    ("elhariry-2026-random-c", include_str!("../../../scenarios/elhariry-2026-random-c.toml")),
];

/// The names of the built-in scenarios, the default first.
pub fn built_in_names() -> impl Iterator<Item = &'static str> {
    BUILT_IN.iter().map(|(name, _)| *name)
}

/// The first sentence of the comment above a built-in scenario.
pub fn built_in_summary(name: &str) -> String {
    let text = text(name).unwrap_or_default();
    let comment = text.lines().map_while(|line| line.strip_prefix('#'));
    let comment = comment.map(str::trim).collect::<Vec<_>>().join(" ");
    comment.split_once(". ").map_or(comment.clone(), |(first, _)| first.to_owned())
}

/// The text of a built-in scenario.
pub(super) fn text(wanted: &str) -> Option<&'static str> {
    BUILT_IN.iter().find(|(name, _)| *name == wanted).map(|(_, text)| *text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::Scenario;

    #[test]
    fn every_built_in_scenario_loads_under_its_name() {
        for name in built_in_names() {
            assert_eq!(Scenario::load(name).unwrap().name, name);
        }
    }

    #[test]
    fn every_built_in_scenario_has_a_summary() {
        for name in built_in_names() {
            assert!((10..250).contains(&built_in_summary(name).len()), "{name}");
        }
    }

    #[test]
    fn no_change_is_deployment_without_its_change() {
        let load = |name| Scenario::load(name).unwrap();
        let (name, changes) = (load("no-change").name, load("no-change").changes);
        assert_eq!(Scenario { name, changes, ..load("deployment") }, load("no-change"));
    }

    #[test]
    fn wrong_priors_are_wrong_by_half_with_wide_and_narrow_sigma() {
        let truth = Scenario::load(DEFAULT_SCENARIO).unwrap();
        for (name, sigmas_off) in [
            ("stsat3-spin-up-wrong-prior", 1.0),
            ("stsat3-spin-up-overconfident-prior", 20.0 / 3.0),
        ] {
            let scenario = Scenario::load(name).unwrap();
            let prior = scenario.prior.clone().unwrap();
            for i in 0..6 {
                let error = prior.inertia_kg_m2[i] - truth.spacecraft.inertia_kg_m2[i];
                let expected = if i < 3 { 0.5 * truth.spacecraft.inertia_kg_m2[i] } else { 0.43 };
                assert!((error / expected - 1.0).abs() < 0.02, "{name}, element {i}");
                let sigmas = error / prior.sigma_kg_m2[i];
                assert!((sigmas / sigmas_off - 1.0).abs() < 0.02, "{name}, element {i}: {sigmas}");
            }
            let (name, prior) = (truth.name.clone(), truth.prior.clone());
            assert_eq!(Scenario { name, prior, ..scenario }, truth, "only the prior differs");
        }
    }

    #[test]
    fn default_is_the_spin_up_of_the_papers() {
        let scenario = Scenario::load(DEFAULT_SCENARIO).unwrap();
        assert_eq!(scenario.duration_s * scenario.gyro.rate_hz, 6000.0);
        assert_eq!(scenario.spacecraft.inertia_kg_m2, [14.2, 17.3, 20.3, 0.0867, 0.1357, 0.6016]);
        assert_eq!(scenario.torque.at(300.0).as_slice(), [1e-3, 1e-3, -2e-3]);
        let gyro_deg_s = scenario.gyro.noise_rad_s.to_degrees();
        assert!((gyro_deg_s - 0.0104).abs() < 1e-6);
    }
}
