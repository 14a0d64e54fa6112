//! Comments that repeat a name say nothing, and hide from `missing_docs` that nothing is said.
//!
//! Where a field's name says all, its type has `#[expect(missing_docs, reason = "...")]`.

use crate::sources::sources;

/// Whole comments that say nothing.
const EMPTY: &[&str] = &[
    "Which.",
    "Which one.",
    "Which light.",
    "Who.",
    "Whose.",
    "Why.",
    "Why not.",
    "When.",
    "How many.",
    "How much.",
    "Before.",
    "After.",
    "See above.",
    "Of which.",
    "Of which light.",
    "Of what.",
    "Its id.",
    "Its index.",
    "Its name.",
    "Its number.",
    "Its record.",
    "The actor.",
    "The camera.",
    "The command.",
    "The document.",
    "The law.",
    "The light.",
    "The parameter.",
    "The program.",
    "The record.",
    "The scene.",
];

/// How many there still are. It only gets smaller.
const LEFT: usize = 74;

/// The numbers of `text`'s lines that are a comment by themselves, and an empty one.
fn empty(text: &str) -> Vec<usize> {
    let comment = |line: &str| line.trim_start().strip_prefix("///").map(|comment| comment.trim().to_owned());
    let comments: Vec<Option<String>> = text.lines().map(comment).collect();
    let is_alone = |index: usize| {
        let before = index.checked_sub(1).and_then(|before| comments[before].as_ref());
        before.is_none() && comments.get(index + 1).is_none_or(Option::is_none)
    };
    let says_nothing =
        |index: &usize| comments[*index].as_deref().is_some_and(|comment| EMPTY.contains(&comment));
    (0..comments.len()).filter(says_nothing).filter(|index| is_alone(*index)).map(|index| index + 1).collect()
}

#[test]
fn comments_say_something() {
    let sources = sources(&["crates", "protocol", "tests"], &["rs"]);
    let said = |source: &crate::sources::Source| {
        empty(&source.text).into_iter().map(|line| format!("{}:{line}", source.path)).collect::<Vec<_>>()
    };
    let nothing: Vec<String> = sources.iter().flat_map(said).collect();
    assert!(
        nothing.len() <= LEFT,
        "{} comments say nothing, {LEFT} may:\n{}",
        nothing.len(),
        nothing.join("\n")
    );
    assert!(sources.len() > 300, "{} files", sources.len());
    let planted = "/// Which.\nlight: u64,\n/// Which.\n/// Counts from 1.\nline: u64,\n    /// The light.\n";
    assert_eq!(empty(planted), [1, 6]);
}
