//! Names are the field's: docs/glossary.md has the words, and some do not come back.

use std::collections::BTreeMap;

use super::our_sources;
use crate::sources::{Source, sources, words};

/// Words of identifiers that a newcomer would have to learn. docs/glossary.md says what to call each.
const GONE: &[&str] = &[
    "Place",
    "Shown",
    "Newcomer",
    "Spread",
    "stranger",
    "strangers",
    "deed",
    "deeds",
    "outrun",
    "glide",
    "gliding",
    "holed",
    "is_of_a_hand",
];

/// Identifiers of a line of code, without those in comments and strings.
fn identifiers(line: &str) -> impl Iterator<Item = &str> {
    // A line of a comment in TypeScript.
    let line = if line.trim_start().starts_with("* ") { "" } else { line };
    let code = [line.find("//"), line.find("/*")].into_iter().flatten().min().map_or(line, |start| &line[..start]);
    code.split('"').step_by(2).flat_map(|code| code.split('`').step_by(2)).flat_map(words)
}

/// True if an identifier is a word that is gone, or has one between underscores.
fn is_gone(identifier: &str) -> bool {
    GONE.iter().any(|gone| identifier == *gone || identifier.split('_').any(|word| word == *gone))
}

fn gone(text: &str) -> Vec<&str> {
    text.lines().flat_map(identifiers).filter(|identifier| is_gone(identifier)).collect()
}

/// Public types of libraries, by their names, with the files that have them.
fn public_types(sources: &[Source]) -> BTreeMap<&str, Vec<&str>> {
    let mut types: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    let of_library =
        |path: &str| path.contains("/src/") && !path.contains("crates/bendylights") && !path.contains("/commands/");
    for source in sources.iter().filter(|source| of_library(&source.path)) {
        for line in source.text.lines() {
            let keywords = ["pub struct ", "pub enum ", "pub trait ", "pub type ", "pub union "];
            let Some(rest) = keywords.iter().find_map(|keyword| line.strip_prefix(keyword)) else { continue };
            let name = words(rest).next().unwrap_or_default();
            types.entry(name).or_default().push(&source.path);
        }
    }
    types
}

/// Names of several types that are not one thing of the domain and its wire form.
fn shared<'a>(types: &BTreeMap<&'a str, Vec<&str>>) -> Vec<&'a str> {
    let is_pair =
        |files: &[&str]| files.len() == 2 && files.iter().filter(|file| file.starts_with("protocol/")).count() == 1;
    types.iter().filter(|(_, files)| files.len() > 1 && !is_pair(files)).map(|(name, _)| *name).collect()
}

#[test]
fn no_two_public_types_share_a_name_but_domain_and_wire() {
    let sources = sources(&["crates", "protocol"], &["rs"]);
    let types = public_types(&sources);
    assert!(types.len() > 400, "{} types", types.len());
    assert_eq!(shared(&types), [""; 0]);

    let planted = [
        Source { path: "crates/a/src/lib.rs".into(), text: "pub struct Light;\npub enum Kind {}".into() },
        Source { path: "protocol/src/light.rs".into(), text: "pub struct Light {}".into() },
        Source { path: "crates/b/src/lib.rs".into(), text: "pub(crate) struct Kind;\npub type Kind = u8;".into() },
    ];
    assert_eq!(shared(&public_types(&planted)), ["Kind"]);
}

#[test]
fn words_that_are_gone_stay_away() {
    for source in our_sources() {
        assert_eq!(gone(&source.text), [""; 0], "{}", source.path);
    }
    let planted =
        "let holed = 1; // deed\nstruct Place;\nfn is_of_a_hand() { \"strangers\" }\nlet a_deed_done = placed;";
    assert_eq!(gone(planted), ["holed", "Place", "is_of_a_hand", "a_deed_done"]);
    let of_typescript =
        "/** A deed. */\n * its deeds\ninterface Shown { key: `outrun ${by}`; deed: Place } /* holed */";
    assert_eq!(gone(of_typescript), ["Shown", "deed", "Place"]);
    assert_eq!(gone("fn deed_of(glide: f32) -> f32 { // Spread"), ["deed_of", "glide"]);
}
