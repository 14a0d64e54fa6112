//! A small bench has every row and stage, and what is edited shows in the stages that it must and in no others.

use glam::DVec3;
use light::Light;
use light::parameters::{CONE_ANGLE, INTENSITY, TRANSLATION};
use serde_json::Value;

use super::*;
use crate::shadow::scenes::{Part, ball, floor, place, scene_of, view};

const MAP: [&str; 6] = ["vertices", "triangles", "clip", "split", "draw", "counts"];

/// A ball on a floor under a spotlight from above.
fn subject() -> Subject {
    let scene = scene_of(vec![floor(), Part(ball(8), place([0.4; 3], 0.0, [0.0, 0.4, 0.0]))]);
    let down = glam::DQuat::from_rotation_arc(DVec3::NEG_Z, DVec3::NEG_Y);
    let spot = Light::spot()
        .with(TRANSLATION, DVec3::new(0.2, 4.0, 0.1))
        .with(light::parameters::ROTATION, down)
        .with(CONE_ANGLE, 20.0)
        .with(INTENSITY, 30.0);
    Subject::new("ball", scene, view(64, 36).camera, &spot, [64, 36]).expect("the light bends")
}

fn report() -> Value {
    let growth =
        GrowthPlan { triangles: vec![1_000], lights: vec![2], segments: vec![2], sizes: vec![[160, 90]] };
    let options =
        Options { repeats: 2, crowd: 3, backend: Some(Backend::Wgpu), peers: None, growth: Some(&growth) };
    let (report, chart) =
        run(&subject(), options, &|progress| assert!(progress.done < progress.of)).expect("measured");
    assert!(chart.starts_with("<svg"));
    let table = report.table();
    assert!(Edit::ALL.iter().all(|edit| table.contains(edit.name())), "{table}");
    serde_json::to_value(&report).expect("plain data")
}

/// The stages that the frame after an edit runs.
fn expected(edit: &str) -> Vec<&'static str> {
    let shown = ["display", "readback"];
    let lit = ["fill", "light"];
    match edit {
        "first" => [&["gbuffer"][..], &MAP, &lit, &shown].concat(),
        "camera" => [&["gbuffer"][..], &lit, &shown].concat(),
        "lightMove" | "controlPoint" | "radius" => [&MAP[..], &["light"], &shown].concat(),
        // Colors, intensities, mute: a sum of what is kept.
        _ => shown.into(),
    }
}

/// Why a row does not show what is expected of `edit`.
fn fault(row: &Value, edit: &str) -> Option<String> {
    let stages = row["stages"].as_array().expect("stages");
    let ran: Vec<&str> = stages
        .iter()
        .filter(|stage| stage["runs"] != 0)
        .filter_map(|stage| stage["stage"].as_str())
        .collect();
    let of_light = stages.iter().filter(|stage| stage["stage"] == "light").any(|stage| stage["runs"] == 1);
    let map = expected(edit).contains(&"draw");
    let faults = [
        (ran != expected(edit), "other stages"),
        (of_light != expected(edit).contains(&"light"), "one light is not added once"),
        ((row["texels"] != 0) != map, "texels of a map that is not drawn, or none"),
        ((row["trianglesSeen"] != 0) != map, "triangles of a map that is not drawn, or none"),
        (row["bytes"] != 64 * 36 * 4, "another picture is read back"),
    ];
    faults.into_iter().find_map(|(wrong, what)| wrong.then(|| format!("{what}: {ran:?}")))
}

#[test]
fn an_edit_runs_the_stages_that_it_must_and_no_others() {
    let report = report();
    let rows = report["edits"].as_array().expect("rows");
    assert_eq!(rows.len(), Edit::ALL.len());
    for row in rows {
        let edit = row["edit"].as_str().expect("a name");
        assert_eq!(fault(row, edit), None, "{edit}: {row}");
        assert_eq!(row["stages"].as_array().map(Vec::len), Some(render::Stage::ALL.len()));
    }
    // A light that moved is no light that became brighter, and a first frame none that was there.
    assert!(fault(&rows[2], "intensity").is_some() && fault(&rows[6], "lightMove").is_some(), "{report}");
    assert!(fault(&rows[0], "idle").is_some(), "{report}");
    // The ball has more triangles than the floor, and the map of the light shows it.
    assert!(rows[2]["trianglesDrawn"].as_u64() > Some(100), "{report}");
    assert!(report["pixelsInTube"].as_u64() > Some(50), "{report}");

    let sides: Vec<_> =
        report["sideBySide"].as_array().expect("sides").iter().map(|one| &one["what"]).collect();
    assert_eq!(
        sides,
        [
            "bent",
            "bentHalfMap",
            "spot",
            "straightBendy",
            "bentNothingCulled",
            "bentIntensity",
            "bent3OneMoves"
        ]
    );
    assert_eq!(report["sideBySide"][0]["toBent"]["min"], 1.0);
    for axis in report["growth"].as_array().expect("axes") {
        let point = &axis["points"][0];
        assert!(point["error"]["compared"].as_u64() > Some(20), "{axis}");
        assert!(point["error"]["radianceRmse"].as_f64() < Some(1e-2), "{axis}");
    }
}

#[test]
fn what_is_no_folder_of_peers_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().expect("a folder");
    let said = |python| Peers::find(folder.path(), python).map(|_| ()).expect_err("refused").to_string();
    assert!(said(None).contains("bench.py"), "{}", said(None));
    let peer = folder.path().join("peer");
    std::fs::create_dir(&peer).expect("a folder");
    let says = |script: &str| std::fs::write(peer.join("bench.py"), script).expect("written");
    says("echo '{\"name\": \"peer\", \"version\": \"1\", \"ms_median\": 4}'; echo more");
    assert!(said(None).contains("--python"), "{}", said(None));
    let shell = std::path::Path::new("/bin/sh");
    let peers = Peers::find(folder.path(), Some(shell)).expect("found");
    let lines = peers.run(0, 1).expect("measured");
    assert_eq!((lines.len(), lines[0].name.as_str(), lines[0].ms_median), (1, "peer", 4.0));
    says("echo broken >&2; exit 1");
    assert!(peers.run(0, 1).expect_err("it failed").to_string().contains("broken"));
    says("echo nothing");
    assert!(peers.run(0, 1).is_err());
}
