//! Tests of `bendylights bench drag`, `bench log`, `bench neighbours`, `bench session` and `bench sweep`, with
//! few samples.

use serde_json::Value;

use crate::program::{Done, Folder, TRIANGLE, run};

/// Runs a measurement with a chart. Returns its JSON and its standard error.
fn measured_and_said(args: &[&str]) -> (Value, String) {
    let folder = Folder::new();
    let chart = folder.path("chart.svg");
    let Done { code, stdout, stderr } = run(&[args, &["-o", &chart]].concat());
    assert_eq!(code, 0, "{stderr}");
    assert!(std::fs::read_to_string(chart).expect("a chart").starts_with("<svg"));
    (serde_json::from_str(&stdout).expect("JSON"), stderr)
}

fn measured(args: &[&str]) -> Value {
    measured_and_said(args).0
}

/// Drags of a whole hotspot land. The paper's formulas miss some shadows, for which they are not exact, and hit
/// all highlights.
#[test]
fn drags_are_measured_beside_the_papers() {
    let report = measured(&["bench", "drag", "--drags", "3"]);
    let kinds = report["kinds"].as_array().expect("kinds");
    assert_eq!(kinds.len(), 16);
    let landed = |kind: &Value, side: &str| kind[side]["landed"].as_u64().expect("a count");
    for kind in kinds {
        assert_eq!(kind["drags"], 3, "{kind}");
        if kind["feature"] == "hotspot" && kind["points"] == "rigid" {
            assert_eq!(landed(kind, "ours"), 3, "{kind}");
        }
    }
    let all = |side: &str, feature: &str| {
        let of_feature = kinds.iter().filter(|kind| kind["feature"] == feature && kind["points"] == "rigid");
        of_feature.map(|kind| landed(kind, side)).sum::<u64>()
    };
    assert!(all("paper", "shadow") < all("ours", "shadow"), "{report}");
    assert_eq!(all("paper", "highlight"), 6, "{report}");
}

/// Every edit is acknowledged, and the log of each length opens.
#[test]
fn the_log_is_measured() {
    let report = measured(&["bench", "log", "--edits", "30"]);
    for (what, count) in [("acknowledged", 30), ("acknowledgedOneAtATime", 30), ("undone", 30), ("replayed", 31)] {
        assert_eq!(report[what]["count"], count, "{what}: {report}");
        assert!(report[what]["perSecond"].as_f64().is_some_and(|rate| rate > 0.0), "{report}");
    }
    let opening = report["opening"].as_array().expect("lengths");
    let records: Vec<_> = opening.iter().filter_map(|at| at["records"].as_u64()).collect();
    assert_eq!(records, [2, 4, 11, 31]);
}

/// Both backends draw each pose of the requested shapes, and the same seed gives the same poses.
#[test]
fn random_lights_are_swept_over() {
    let args = ["bench", "sweep", "--poses", "2", "--shape", "spot", "--shape", "omni", "--size", "48x32"];
    let report = measured(&args);
    let rows = report["rows"].as_array().expect("rows");
    let of: Vec<_> = rows.iter().map(|row| [&row["shape"], &row["backend"]].map(|x| x.as_str())).collect();
    let named = |shape, backend| [Some(shape), Some(backend)];
    assert_eq!(of, [named("omni", "wgpu"), named("omni", "native"), named("spot", "wgpu"), named("spot", "native")]);
    for row in rows {
        assert_eq!((&row["poses"], &row["wrong"]), (&2.into(), &0.into()), "{row}");
        assert!(row["stable"].as_u64().is_some_and(|stable| stable > 100), "{row}");
    }
    assert_eq!(measured(&args)["rows"][0]["stable"], rows[0]["stable"]);
}

