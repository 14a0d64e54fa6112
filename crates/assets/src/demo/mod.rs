//! Procedural demo scenes. They have the same numbers on every machine and need no file.

mod arbor;
mod cutouts;
mod lathe;
mod stage;
mod vases;

use crate::AssetFault;
use crate::LoadedScene;
use crate::fault::excerpt;
use crate::limits::MAX_MESSAGE_CHARS;

/// Names of the demo scenes, as [`demo`] takes them, each with a description for people.
pub const DEMO_NAMES: &[(&str, &str)] = &[
    ("vases", "two glazed vases on a table under a bent key light, after the paper's Tabletop Vases"),
    ("arbor", "vine leaves, a lattice and a pierced lantern, cut out by alpha, under a bent key light"),
];

/// Builds the demo scene called `name`, or returns `None` if [`DEMO_NAMES`] has no such name.
///
/// The unit is metres, +Y is up, the floor or table is at y = 0. The scene has a camera called `camera` and a
/// BendyLight called `key`.
pub fn demo(name: &str) -> Option<LoadedScene> {
    versioned(name).map(|(_, make)| LoadedScene { name: Some(format!("demo:{name}")), ..make() })
}

/// Returns the bytes that identify the demo scene called `name`: a line with its name and version, which
/// [`crate::load_bytes`] accepts.
pub fn demo_bytes(name: &str) -> Option<Vec<u8>> {
    versioned(name).map(|(version, _)| format!("{LINE_START}{name} {version}\n").into_bytes())
}

/// Returns the demo scene that `bytes` identify, or `None` if they are another kind of file.
pub fn demo_from_bytes(bytes: &[u8]) -> Option<Result<LoadedScene, AssetFault>> {
    let named = bytes.strip_prefix(LINE_START.as_bytes())?;
    let found = DEMO_NAMES.iter().find(|(name, _)| demo_bytes(name).as_deref() == Some(bytes));
    let unknown = || AssetFault::UnknownDemo(excerpt(String::from_utf8_lossy(named).trim_end(), MAX_MESSAGE_CHARS));
    Some(found.and_then(|(name, _)| demo(name)).ok_or_else(unknown))
}

/// Start of the line that identifies a demo scene.
const LINE_START: &str = "bendylights demo ";

/// Returns the version of the demo scene called `name`, and its function.
fn versioned(name: &str) -> Option<(u32, fn() -> LoadedScene)> {
    match name {
        "vases" => Some((vases::VERSION, vases::vases)),
        "arbor" => Some((arbor::VERSION, arbor::arbor)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use document::SceneContents;
    use light::Tube;
    use scene::Scene;
    use sha2::{Digest, Sha256};

    use super::*;

    #[test]
    fn every_name_has_a_sound_scene() {
        for (name, _) in DEMO_NAMES {
            demo(name).unwrap().scene.check().unwrap();
        }
        assert!(demo("no such scene").is_none());
    }

    /// The tubes fulfil `R kappa < 1` everywhere (light model, section 3), that of the vases with a margin for edits.
    #[test]
    fn key_lights_do_not_fold() {
        for (name, limit) in [("vases", 0.9), ("arbor", 1.0)] {
            let light = demo(name).unwrap().contents.lights[0].light().clone();
            assert_eq!(light.points().len(), 5, "{name}: three segments");
            let r_kappa = Tube::new(&light).unwrap().r_kappa_max().into_iter().fold(0.0, f64::max);
            assert!(r_kappa < limit, "{name}: {r_kappa}");
            let wide = light.map_points(|_, point| point.radius *= 2.0);
            assert!(Tube::new(&wide).is_err(), "{name}: a tube twice as wide folds");
        }
    }

    /// Computes SHA-256 over the text of a whole demo scene. The shortest decimals identify a float to its last
    /// bit.
    fn digest(demo: &LoadedScene) -> String {
        let Scene { nodes, meshes, materials, images, fill } = &demo.scene;
        let SceneContents { lights, cameras } = &demo.contents;
        let lights: Vec<_> = lights.iter().map(|light| light.digest()).collect();
        let text = format!("{nodes:?} {meshes:?} {materials:?} {cameras:?} {lights:?} {fill:?}");
        // The debug text of a picture has no pixels.
        let pixels = images.iter().flat_map(|image| &image.rgba8).copied();
        let hash = Sha256::digest(text.into_bytes().into_iter().chain(pixels).collect::<Vec<_>>());
        const_hex::const_encode::<32, false>(&hash.into()).as_str().into()
    }

    /// Logs refer to a demo by its version. If this test fails because the scene changed, raise its version. If
    /// only names of Rust fields changed, do not. Then insert the new digest.
    #[test]
    fn a_version_names_one_scene() {
        let digests = [
            ("vases", 1, "6124a620eabd978e8e1e142f95b321c02272591017644ef74e7c0e12b3943857"),
            ("arbor", 1, "140d387a2709ae2ca61098ef75e2c2e0273ffb9468eb40b414d560a78428d656"),
        ];
        for ((name, version, expected), (listed, _)) in digests.into_iter().zip(DEMO_NAMES) {
            assert_eq!(name, *listed);
            assert_eq!(demo_bytes(name).unwrap(), format!("bendylights demo {name} {version}\n").as_bytes());
            assert_eq!(digest(&demo(name).unwrap()), expected, "{name}");
        }
        assert_eq!(digests.len(), DEMO_NAMES.len());
        // Deliberate fault that the check must detect: one vertex is off by one ulp.
        let mut moved = demo("vases").unwrap();
        let x = &mut moved.scene.meshes[0].primitives[0].positions[0].x;
        *x = x.next_up();
        assert_ne!(digest(&moved), digests[0].2);
    }
}
