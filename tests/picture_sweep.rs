//! Tests a sample of `bendylights bench sweep`: random lights of each shape with random orientation, over floors of
//! every size, between walls, in rooms and under roofs.

use bench::sweep::{BACKENDS, SHAPES, SceneFile, SweepOptions, SweepReport, SweepRow, sweep};
use render::{Device, Host, Renderer};

use crate::pictures::{renderer_of, shared_asset};

/// Two poses per kind of surroundings.
const POSES: usize = 12;

fn options(shapes: &[&'static str], poses: impl IntoIterator<Item = usize>) -> SweepOptions {
    SweepOptions {
        poses: poses.into_iter().collect(),
        seed: 1,
        size: [96, 64],
        resolution: 2048,
        shapes: shapes.to_vec(),
        scenes: Vec::new(),
        pictures: std::env::var_os("BENDYLIGHTS_SWEEP_PICTURES").map(Into::into),
    }
}

fn found(options: &SweepOptions) -> SweepReport {
    sweep(&mut BACKENDS.map(renderer_of), "", options, |_| {}).expect("all poses can be drawn")
}

/// Number of pixels of a row that may be wrong. In bent light, a lookup falls between texels of a curved map, and one
/// pixel in 100,000 may be wrong.
fn allowed(row: &SweepRow) -> usize {
    if row.shape == "bendy" { row.stable.div_ceil(100_000) } else { 0 }
}

/// Tests rows by the bounds of docs/accuracy.md.
fn are_right(report: &SweepReport) {
    for row in &report.rows {
        println!("{}", serde_json::to_string(row).expect("plain data"));
        let what = format!("{} by {}: {:?}", row.shape, row.backend, report.faults);
        assert_eq!(row.failed, 0, "{what}");
        assert!(row.wrong <= allowed(row), "{what}");
        // Normals are packed to 2^-15: at grazing light, a cosine of 0.03 is off by a thousandth with them.
        assert!(row.radiance_rmse_max <= 1e-3, "{what}");
        assert!(row.stable > 1000 * row.poses, "{what}");
    }
}

#[test]
fn lights_of_all_shapes_are_right_wherever_they_stand() {
    are_right(&found(&options(&SHAPES.map(|(name, _)| name), 0..POSES)));
}

/// Sweeps over two scenes of other authors.
#[test]
#[ignore = "needs ../shared/assets"]
fn lights_of_all_shapes_are_right_over_shared_assets() {
    let folder = shared_asset("scenes");
    let scenes = ["bench.glb", "vases_bowl.glb"].map(|name| {
        let loaded = assets::load(&folder.join(name)).expect("the scene is there and sound");
        SceneFile { name: name.into(), scene: loaded.scene, cameras: loaded.contents.cameras }
    });
    // Every seventh and eighth pose is over one of them.
    let names = scenes.each_ref().map(|scene| scene.name.clone());
    let poses = (0..32).filter(|pose| pose % 8 >= 6);
    let options = SweepOptions { scenes: scenes.into(), ..options(&SHAPES.map(|(name, _)| name), poses) };
    let report = found(&options);
    assert!(report.poses.iter().all(|pose| names.contains(&pose.stage)));
    are_right(&report);
}

/// The planted faults: a lookup beyond a map that is clamped to its border, a wrong depth at the end of a slab, bent
/// edges drawn as straight ones, and a tolerance that leaks light under near casters. Doubling the tolerance is
/// detected under an omni light. Under a bent light the scene is tested if some of the texels are lit, so it takes a
/// factor of four. Each fault has a pose of the sweep that shows it.
#[test]
fn faults_of_maps_are_seen() {
    const CLAMPED: [&str; 2] = ["let beyond = beyond_map(first, resolution);", "let beyond = vec4<bool>(false);"];
    const SHORT: [&str; 2] = ["c.t_start + c.t_span * u)", "c.t_start + c.t_span * min(u, 0.98))"];
    const UNSPLIT: [&str; 2] = ["let splits = u32(ab.split) + u32(bc.split) + u32(ca.split);", "let splits = 0u;"];
    const DOUBLED: [&str; 2] = ["let rise = 0.25 * width", "let rise = 0.5 * width"];
    const FOURFOLD: [&str; 2] = ["light.shadow_tolerance_texels * (", "4.0 * light.shadow_tolerance_texels * ("];
    let faults = [
        ("directional", 14, CLAMPED),
        ("omni", 8, CLAMPED),
        ("bendy", 26, SHORT),
        ("bendy", 88, SHORT),
        ("bendy", 2, UNSPLIT),
        ("omni", 26, DOUBLED),
        ("bendy", 3, FOURFOLD),
    ];
    for (shape, pose, [text, replacement]) in faults {
        let options = options(&[shape], [pose]);
        let row = |renderer: Renderer| {
            let report = sweep(&mut [renderer], "", &options, |_| {}).expect("it can be drawn");
            report.rows[0].clone()
        };
        let faulty = Device::open(Host::default(), Some(BACKENDS[0])).expect("tests need a graphics driver");
        let faulty = faulty.with_fault(text, replacement);
        let found = row(Renderer::new(&faulty).expect("a renderer"));
        println!("{shape} with {replacement}: {} wrong", found.wrong);
        assert!(found.wrong > allowed(&found), "{shape} with {replacement}: {found:?}");
        assert_eq!(row(renderer_of(BACKENDS[0])).wrong, 0, "{shape}");
    }
}