/// Returns the faults of the report's drags on `backends`. `said` is the output of the servers, which names the
/// backends that drew.
fn wrong_drags(report: &Value, said: &str, backends: &[&str]) -> Vec<String> {
    let drags = report["drags"].as_array().expect("drags");
    let found: Vec<_> = drags.iter().filter_map(|drag| drag["backend"].as_str()).collect();
    let drawn: Vec<_> =
        said.lines().filter_map(|line| line.rsplit_once(", backend ").map(|(_, backend)| backend.trim())).collect();
    let mut wrong = Vec::new();
    if found != backends {
        wrong.push(format!("the report has {found:?}"));
    }
    // The backend under measurement runs last.
    if !drawn.iter().rev().eq(backends) {
        wrong.push(format!("those who drew are {drawn:?}"));
    }
    for drag in drags {
        let ms = |path: &str| drag.pointer(path).and_then(Value::as_f64);
        let positive = [
            "/framesPerSecond",
            "/frames",
            "/editToDecodedMs/p50",
            "/stagesMs/render/p50",
            "/stagesMs/decode/p95",
            "/releaseToLosslessMs",
            "/frameBytesP50",
        ];
        wrong.extend(positive.iter().filter(|path| ms(path) <= Some(0.0)).map(|path| format!("{path} in {drag}")));
        if ms("/editToDecodedMs/p50") < ms("/stagesMs/render/p50") {
            wrong.push(format!("a frame is there before it is drawn in {drag}"));
        }
    }
    if drags.len() == 2 && drags[0]["editToDecodedMs"] == drags[1]["editToDecodedMs"] {
        wrong.push("both are one's times".into());
    }
    wrong
}

/// Writes a script that stands for another renderer. Its runs report 10, 20 and 30 ms.
fn peers(folder: &Folder) -> String {
    let script = folder.path("peers/peer/bench.py");
    std::fs::create_dir_all(folder.path("peers/peer")).expect("a folder");
    let runs = folder.path("runs");
    let text = format!(
        "echo >> {runs}\necho '{{\"name\": \"peer\", \"version\": \"1\", \"ms_median\": '$(wc -l < {runs})0'}}'"
    );
    std::fs::write(script, text).expect("written");
    folder.path("peers")
}

/// Returns the fault of the report's only peer, whose three runs took 10, 20 and 30 ms.
fn wrong_peer(report: &Value) -> Option<String> {
    let p50 = report["drags"][0]["editToDecodedMs"]["p50"].as_f64().expect("a time");
    let expected = serde_json::json!([{
        "name": "peer",
        "version": "1",
        "wallMs": {"count": 3, "min": 10.0, "p50": 20.0, "p95": 30.0, "p99": 30.0, "p999": 30.0, "max": 30.0},
        "editToDecodedOverIt": p50 / 20.0,
    }]);
    (report["peers"] != expected).then(|| report["peers"].to_string())
}

/// Beside the native backend, wgpu executes the same drag, and other renderers are measured.
#[test]
fn a_session_is_measured_by_both_backends_and_beside_a_peer() {
    let folder = Folder::new();
    let peers = peers(&folder);
    let small = ["bench", "session", "--backend", "native", "--size", "64x36", "--updates", "10"];
    let (report, said) = measured_and_said(&[&small[..], &["--peers", &peers, "--python", "/bin/sh"]].concat());
    assert_eq!(wrong_drags(&report, &said, &["native", "wgpu"]), [""; 0]);
    assert_eq!(report["scene"], "demo:vases");
    // The scene's light is bent already.
    let what = report["what"].as_str().expect("text");
    assert!(what.contains("`key`") && !what.contains("bent and alone"), "{what}");
    assert_eq!(report["cases"].as_array().map(Vec::len), Some(4), "{report}");
    assert_eq!(wrong_peer(&report), None);

    // Deliberate faults that the check must detect: other backends than named, equal times for both, and a peer
    // measured by its fastest run.
    assert_eq!(wrong_drags(&report, "", &["native", "wgpu"]).len(), 1);
    let mut planted = report.clone();
    planted["drags"][1] = planted["drags"][0].clone();
    assert_eq!(wrong_drags(&planted, &said, &["native", "wgpu"]).len(), 2);
    let mut planted = report.clone();
    planted["drags"][0]["stagesMs"]["render"]["p50"] = 0.into();
    assert_eq!(wrong_drags(&planted, &said, &["native", "wgpu"]).len(), 1);
    let mut planted = report;
    planted["peers"][0]["wallMs"]["p50"] = 10.0.into();
    assert!(wrong_peer(&planted).is_some());
}

