//! `bendylights bench drag` and `bendylights bench log`, with few samples.

use serde_json::Value;

use crate::program::{Folder, run};

/// The JSON and the chart.
fn measured(args: &[&str]) -> Value {
    let folder = Folder::new();
    let chart = folder.path("chart.svg");
    let done = run(&[args, &["-o", &chart]].concat());
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(std::fs::read_to_string(chart).expect("a chart").starts_with("<svg"));
    serde_json::from_str(&done.stdout).expect("JSON")
}

/// What moves as a whole lands; the paper's formulas miss what they are not exact for, and hit highlights.
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

/// Every edit is answered for, and the log of each length opens.
#[test]
fn the_log_is_measured() {
    let report = measured(&["bench", "log", "--edits", "30"]);
    for (what, count) in
        [("acknowledged", 30), ("acknowledgedOneAtATime", 30), ("undone", 30), ("replayed", 31)]
    {
        assert_eq!(report[what]["count"], count, "{what}: {report}");
        assert!(report[what]["perSecond"].as_f64().is_some_and(|rate| rate > 0.0), "{report}");
    }
    let opening = report["opening"].as_array().expect("lengths");
    let records: Vec<_> = opening.iter().filter_map(|at| at["records"].as_u64()).collect();
    assert_eq!(records, [2, 4, 11, 31]);
}
