//! Lines of a log file, one by one.

use protocol::{Checkpoint, LogHeader, LogLine};

const RECORD: &str = r#"{"format":1,"seq":1,"timeMs":1790000000000,"actor":{"id":"a","name":"Ada"},"opId":"x","action":{"type":"undo","scope":"mine","target":5,"skipped":["light 1's radius has been changed since"]},"changes":[{"type":"lightParameter","light":1,"old":{"coneAngle":25.0},"new":{"coneAngle":30.5}}]}"#;

/// Rules: LOG-1
#[test]
fn lines_are_written_as_they_are_read() {
    let header = r#"{"format":1,"session":"main"}"#;
    assert_eq!(LogHeader::parse(header).expect("a header").to_json(), header);
    let hash = "ab".repeat(32);
    let checkpoint = format!(r#"{{"checkpoint":{{"seq":7,"hash":"{hash}"}}}}"#);
    let line = LogLine::parse(&checkpoint).expect("a checkpoint");
    assert_eq!(line, LogLine::Checkpoint(Checkpoint { seq: 7, hash }));
    assert_eq!(line.to_json(), checkpoint);
    assert_eq!(LogLine::parse(RECORD).expect("a record").to_json(), RECORD);
}

/// Rules: LOG-1, REC-5
#[test]
fn other_lines_are_refused_by_what_is_wrong() {
    let refused = |text: &str, expected: &str| {
        let said = LogLine::parse(text).expect_err(text).to_string();
        assert!(said.contains(expected), "{text}: {said}");
    };
    refused("", "EOF");
    refused("{", "EOF");
    refused("[]", "");
    refused(&format!("{RECORD}{RECORD}"), "trailing");
    refused(&RECORD.replace("\"seq\":1", "\"seq\":-1"), "seq");
    refused(&RECORD.replace("\"opId\"", "\"opID\""), "`opID`");
    refused(&RECORD.replace("30.5", "\"30.5\""), "changes[0]");
    refused(&RECORD.replace("\"target\":5", "\"target\":5,\"gobo\":1"), "`gobo`");
    refused(&RECORD.replace("{\"format\":1,", "{"), "format");
    refused(r#"{"checkpoint":{"seq":7}}"#, "hash");
    refused(r#"{"checkpoint":{"seq":7,"hash":"","gobo":1}}"#, "`gobo`");
    LogHeader::parse(r#"{"format":1}"#).expect_err("no session");
    let later = LogHeader::parse(r#"{"format":2,"session":"main"}"#).expect_err("a later format").to_string();
    assert!(later.contains("format 2"), "{later}");
}