/// The benchmark bends and drags the default key of a scene without lights. With the wgpu backend it measures
/// nothing beside it.
#[test]
fn a_session_whose_lights_are_straight_is_dragged_too() {
    let folder = Folder::new();
    let scene = folder.file("triangle.gltf", TRIANGLE);
    let small = ["bench", "session", "--backend", "wgpu", "--size", "64x36", "--updates", "10"];
    let (report, said) = measured_and_said(&[&small[..], &["--scene", &scene]].concat());
    assert_eq!(wrong_drags(&report, &said, &["wgpu"]), [""; 0]);
    assert_eq!(report["scene"], "triangle.gltf");
    let what = report["what"].as_str().expect("text");
    assert!(what.contains("`default key`") && what.contains("bent and alone"), "{what}");
    assert_eq!(report["peers"], serde_json::json!([]));
    // A missing scene is refused before a server starts.
    let missing = run(&["bench", "session", "--scene", "demo:nothing"]);
    assert_eq!(missing.code, 2);
    assert!(missing.stderr.contains("vases") && !missing.stderr.contains("rendering"), "{}", missing.stderr);
}

/// Returns the faults in rows of `bench neighbours`, whatever they report of the server.
fn wrong_rows(report: &Value, names: &[&str]) -> Vec<String> {
    let rows = report["rows"].as_array().expect("rows");
    let found: Vec<_> = rows.iter().filter_map(|row| row["row"].as_str()).collect();
    let mut wrong = Vec::new();
    if found != names {
        wrong.push(format!("the report has {found:?}"));
    }
    for row in rows {
        let number = |path: &str| row.pointer(path).and_then(Value::as_f64).unwrap_or(f64::NAN);
        let positive = [
            "/alone/framesPerSecond",
            "/alone/ownDrags",
            "/alone/ownDragMs/p50",
            "/aloneAfter/framesPerSecond",
            "/memory/afterMib",
            "/serverCpuShare",
            "/other/done",
        ];
        let is_positive = |path: &&str| number(path) > 0.0;
        wrong.extend(positive.iter().filter(|path| !is_positive(path)).map(|path| format!("{path} in {row}")));
        let alone = number("/alone/framesPerSecond").max(number("/aloneAfter/framesPerSecond"));
        let share = number("/with/framesPerSecond") / alone;
        if (share - number("/share")).abs() > 1e-9 {
            wrong.push(format!("the share is {share} in {row}"));
        }
        let misses = |bound: &str| row["missed"].as_array().is_some_and(|missed| missed.contains(&bound.into()));
        if misses("share") == (share >= number("/leastShare")) || misses("gap") == (number("/longestGapOfUsual") <= 4.0)
        {
            wrong.push(format!("a bound is judged wrongly in {row}"));
        }
        if row["passes"] != row["missed"].as_array().is_some_and(Vec::is_empty) {
            wrong.push(format!("it passes and misses in {row}"));
        }
    }
    wrong
}

/// Compares the report with its own bounds. The bounds themselves are the benchmark's.
#[test]
fn one_client_is_measured_beside_another() {
    let folder = Folder::new();
    let chart = folder.path("chart.svg");
    let rows = ["asks", "closing-views"];
    let short = ["--seconds", "2", "--rest-s", "1", "--size", "64x36", "-o", &chart];
    let Done { code, stdout, stderr } =
        run(&[&["bench", "neighbours", "--row", rows[0], "--row", rows[1]][..], &short].concat());
    let mut report: Value = serde_json::from_str(&stdout).expect("JSON");
    assert_eq!(wrong_rows(&report, &rows), [""; 0]);
    let missed: Vec<&str> = report["rows"]
        .as_array()
        .into_iter()
        .flatten()
        .filter(|row| row["passes"] == false)
        .filter_map(|row| row["row"].as_str())
        .collect();
    assert_eq!(code, i32::from(!missed.is_empty()), "{stderr}");
    assert!(missed.iter().all(|row| stderr.contains(row)), "{stderr}");
    let chart = std::fs::read_to_string(chart).expect("a chart");
    assert!(rows.iter().all(|row| chart.contains(row)));

    // Deliberate faults that the check must detect: frames from another source, and a missed bound that the numbers
    // fulfil.
    report["rows"][0]["with"]["framesPerSecond"] = 1e4.into();
    report["rows"][1]["missed"] = serde_json::json!(["share"]);
    report["rows"][1]["share"] = report["rows"][1]["leastShare"].clone();
    assert!(wrong_rows(&report, &rows).len() >= 2);
    assert_eq!(run(&["bench", "neighbours", "--row", "noise"]).code, 2);
}
