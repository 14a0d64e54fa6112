//! Logs of earlier versions, one per format. They are permanent: every log must replay forever.

use std::collections::BTreeSet;
use std::path::PathBuf;

use protocol::{LogLine, LogReader};
use serde_json::Value;
use store::{StoreError, replay_log};

use crate::sources::repository;

/// The log of a format in `logs/`, and the hash of its document when it was written.
struct OldLog {
    format: u32,
    records: u64,
    hash: &'static str,
}

const OLD_LOGS: &[OldLog] = &[
    OldLog { format: 1, records: 43, hash: "4a062bb30a1c9a5d669a9b9ff34e788daa293374d49b7e02162f4bb3d6cb923b" },
    OldLog { format: 2, records: 52, hash: "a13459dd0bd5b0056862e961c0d37566a1e5e2e6180d852825a42198bfc2f260" },
    OldLog { format: 3, records: 60, hash: "5f0aa993b13873a8e5447787bcdda76c746c308c28aa2119a56c07e9c6ea4fd6" },
    OldLog { format: 4, records: 60, hash: "5f0aa993b13873a8e5447787bcdda76c746c308c28aa2119a56c07e9c6ea4fd6" },
    OldLog { format: 5, records: 63, hash: "a419a0fdfc3136bbd70d61fa174532c13f892e9cbdc5213ac9c3e0fbfb9b0365" },
    OldLog { format: 6, records: 73, hash: "126d66cc137c9772dcc9f1ee07e6325db35034ea03e79a7191f7ce500edc5a76" },
];

fn folder() -> PathBuf {
    repository().join("tests/logs")
}

impl OldLog {
    fn file(&self) -> String {
        format!("format-{}.jsonl", self.format)
    }

    fn text(&self) -> String {
        std::fs::read_to_string(folder().join(self.file())).expect("a log")
    }

    fn lines(&self) -> Vec<String> {
        self.text().lines().map(String::from).collect()
    }
}

/// Rules: REC-5, LOG-2
#[test]
fn every_old_log_replays_to_its_hash() {
    let files = std::fs::read_dir(folder()).expect("a folder").count();
    assert_eq!(files, OLD_LOGS.len(), "each log of the folder is listed here");
    for log in OLD_LOGS {
        let file = log.file();
        let replayed = replay_log(log.text().as_bytes(), None).expect(&file);
        assert_eq!(replayed.first_difference, None, "{file}");
        assert_eq!(replayed.session.seq(), log.records, "{file}");
        assert_eq!(replayed.session.document().hash_of_format(log.format).to_string(), log.hash, "{file}");
    }
}

/// Rules: LOG-2, REC-3
#[test]
fn a_planted_change_of_any_value_is_noticed() {
    for log in OLD_LOGS {
        let lines = log.lines();
        let mut reader = LogReader::default();
        for (index, line) in lines.iter().enumerate() {
            let Ok(LogLine::Record(record)) = reader.read(line) else { continue };
            let mut planted: Value = serde_json::from_str(line).expect("JSON");
            let Some(number) =
                planted["changes"].as_array_mut().and_then(|changes| changes.iter_mut().find_map(a_number))
            else {
                continue;
            };
            *number = (number.as_f64().expect("a number") + 1e-9).into();
            let mut changed = lines.clone();
            changed[index] = planted.to_string();
            let noticed = match replay_log(changed.join("\n").as_bytes(), None) {
                Ok(replayed) => replayed.first_difference.is_some(),
                // A value that other lines refer to may be stored elsewhere after the change.
                Err(StoreError::Line { .. }) => log.text().contains("sameAs"),
                Err(error) => matches!(error, StoreError::Replay(_) | StoreError::InvalidRecord { .. }),
            };
            assert!(noticed, "{}: record {}", log.file(), record.seq);
        }
    }
}

