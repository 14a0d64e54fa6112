//! Tests the command line with the real binary: `--help` teaches, answers are JSON, and errors are one sentence with an
//! exit code.

use std::process::{Command, Output};

use serde_json::Value;

const STUDIES: [&str; 2] = ["stress", "work"];

fn run(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bendylights-studies")).args(args).output().expect("the binary runs")
}

fn help(args: &[&str]) -> String {
    let done = run(&[args, &["--help"]].concat());
    assert!(done.status.success() && done.stderr.is_empty(), "{args:?}");
    String::from_utf8(done.stdout).expect("UTF-8")
}

/// Runs a study that ends with exit code `code`. Returns its JSON and its standard error.
fn answer(args: &[&str], code: i32) -> (Value, String) {
    let done = run(args);
    let said = String::from_utf8(done.stderr).expect("UTF-8");
    assert_eq!(done.status.code(), Some(code), "{args:?}: {said}");
    (serde_json::from_slice(&done.stdout).expect("JSON"), said)
}

#[test]
fn help_names_every_study_and_shows_examples() {
    let text = help(&[]);
    for study in STUDIES {
        assert!(text.contains(&format!("  {study} ")), "{study}");
        let of_study = help(&[study]);
        assert!(of_study.contains("Prints JSON") && of_study.contains("Example"), "{study}: {of_study}");
    }
}

/// Returns the words in commands of `text`, on lines that start with `bendylights-studies`, that are in no help text.
fn unknown_words(text: &str) -> Vec<String> {
    let lines = text.lines().filter_map(|line| line.trim().strip_prefix("bendylights-studies "));
    lines
        .flat_map(|line| {
            let mut words = line.split_whitespace();
            let study = words.next().unwrap_or_default();
            let known = if STUDIES.contains(&study) { help(&[study]) } else { String::new() };
            let options = words.filter(|word| word.starts_with('-'));
            let unknown = options.filter(|option| !known.contains(&format!("{option} ")));
            let none = known.is_empty().then(|| format!("no study {study}"));
            none.into_iter().chain(unknown.map(str::to_owned)).collect::<Vec<_>>()
        })
        .collect()
}

#[test]
fn the_docs_and_the_help_show_commands_that_exist() {
    let docs = include_str!("../../../docs/accuracy.md");
    assert!(docs.lines().filter(|line| line.trim().starts_with("bendylights-studies ")).count() >= 3);
    let helps: String = STUDIES.map(|study| help(&[study])).concat();
    for text in [docs, &helps, &help(&[])] {
        assert_eq!(unknown_words(text), [""; 0]);
    }
    assert_eq!(
        unknown_words("bendylights-studies stress --quick\nbendylights-studies paint"),
        ["--quick", "no study paint"]
    );
}

#[test]
fn a_property_that_does_not_hold_gives_its_case_and_exit_code_1() {
    let sound = ["stress", "--only", "joints", "--cases", "3"];
    let (report, _) = answer(&sound, 0);
    assert_eq!((&report["outcomes"][0]["cases"], &report["outcomes"][0]["failure"]), (&3.into(), &Value::Null));
    let (report, said) = answer(&[&sound[..], &["--planted"]].concat(), 1);
    let seed = &report["outcomes"][0]["failure"]["seed"];
    let again = format!("`bendylights-studies stress --only joints --seed {seed} --cases 1`");
    assert!(said.contains(&again) && said.lines().count() == 1, "{said}");
}

#[test]
fn bad_usage_exits_with_2_and_says_what_is_allowed() {
    for (args, must_say) in [
        (&["stress", "--only", "beauty"][..], "lone-plane"),
        (&["stress", "--minutes", "0"], "number of minutes"),
        (&["shadow"], "Usage"),
    ] {
        let done = run(args);
        let said = String::from_utf8(done.stderr).expect("UTF-8");
        assert_eq!((done.status.code(), done.stdout.is_empty()), (Some(2), true), "{args:?}: {said}");
        assert!(said.contains(must_say), "{args:?}: {said}");
    }
}
