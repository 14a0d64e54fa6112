//! Tests of single lines of a log file.

use protocol::{
    Checkpoint, FIRST_PROOF, FileError, LogHeader, LogLine, LogPosition, LogReader, MIN_HELD_BYTES, ReadError, compact,
    next_proof,
};
use serde_json::{Value, json};

const RECORD: &str = r#"{"format":1,"seq":1,"timeMs":1790000000000,"actor":{"id":"a","name":"Ada"},"opId":"x","action":{"type":"undo","scope":"mine","target":5,"skipped":["light 1's radius has been changed since"]},"changes":[{"type":"lightParameter","light":1,"old":{"coneAngle":25.0},"new":{"coneAngle":30.5}}]}"#;

fn read(line: &str) -> Result<LogLine, FileError> {
    LogReader::default().read(line)
}

/// Rules: LOG-1
#[test]
fn lines_are_written_as_they_are_read() {
    let header = r#"{"format":1,"session":"main"}"#;
    assert_eq!(LogHeader::parse(header).expect("a header").to_json(), header);
    let hash = "ab".repeat(32);
    for proof in [None, Some("cd".repeat(32))] {
        let said = proof.as_ref().map_or(String::new(), |proof| format!(r#","proof":"{proof}""#));
        let checkpoint = format!(r#"{{"checkpoint":{{"seq":7,"hash":"{hash}"{said}}}}}"#);
        let line = read(&checkpoint).expect("a checkpoint");
        assert_eq!(line, LogLine::Checkpoint(Checkpoint { seq: 7, hash: hash.clone(), proof }));
        assert_eq!(line.to_json(), checkpoint);
    }
    assert_eq!(read(RECORD).expect("a record").to_json(), RECORD);
}

/// Rules: LOG-1, REC-5
#[test]
fn other_lines_are_refused_by_what_is_wrong() {
    let refused = |text: &str, expected: &str| {
        let said = read(text).expect_err(text).to_string();
        assert!(said.contains(expected), "{text}: {said}");
    };
    refused("", "it ends where a value");
    refused("{", "it ends before");
    refused("[]", "");
    refused(&format!("{RECORD}{RECORD}"), "something follows");
    refused(&RECORD.replace("\"seq\":1", "\"seq\":-1"), "seq");
    refused(&RECORD.replace("\"opId\"", "\"opID\""), "`opID`");
    refused(&RECORD.replace("30.5", "\"30.5\""), "changes[0]");
    refused(&RECORD.replace("\"target\":5", "\"target\":5,\"gobo\":1"), "`gobo`");
    refused(&RECORD.replace("{\"format\":1,", "{"), "format");
    refused(r#"{"checkpoint":{"seq":7}}"#, "hash");
    refused(r#"{"checkpoint":{"seq":7,"hash":"","gobo":1}}"#, "`gobo`");
    LogHeader::parse(r#"{"format":1}"#).expect_err("no session");
    let later = LogHeader::parse(r#"{"format":7,"session":"main"}"#).expect_err("a later format").to_string();
    assert!(later.contains("format 7"), "{later}");
}

/// Returns a record that adds a light with 40 control points, and one that removes it, in full.
fn long_records() -> [Value; 2] {
    let points: Vec<[f64; 3]> = (0..40).map(|i| [0.0, 0.0, -0.1 * f64::from(i)]).collect();
    let light = json!({"type": "bendy", "name": "\\\"{\"sameAs\":[[", "points": points, "radii": vec![0.01; 40]});
    let record = |seq: u64, action: Value, changes: Value| {
        json!({"format": 2, "seq": seq, "timeMs": 1, "actor": {"id": "a", "name": "Ada"}, "opId": seq.to_string(),
            "action": action, "changes": changes})
    };
    let placed = |layout: u64| json!({"layout": layout, "light": light});
    let added = json!([{"type": "light", "light": 1, "old": null, "new": placed(1)}]);
    let removed = json!([{"type": "light", "light": 1, "old": placed(1), "new": null}]);
    [
        record(1, json!({"type": "edit", "command": {"type": "addLight", "light": light}}), added),
        record(2, json!({"type": "edit", "command": {"type": "removeLight", "light": 1}}), removed),
    ]
}

/// Returns the lines of these records in a log, in order.
fn compacted(records: &[Value]) -> Vec<String> {
    let mut held = std::collections::BTreeMap::new();
    let lines = records.iter().map(|record| {
        let seq = record["seq"].as_u64().expect("a number");
        let text = record.to_string();
        let line = compact(&text, seq, |hash| Ok::<_, ()>(held.get(hash).copied())).expect("no error");
        held.extend(line.new_values.into_iter().map(|(hash, at)| (hash, LogPosition { record: seq, at })));
        line.text
    });
    lines.collect()
}

/// Rules: REC-6
#[test]
fn a_long_value_stands_in_a_log_once() {
    let records = long_records();
    let lines = compacted(&records);
    let whole = records[0].to_string().len();
    assert!(lines[0].len() < whole * 2 / 3, "it stood twice in its own record: {} of {whole}", lines[0].len());
    assert!(lines[1].len() < MIN_HELD_BYTES, "{}", lines[1]);
    let mut reader = LogReader::default();
    for (line, record) in lines.iter().zip(&records) {
        let LogLine::Record(read) = reader.read(line).expect("what was written") else { panic!("a record") };
        let expected: protocol::Record = serde_json::from_value(record.clone()).expect("a record");
        assert_eq!(*read, expected);
    }
    // After a checkpoint the reader requests the earlier lines.
    let mut asked = Vec::new();
    let mut find_line = |seq: u64| {
        asked.push(seq);
        Ok::<_, ()>(lines.get(seq as usize - 1).cloned())
    };
    let (read, bytes) = LogReader::default().read_record(&lines[1], &mut find_line).expect("found");
    assert_eq!((read.seq, bytes), (2, records[1].to_string().len()));
    assert_eq!(asked, [1]);
}

/// Rules: REC-6, LOG-4
#[test]
fn references_that_lead_nowhere_are_refused() {
    let lines = compacted(&long_records());
    let refused = |line: &str, expected: &str| {
        let mut reader = LogReader::default();
        reader.read(&lines[0]).expect("a record");
        let said = reader.read(line).expect_err(line).to_string();
        assert!(said.contains(expected), "{said}");
    };
    refused(&lines[1].replace("\"hash\":\"", "\"hash\":\"0"), "does not hold");
    refused(&lines[1].replace("\"at\":", "\"at\":1"), "does not hold");
    refused(&lines[1].replace("\"at\":", "\"at\":99999"), "does not hold");
    refused(&lines[1].replace("\"record\":1", "\"record\":3"), "refers ahead");
    refused(&lines[1].replace("\"record\":1", "\"recard\":1"), "has a `sameAs` that is not");
    refused(&lines[1].replace("{\"sameAs\"", "{ \"sameAs\""), "changes[0]");
    refused(&lines[1][..lines[1].len() - 1], "it ends before");
    let alone = LogReader::default().read(&lines[1]).expect_err("the line before is missing").to_string();
    assert!(alone.contains("record 1 does not hold"), "{alone}");
    let around = r#"{"format":2,"seq":1,"x":[{"sameAs":{"record":1,"at":24,"hash":""}}]}"#;
    let said = read(around).expect_err("a circle").to_string();
    assert!(said.contains("what is around it"), "{said}");
    // The source returns another record than the requested one.
    let mut find_line = |_: u64| Ok::<_, ()>(Some(lines[1].clone()));
    let error = LogReader::default().read_record(&lines[1], &mut find_line);
    assert!(matches!(error, Err(ReadError::Line(_))), "{error:?}");
}

/// The short line would expand to a long one: each list holds the one before eight times.
///
/// Rules: REC-6, HTTP-11
#[test]
fn a_line_that_grows_beyond_all_bounds_is_refused() {
    let list = |item: &str, count: usize| format!("[{}]", vec![item; count].join(","));
    let mut line = String::from(r#"{"format":2,"seq":1,"x":["#);
    let (mut item, mut whole) = (list("0", MIN_HELD_BYTES), list("0", MIN_HELD_BYTES));
    for _ in 0..12 {
        let at = line.len();
        line += &item;
        line.push(',');
        let hash = document::AssetHash::of(whole.as_bytes()).hex();
        item = list(&format!(r#"{{"sameAs":{{"record":1,"at":{at},"hash":"{hash}"}}}}"#), 8);
        // Later lines need no correct hash, because the reader stops before it checks them.
        whole = if whole.len() < 8 << 20 { list(&whole, 8) } else { whole };
    }
    line += "0]}";
    let said = read(&line).expect_err("8^12 kilobytes").to_string();
    assert!(said.contains("more than"), "{said}");
}

/// A light changes bit by bit, as by hundreds of insertions, and each line refers to the one before. The reader
/// requests only the lines that it needs, whatever the length of the log.
///
/// Rules: REC-6
#[test]
fn any_record_of_a_long_log_can_be_read_alone() {
    let part = |n: u64| vec![n as f64 + 0.5; 300];
    let record = |seq: u64| {
        let [old, new] = [seq - 1, seq].map(|n| json!({"a": part(n), "b": part(n / 10), "n": n}));
        json!({"format": 2, "seq": seq, "old": old, "new": new})
    };
    let records: Vec<Value> = (1..200).map(record).collect();
    let lines = compacted(&records);
    let bytes = |texts: &[String]| texts.iter().map(String::len).sum::<usize>();
    let whole: Vec<String> = records.iter().map(Value::to_string).collect();
    assert!(3 * bytes(&lines) < bytes(&whole), "{} of {}", bytes(&lines), bytes(&whole));
    for seq in [1, 2, 3, 100, 199_usize] {
        let mut asked = Vec::new();
        let mut find_line = |seq: u64| {
            asked.push(seq);
            Ok::<_, ()>(lines.get(seq as usize - 1).cloned())
        };
        // The line is not a record, which shows only after its expansion.
        let error = LogReader::default().read_record(&lines[seq - 1], &mut find_line).expect_err("no record");
        let ReadError::Line(error) = error else { panic!("{error:?}") };
        assert!(error.to_string().contains("`new`"), "{error}");
        assert!(asked.len() <= 3, "record {seq} needs {asked:?}");
    }
}

/// Rules: LOG-4
#[test]
fn a_proof_covers_every_byte_of_every_line() {
    let proof = |lines: &[&str]| lines.iter().fold(FIRST_PROOF.to_owned(), |proof, line| next_proof(&proof, line));
    // printf '%064d%s' 0 abc | sha256sum
    assert_eq!(proof(&["abc"]), "b64374d04ef9c4f39fddb1e0d6be38a0130f6c057fc0f4ee467ea0e18bc758f1");
    let lines = compacted(&long_records());
    let mut reader = LogReader::default();
    for line in &lines {
        reader.read(line).expect("a record");
    }
    assert_eq!(reader.proof(), proof(&[&lines[0], &lines[1]]));
    for planted in ["opId", "\"a\"", "Ada", "\"timeMs\":1"] {
        let changed = lines[1].replacen(planted, &planted.replace(['1', 'A', 'a', 'I'], "7"), 1);
        assert_ne!(changed, lines[1], "{planted}");
        assert_ne!(reader.proof(), proof(&[&lines[0], &changed]), "{planted}");
    }
}