/// The hash of a format ignores parameters of later formats, so its records must not contain any.
///
/// Rules: REC-5, LOG-2
#[test]
fn a_planted_parameter_of_a_later_format_is_refused_by_name() {
    /// Finds a part of a record that holds parameters: a whole light, or a changed value.
    type Part = fn(&mut Value) -> Option<&mut Value>;
    fn change<'a>(record: &'a mut Value, of: &str, side: &str) -> Option<&'a mut Value> {
        let changes = record["changes"].as_array_mut()?;
        changes.iter_mut().find(|change| change["type"] == of && change[side].is_object())?.get_mut(side)
    }
    let inside: [Part; 3] = [
        |record| change(record, "light", "new")?.get_mut("light"),
        |record| change(record, "light", "old")?.get_mut("light"),
        |record| record["action"]["command"].get_mut("light").filter(|light| light.is_object()),
    ];
    let set: [Part; 3] = [
        |record| change(record, "lightParameter", "new"),
        |record| change(record, "point", "new"),
        |record| record["action"]["command"].get_mut("parameter"),
    ];
    let add: fn(&mut Value) = |light| light["exposure"] = 50.into();
    let add_default: fn(&mut Value) = |light| light["exposure"] = 0.into();
    let replace: fn(&mut Value) = |setting| *setting = serde_json::json!({"exposure": 9});
    let plants =
        [inside.map(|part| (part, add)), inside.map(|part| (part, add_default)), set.map(|part| (part, replace))];
    let plants = plants.concat();
    for log in &OLD_LOGS[..2] {
        for (index, (part, plant)) in plants.iter().enumerate() {
            let (file, mut lines) = (log.file(), log.lines());
            let planted = lines.iter_mut().find_map(|line| {
                let mut record: Value = serde_json::from_str(line).expect("JSON");
                // A reference to another line has no fields of its own.
                let value = part(&mut record).filter(|value| value.get("sameAs").is_none())?;
                plant(value);
                *line = record.to_string();
                record["seq"].as_u64()
            });
            let planted = planted.unwrap_or_else(|| panic!("{file}: no part for {index}"));
            let refused = replay_log(lines.join("\n").as_bytes(), None).expect_err(&file);
            let said = refused.to_string();
            // Only lights have an exposure; parameters of control points are read by name.
            let of_points = said.contains("there is no parameter `exposure`");
            let expected = format!("record {planted}: format {} has no `exposure`", log.format);
            assert!(said.contains(&expected) || of_points, "{file}: {index}: {said}");
            assert_eq!(refused.code(), protocol::ErrorCode::BadLog);
        }
    }
}

/// The first number in a change's new value that is not whole, and so no index or id.
fn a_number(change: &mut Value) -> Option<&mut Value> {
    fn within(value: &mut Value) -> Option<&mut Value> {
        match value {
            Value::Number(number) if number.is_f64() => Some(value),
            Value::Array(items) => items.iter_mut().find_map(within),
            Value::Object(fields) => fields.values_mut().find_map(within),
            _ => None,
        }
    }
    within(change.get_mut("new")?)
}

/// Each log has every part of its format; a log with few parts proves little.
///
/// Rules: REC-5
#[test]
fn old_logs_hold_everything_their_format_has() {
    for log in OLD_LOGS {
        let mut seen = BTreeSet::new();
        for line in log.lines() {
            let value: Value = serde_json::from_str(&line).expect("JSON");
            types(&value, &mut seen);
        }
        let expected = "edit gesture undo redo \
            loadScene addLight removeLight placeLight setLight setPoint insertPoint removePoint \
            addCamera removeCamera placeCamera setCamera \
            scene light lightParameter point controlPoints camera cameraParameter bendy spot";
        for name in expected.split_whitespace() {
            assert!(seen.contains(name), "{}: no {name}", log.file());
        }
    }
    // Additions of format 2.
    for part in [r#"{"sameAs":{"record":"#, r#""rebased":true"#, r#""proof":""#] {
        assert!(OLD_LOGS[1..].iter().all(|log| log.text().contains(part)), "{part}");
    }
    // Additions of format 5.
    assert!(OLD_LOGS[4..].iter().all(|log| log.text().contains(r#""action":{"type":"group""#)));
    // Additions of format 6.
    for part in [r#""at":"blue vase""#, r#""kind":"look""#, r#""kind":"coordinates""#] {
        assert!(OLD_LOGS[5..].iter().all(|log| log.text().contains(part)), "{part}");
    }
}

/// Collects every `type` within `value`.
fn types(value: &Value, seen: &mut BTreeSet<String>) {
    match value {
        Value::Object(fields) => {
            seen.extend(fields.get("type").and_then(Value::as_str).map(String::from));
            fields.values().for_each(|field| types(field, seen));
        }
        Value::Array(items) => items.iter().for_each(|item| types(item, seen)),
        _ => {}
    }
}
