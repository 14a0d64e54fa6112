//! Tests that a small benchmark has every row and stage, and that an edit runs the stages that it must and no others.

use glam::DVec3;
use light::Light;
use light::parameters::{CONE_ANGLE, INTENSITY, TRANSLATION};
use serde_json::Value;

use super::*;
use crate::shadow::scenes::{floor, grey_scene, place, view};
use crate::solids::{PlacedPrimitive, ball};

/// Returns a ball on a floor under a spotlight from above.
fn subject() -> FrameSubject {
    let scene = grey_scene([floor(), PlacedPrimitive(ball(8), place([0.4; 3], 0.0, [0.0, 0.4, 0.0]))]);
    let down = glam::DQuat::from_rotation_arc(DVec3::NEG_Z, DVec3::NEG_Y);
    let spot = Light::spot()
        .with(TRANSLATION, DVec3::new(0.2, 4.0, 0.1))
        .with(light::parameters::ROTATION, down)
        .with(CONE_ANGLE, 20.0)
        .with(INTENSITY, 30.0);
    FrameSubject::new("ball", scene, view(64, 36).camera, &spot, [64, 36]).expect("the light bends")
}

fn report(backend: Backend) -> Value {
    let growth = GrowthPlan { triangles: vec![1_000], lights: vec![2], segments: vec![2], sizes: vec![[160, 90]] };
    let options =
        FrameBenchOptions { repeats: 2, crowd: 3, backend: Some(backend), peers: None, growth: Some(&growth) };
    let (report, chart) = run(&subject(), options, &|progress| assert!(progress.done < progress.of)).expect("measured");
    assert!(chart.starts_with("<svg"));
    let table = report.table();
    assert!(FrameEdit::ALL.iter().all(|edit| table.contains(edit.name())), "{table}");
    let backends = [Backend::Wgpu, Backend::Native].map(Backend::name);
    for who in backends {
        // A single backend needs no name in table and chart.
        let is_shown = backend == Backend::Native || who == backend.name();
        assert_eq!(table.contains(&format!("{who}'s error")), is_shown, "{table}");
        assert_eq!(chart.contains(&format!("{who} (error ")), is_shown, "{who}");
    }
    serde_json::to_value(&report).expect("plain data")
}

/// Stages that the frame after an edit runs.
fn expected(backend: &str, edit: &str) -> Vec<&'static str> {
    // The CPU draws clipped triangles at once, and its bytes need no readback.
    let is_native = backend == "native";
    let map: &[&str] = if is_native {
        &["vertices", "triangles", "split", "draw"]
    } else {
        &["vertices", "triangles", "clip", "split", "draw", "counts"]
    };
    let seen: &[&str] = if is_native { &["gbuffer", "surfaces"] } else { &["gbuffer"] };
    let shown: &[&str] = if is_native { &["display"] } else { &["display", "readback"] };
    let lit: &[&str] = if is_native { &["light"] } else { &["fill", "light"] };
    match edit {
        "first" => [seen, map, lit, shown].concat(),
        "camera" => [seen, lit, shown].concat(),
        "lightMove" | "controlPoint" | "radius" => [map, &["light"], shown].concat(),
        // Color, intensity and mute sum cached layers.
        _ => shown.into(),
    }
}

/// Returns the fault if a row does not show the expected work of `edit` by `backend`.
fn fault(row: &Value, backend: &str, edit: &str) -> Option<String> {
    let expected = expected(backend, edit);
    let stages = row["stages"].as_array().expect("stages");
    let ran: Vec<&str> =
        stages.iter().filter(|stage| stage["runs"] != 0).filter_map(|stage| stage["stage"].as_str()).collect();
    let of_light = stages.iter().filter(|stage| stage["stage"] == "light").any(|stage| stage["runs"] == 1);
    let map = expected.contains(&"draw");
    let read_back = if expected.contains(&"readback") { 64 * 36 * 4 } else { 0 };
    let faults = [
        (row["backend"] != backend, "somebody else's"),
        (ran != expected, "other stages"),
        (of_light != expected.contains(&"light"), "one light is not added once"),
        ((row["texels"] != 0) != map, "texels of a map that is not drawn, or none"),
        ((row["trianglesSeen"] != 0) != map, "triangles of a map that is not drawn, or none"),
        (row["bytes"] != read_back, "another picture is read back"),
    ];
    faults.into_iter().find_map(|(wrong, what)| wrong.then(|| format!("{what}: {ran:?}")))
}

