//! Each item that a crate gives to others has a comment. Fields and variants whose names say all have none.

use std::collections::BTreeSet;

use crate::sources::{Source, sources, words};

const KINDS: &[&str] = &["fn ", "const fn ", "struct ", "enum ", "trait ", "type ", "const ", "static ", "union "];

/// The name of the public item that a line begins, if it begins one.
fn public_item(line: &str) -> Option<&str> {
    let rest = line.strip_prefix("pub ")?;
    let kind = KINDS.iter().find(|kind| rest.starts_with(**kind))?;
    words(&rest[kind.len()..]).next()
}

/// Words of a crate's `pub use`, and its public modules.
fn given(root: &str) -> (BTreeSet<&str>, BTreeSet<&str>) {
    let uses = root.split("pub use ").skip(1).filter_map(|rest| rest.split(';').next());
    let modules = root.lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'));
    (uses.flat_map(words).collect(), modules.collect())
}

/// Public items of a crate without a comment: those that its root gives on, and those of its public modules.
fn undocumented(root: &str, files: &[&Source]) -> Vec<String> {
    let (names, modules) = given(root);
    let mut found = Vec::new();
    for source in files {
        let is_public = |module: &&str| source.path.contains(&format!("/src/{module}"));
        let in_public_module = modules.iter().any(is_public);
        let lines: Vec<&str> = source.text.lines().collect();
        for (index, line) in lines.iter().enumerate() {
            let Some(name) = public_item(line) else { continue };
            let above =
                lines[..index].iter().rev().find(|line| !line.starts_with([' ', ')']) && !line.starts_with("#["));
            let is_documented = above.is_some_and(|line| line.starts_with("///"));
            if (in_public_module || names.contains(name)) && !is_documented {
                found.push(format!("{}: {name}", source.path));
            }
        }
    }
    found
}

#[test]
fn public_items_of_crates_are_documented() {
    let sources = sources(&["crates", "protocol/src"], &["rs"]);
    let mut crates = 0;
    for root in sources.iter().filter(|source| source.path.ends_with("/src/lib.rs")) {
        let folder = root.path.trim_end_matches("lib.rs");
        let files: Vec<_> = sources.iter().filter(|source| source.path.starts_with(folder)).collect();
        assert!(root.text.starts_with("//! "), "{} says what the crate is for", root.path);
        assert_eq!(undocumented(&root.text, &files), [""; 0]);
        crates += 1;
    }
    assert!(crates >= 17, "{crates} crates");
    let planted = Source {
        path: "crates/a/src/b.rs".into(),
        text: "/// Told.\n#[derive(Debug)]\npub struct A {\n    pub x: u8,\n}\n\npub fn bare() {}\npub fn hidden() {}"
            .into(),
    };
    assert_eq!(undocumented("pub use b::{A, bare};", &[&planted]), ["crates/a/src/b.rs: bare"]);
}
