//! Comments begin with a noun or a verb: the rules of docs/glossary.md.

use super::our_sources;

/// Words that begin no comment.
const REFUSED_OPENINGS: &[&str] = &["What", "Whether", "How", "Where", "Which", "Who", "Of", "As"];

/// First word of the comment that begins in a line, if one does. `before` is the line before it.
fn opening<'a>(before: &str, line: &'a str) -> Option<&'a str> {
    let is_continued = before.starts_with("//") && !before.trim_start_matches(['/', '!']).is_empty();
    let text = if before.ends_with("/**") {
        line.strip_prefix("* ")?
    } else if line.starts_with("//") && is_continued {
        return None;
    } else {
        let start = line.find("//").into_iter().chain(line.find("/*")).min()?;
        line[start..].trim_start_matches(['/', '*', '!']).trim_start()
    };
    text.split(|c: char| !c.is_alphanumeric()).next()
}

/// Lines in which a comment begins with a refused word.
fn faults(text: &str) -> Vec<&str> {
    let lines = || text.lines().map(str::trim);
    let pairs = std::iter::once("").chain(lines()).zip(lines());
    let is_refused =
        |(before, line): &(&str, &str)| opening(before, line).is_some_and(|word| REFUSED_OPENINGS.contains(&word));
    pairs.filter(is_refused).map(|(_, line)| line).collect()
}

#[test]
fn comments_begin_with_a_noun_or_a_verb() {
    for source in our_sources() {
        assert_eq!(faults(&source.text), [""; 0], "{}", source.path);
    }
    let planted = "// What is drawn.\n// Of it nothing.\n//\n// As before.\n/** Whether it is. */\n/**\n * How it goes.\n * Who\n */\n\
                   {/* Where it is. */}\nlet a = b; // Which one.\n/// Whatever is left.\n// Tells\n// What it is.\n//! Who asks.";
    let caught = [
        "// What is drawn.",
        "// As before.",
        "/** Whether it is. */",
        "* How it goes.",
        "{/* Where it is. */}",
        "let a = b; // Which one.",
    ];
    assert_eq!(faults(planted), caught);
    assert_eq!(faults("fn f() {}\n//! Who asks."), ["//! Who asks."]);
}