/// Checks the rows of each of `backends`, in their order.
fn check_edits(report: &Value, backends: &[&str]) {
    let rows = report["edits"].as_array().expect("rows");
    assert_eq!(rows.len(), backends.len() * FrameEdit::ALL.len());
    for (rows, backend) in rows.chunks(FrameEdit::ALL.len()).zip(backends) {
        for row in rows {
            let edit = row["edit"].as_str().expect("a name");
            assert_eq!(fault(row, backend, edit), None, "{edit}: {row}");
            assert_eq!(row["stages"].as_array().map(Vec::len), Some(render::FrameStage::ALL.len()));
        }
        // A moved light differs from a brighter one, and a first frame from an unchanged one.
        assert!(fault(&rows[2], backend, "intensity").is_some(), "{report}");
        assert!(fault(&rows[6], backend, "lightMove").is_some(), "{report}");
        assert!(fault(&rows[0], backend, "idle").is_some(), "{report}");
        // The ball has more triangles than the floor, and the light's map has them.
        assert!(rows[2]["trianglesDrawn"].as_u64() > Some(100), "{report}");
    }
    assert!(report["pixelsInTube"].as_u64() > Some(50), "{report}");
}

/// Checks the participants: `ours`, pairs of a backend and the names of its variants, in this order.
fn check_sides(report: &Value, ours: &[(&str, &[&str])]) {
    let sides = report["sideBySide"].as_array().expect("sides");
    let found: Vec<_> = sides.iter().map(|one| (&one["backend"], &one["what"])).collect();
    let expected: Vec<_> = ours
        .iter()
        .flat_map(|(backend, names)| {
            names.iter().map(|name| (Value::from(*backend), Value::from(*name))).collect::<Vec<_>>()
        })
        .collect();
    assert!(found.iter().copied().eq(expected.iter().map(|(backend, what)| (backend, what))), "{found:?}");
    // All are compared with the first.
    let (bent, last) = (&sides[0], &sides[sides.len() - 1]);
    assert_eq!(bent["toBent"]["min"], 1.0);
    let ms = |one: &Value| one["wallMs"]["min"].as_f64().expect("a time");
    let ratio = last["toBent"]["min"].as_f64().expect("a ratio");
    assert!((ratio * ms(bent) / ms(last) - 1.0).abs() < 1e-9, "{report}");
}

/// Returns the fault of a picture. An error of 1 in 100 remains at maps of this size, from edges and shading in f32.
fn wrong_picture(error: &Value) -> Option<&'static str> {
    let faults = [
        (error["compared"].as_u64() <= Some(20), "little is compared"),
        (error["radianceRmse"].as_f64().is_none_or(|rmse| rmse > 1e-2), "it is wrong"),
    ];
    faults.into_iter().find_map(|(wrong, what)| wrong.then_some(what))
}

/// Checks the errors of the pictures of all `backends`, of the subject and on the growth axes.
fn check_errors(report: &Value, backends: &[&str]) {
    let errors = report["errors"].as_array().expect("errors");
    let of: Vec<_> = errors.iter().map(|error| &error["backend"]).collect();
    assert_eq!(of, backends);
    for error in errors {
        assert_eq!((&error["width"], &error["height"]), (&Value::from(16), &Value::from(9)), "{error}");
        assert_eq!(wrong_picture(error), None, "{error}");
    }
    for axis in report["growth"].as_array().expect("axes") {
        let point = &axis["points"][0];
        assert_eq!(wrong_picture(&point["error"]), None, "{axis}");
        let beside = &point["byWgpu"];
        assert_eq!(beside.is_object(), backends.len() == 2, "{axis}");
        if beside.is_object() {
            assert_eq!(wrong_picture(&beside["error"]), None, "{axis}");
            assert!(beside["frame"]["wallMs"]["min"].as_f64() > Some(0.0), "{axis}");
            assert_ne!(beside["frame"], point["frame"], "both are one's times: {axis}");
        }
    }
}

const OURS: [&str; 7] =
    ["bent", "bentHalfMap", "spot", "straightBendy", "bentNothingCulled", "bentIntensity", "bent3OneMoves"];

/// Covers wgpu alone. The next test covers the stages of the CPU.
#[test]
fn an_edit_runs_the_stages_that_it_must_and_no_others() {
    let report = report(Backend::Wgpu);
    assert_eq!(report["backend"], "wgpu");
    check_edits(&report, &["wgpu"]);
    check_sides(&report, &[("wgpu", &OURS)]);
    check_errors(&report, &["wgpu"]);
}

#[test]
fn beside_the_processor_wgpu_draws_the_same_in_the_same_run() {
    let report = report(Backend::Native);
    assert_eq!(report["backend"], "native");
    check_edits(&report, &["native", "wgpu"]);
    let beside = ["bentByWgpu", "bentHalfMapByWgpu", "spotByWgpu", "bentIntensityByWgpu", "bent3OneMovesByWgpu"];
    check_sides(&report, &[("native", &OURS), ("wgpu", &beside)]);
    check_errors(&report, &["native", "wgpu"]);
    // The rows of one backend fail the checks of the other.
    let rows = report["edits"].as_array().expect("rows");
    for (row, other) in [(&rows[0], "wgpu"), (&rows[FrameEdit::ALL.len()], "native")] {
        let mut taken_for = row.clone();
        taken_for["backend"] = other.into();
        assert!(fault(&taken_for, other, "first").is_some(), "{row}");
    }
}
