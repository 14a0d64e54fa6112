//! Tests that every rule of `protocol/SPEC.md` is cited by a test, and that tests of the protocol cite rules.
//!
//! A test cites rules in a line of its comment: `Rules: SOCK-1, HTTP-2`.

use std::collections::BTreeSet;

use crate::sources::{Source, sources};

/// Folders in which every test must cite a rule.
const OF_THE_PROTOCOL: &[&str] = &["crates/edit/tests/", "crates/server/tests/", "tests/sessions/"];

/// Folders that are searched for citations.
const SOURCES: &[&str] = &["crates", "protocol", "tests", "web-client/test"];

/// Ids that `spec` defines, such as **REC-1**.
fn rules(spec: &str) -> BTreeSet<&str> {
    spec.split("**").skip(1).step_by(2).filter(|word| is_rule(word)).collect()
}

fn is_rule(word: &str) -> bool {
    word.split_once('-').is_some_and(|(section, number)| {
        section.len() > 1
            && section.bytes().all(|b| b.is_ascii_uppercase())
            && !number.is_empty()
            && number.bytes().all(|b| b.is_ascii_digit())
    })
}

/// Rules that a comment line cites; `None` if it cites none.
fn citation(line: &str) -> Option<impl Iterator<Item = &str>> {
    let comment = line.trim_start().strip_prefix("//")?.trim_start_matches(['/', '!']).trim_start();
    let list = comment.strip_prefix("Rules: ")?;
    Some(list.split(',').map(|id| id.trim().trim_end_matches('.')))
}

/// Names of tests in Rust source that cite no rule.
fn uncited(text: &str) -> Vec<&str> {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let is_test = |line: &str| line.starts_with("#[test]") || line.starts_with("#[tokio::test");
    let cites = |index: usize| {
        let mut above = lines[..index].iter().rev().take_while(|line| line.starts_with("//") || line.starts_with("#["));
        above.any(|line| citation(line).is_some())
    };
    let uncited = (0..lines.len()).filter(|&index| is_test(lines[index]) && !cites(index));
    uncited.map(|index| lines[index..].iter().copied().find(|line| line.contains("fn ")).unwrap_or_default()).collect()
}

/// Returns a sentence for each fault.
fn problems(spec: &str, sources: &[Source]) -> Vec<String> {
    let rules = rules(spec);
    let mut wrong = Vec::new();
    let mut cited = BTreeSet::new();
    for Source { path, text } in sources {
        for id in text.lines().filter_map(citation).flatten() {
            if !rules.contains(id) {
                wrong.push(format!("{path} cites {id}, which protocol/SPEC.md does not define"));
            }
            cited.insert(id);
        }
        if OF_THE_PROTOCOL.iter().any(|folder| path.starts_with(folder)) {
            wrong.extend(uncited(text).iter().map(|test| format!("{path}: `{test}` cites no rule")));
        }
    }
    wrong.extend(rules.iter().filter(|id| !cited.contains(*id)).map(|id| format!("no test shows {id}")));
    wrong
}

#[test]
fn every_rule_is_shown_and_every_citation_is_of_a_rule() {
    let spec = include_str!("../protocol/SPEC.md");
    assert!(rules(spec).len() > 50, "the rules are found");
    let mut sources = sources(SOURCES, &["rs", "ts", "mjs"]);
    // This file's own examples are not citations.
    sources.retain(|source| source.path != "tests/rules.rs");
    let wrong = problems(spec, &sources);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn planted_omissions_are_caught() {
    let source = |path: &str, text: &str| Source { path: path.into(), text: text.into() };
    let spec = "- **ABC-1** One.\n- **ABC-2** Two.";
    let sound = "/// Shows both.\n/// Rules: ABC-1, ABC-2\n#[test]\nfn both() {}\n";
    assert_eq!(problems(spec, &[source("crates/edit/tests/a.rs", sound)]), [""; 0]);

    let caught = |path: &str, text: &str, expected: &str| {
        let wrong = problems(spec, &[source("tests/sessions/sound.rs", sound), source(path, text)]);
        assert!(wrong.iter().any(|sentence| sentence.contains(expected)), "{expected}: {wrong:?}");
    };
    caught("crates/x/tests/a.rs", "// Rules: ABC-3", "cites ABC-3");
    caught("tests/sessions/a.rs", "#[test]\nfn silent() {}", "`fn silent() {}` cites no rule");
    caught("crates/edit/tests/a.rs", "/// Rules: ABC-1\nfn helper() {}\n\n#[test]\nfn silent() {}", "silent");
    let unshown = problems(spec, &[source("a.rs", "/// Rules: ABC-1")]);
    assert_eq!(unshown, ["no test shows ABC-2"]);
}
