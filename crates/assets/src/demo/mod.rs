//! Scenes made by the program itself: the same numbers on every machine, and no file needed.

mod lathe;
mod stage;
mod vases;

use scene::Scene;

/// The demo scenes: the name that [`demo`] takes, and what a person sees.
pub const DEMO_NAMES: &[(&str, &str)] =
    &[("vases", "two glazed vases on a table under a bent key light, after the paper's Tabletop Vases")];

/// The demo scene called `name`, or `None` where [`DEMO_NAMES`] has no such name.
///
/// Metres, +Y up, the table at y = 0. It has a camera called `camera` and a BendyLight called `key`.
pub fn demo(name: &str) -> Option<Scene> {
    match name {
        "vases" => Some(vases::vases()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_has_a_sound_scene() {
        for (name, _) in DEMO_NAMES {
            demo(name).unwrap().check().unwrap();
        }
        assert!(demo("no such scene").is_none());
    }
}
