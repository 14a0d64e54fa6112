//! Tests that need more than a checkout are ignored and state their need, so that their absence is visible; `make test`
//! runs them.
//!
//! A test must not pass because something is missing, by `println!("skipped")` and a return.

use crate::sources::sources;

/// Needs of ignored tests, and the word in the test's name by which `make test` skips it if the need is missing.
const NEEDS: &[(&str, &str)] = &[
    ("needs ../shared/assets", "shared_assets"),
    ("needs strace", ""),
    ("needs systemd-analyze", ""),
    ("needs jq: make test-packages", ""),
    ("needs Python", ""),
    ("needs nginx and Caddy", ""),
    ("needs the page and a browser: make page test-packages", ""),
    ("needs the tools for OpenAPI: make openapi-tools", ""),
    ("the child of ", "child_that_"),
];

/// Returns a sentence for each test of `text` that `make test` would not run correctly.
fn faults(text: &str) -> Vec<String> {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let mut faults = Vec::new();
    for (index, line) in lines.iter().enumerate() {
        if line.starts_with("println!(\"skipped") {
            faults.push(format!("{line}: ignore the test, and say what it needs"));
        }
        let Some(reason) = line.strip_prefix("#[ignore") else { continue };
        let reason = reason.trim_start_matches(" = \"");
        let name = lines[index..].iter().find_map(|line| line.split_once("fn ")).unwrap_or_default().1;
        match NEEDS.iter().find(|(need, _)| reason.starts_with(need)) {
            None => faults.push(format!("{name}: `make test` does not know what `{reason}` asks for")),
            Some((_, word)) if !name.contains(word) => {
                faults.push(format!("{name}: must be called ..{word}.."));
            }
            Some(_) => {}
        }
    }
    faults
}

#[test]
fn ignored_tests_state_their_needs_and_make_test_runs_them() {
    let (mut ignored, mut faulty) = (0, Vec::new());
    for source in sources(&["crates", "protocol", "tests"], &["rs"]) {
        ignored += source.text.lines().filter(|line| line.trim().starts_with("#[ignore")).count();
        faulty.extend(faults(&source.text).into_iter().map(|fault| format!("{}: {fault}", source.path)));
    }
    assert!(ignored > 20, "{ignored} are ignored");
    assert_eq!(faulty, [""; 0]);
    let makefile = include_str!("../../Makefile");
    let ignored = makefile.lines().find(|line| line.contains("cargo test") && line.contains("--include-ignored"));
    let ignored = ignored.expect("make test runs what is ignored");
    assert!(ignored.contains("--workspace") && ignored.contains("--skip child_that_ "), "{ignored}");

    let planted = "#[ignore]\nfn a() {}\n#[ignore = \"needs luck\"]\nfn b() {}\n#[ignore = \"needs ../shared/assets\"]\n\
                   fn c() {}\n    println!(\"skipped: no file\");\n#[ignore = \"needs strace\"]\nfn d() {}";
    assert_eq!(faults(planted).len(), 4, "{:?}", faults(planted));
}
