//! Prose in Markdown has one width, and what ARCHITECTURE.md points at is there.
//!
//! `BENDYLIGHTS_BLESS=1 cargo test --workspace --test conventions` wraps it.

use std::path::Path;

/// Characters of a line. Only what cannot be broken (a table's row, an address, code) may be longer.
const WIDTH: usize = 120;

/// A paragraph or an item of a list.
struct Paragraph {
    /// What its first line begins with.
    first: String,
    /// What its other lines begin with.
    rest: String,
    words: Vec<String>,
}

/// `text` with its paragraphs and list items filled to [`WIDTH`]; headings, tables and code as they stand.
fn wrapped(text: &str) -> String {
    let mut done = String::new();
    let mut open: Option<Paragraph> = None;
    let mut in_fence = false;
    for line in text.lines() {
        let content = line.trim_start();
        let indent = &line[..line.len() - content.len()];
        let is_fence = content.starts_with("```");
        let is_fixed = content.is_empty() || content.starts_with(['#', '|']);
        let is_code = open.is_none() && indent.len() >= 4;
        if in_fence || is_fence || is_fixed || is_code {
            fill(&mut done, open.take());
            in_fence ^= is_fence;
            done += line.trim_end();
            done.push('\n');
            continue;
        }
        let marker = marker(content);
        if !marker.is_empty() {
            fill(&mut done, open.take());
            let first = format!("{indent}{marker}");
            open = Some(Paragraph { rest: " ".repeat(first.len()), first, words: Vec::new() });
        }
        let paragraph = open.get_or_insert_with(|| {
            let indent = indent.to_owned();
            Paragraph { first: indent.clone(), rest: indent, words: Vec::new() }
        });
        paragraph.words.extend(content[marker.len()..].split_whitespace().map(str::to_owned));
    }
    fill(&mut done, open);
    done
}

/// The `- ` or `12. ` that makes a line an item of a list.
fn marker(content: &str) -> &str {
    let digits = content.len() - content.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let end = if digits > 0 && content[digits..].starts_with(". ") { digits + 2 } else { 0 };
    if content.starts_with("- ") { &content[..2] } else { &content[..end] }
}

fn fill(done: &mut String, paragraph: Option<Paragraph>) {
    let Some(Paragraph { first, rest, words }) = paragraph else { return };
    let mut line = first;
    let mut is_empty = true;
    for piece in pieces(&words) {
        if !is_empty && line.chars().count() + 1 + piece.chars().count() > WIDTH {
            *done += &line;
            done.push('\n');
            line.clone_from(&rest);
            is_empty = true;
        }
        if !is_empty {
            line.push(' ');
        }
        line += &piece;
        is_empty = false;
    }
    *done += &line;
    done.push('\n');
}

/// Words that stay on one line: those of a code span, and one that would mean something else at the start of a line.
fn pieces(words: &[String]) -> Vec<String> {
    let mut pieces: Vec<String> = Vec::new();
    let mut in_span = false;
    for word in words {
        let would_mark =
            !marker(&format!("{word} ")).is_empty() || word.starts_with(['#', '|', '+', '>', '*']);
        match pieces.last_mut() {
            Some(last) if in_span || would_mark && !word.starts_with("**") => {
                *last = format!("{last} {word}");
            }
            _ => pieces.push(word.clone()),
        }
        in_span ^= word.matches('`').count() % 2 == 1;
    }
    pieces
}

/// Paths of ARCHITECTURE.md in backticks that lead to a Rust, TypeScript or WGSL file, from the root or from `crates`.
fn missing(text: &str) -> Vec<&str> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the repository");
    let spans = text.split('`').skip(1).step_by(2);
    let paths = spans.filter(|span| {
        span.contains('/')
            && !span.contains('*')
            && [".rs", ".ts", ".wgsl", ".mjs"].iter().any(|e| span.ends_with(e))
    });
    paths.filter(|path| !root.join(path).is_file() && !root.join("crates").join(path).is_file()).collect()
}

#[test]
fn prose_is_wrapped_at_one_width() {
    let bless = std::env::var_os("BENDYLIGHTS_BLESS").is_some();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the repository");
    let mut seen = 0;
    for name in ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "protocol/SPEC.md"] {
        let text = std::fs::read_to_string(root.join(name)).expect(name);
        let expected = wrapped(&text);
        if bless {
            std::fs::write(root.join(name), &expected).expect(name);
        } else if let Some(line) = text.lines().zip(expected.lines()).position(|(is, should)| is != should) {
            let line = line + 1;
            panic!(
                "{name}:{line} is not wrapped at {WIDTH}: BENDYLIGHTS_BLESS=1 cargo test --workspace --test conventions"
            );
        }
        seen += text.lines().count();
    }
    assert!(seen > 800, "{seen} lines");
}

#[test]
fn wrapping_leaves_alone_what_is_no_prose() {
    let words = "word ".repeat(40).trim_end().to_owned();
    let kept = format!("# {words}\n\n    {words}\n\n| {words} |\n\n```\n{words}\n```\n");
    assert_eq!(wrapped(&kept), kept);
    let filled = wrapped(&format!("{words}\n\n- {words}\n  {words}\n1. {words}\n"));
    assert!(filled.lines().all(|line| line.len() <= WIDTH), "{filled}");
    assert!(filled.lines().filter(|line| line.starts_with("  word")).count() >= 3, "{filled}");
    assert_eq!(wrapped(&filled), filled, "twice is once");
    let edge = "word ".repeat(23);
    let held = wrapped(&format!("{edge}`a b c`\n\n{edge}xyzz - y\n\n{edge}xyzz 1. y\n"));
    assert!(
        held.contains("\n`a b c`\n") && held.contains("\nxyzz - y") && held.contains("\nxyzz 1. y"),
        "{held}"
    );
}

#[test]
fn the_map_leads_to_files_that_exist() {
    let text = include_str!("../../ARCHITECTURE.md");
    assert!(text.matches(".rs`").count() > 20);
    assert_eq!(missing(text), [""; 0]);
    assert_eq!(missing("`stream/src/pace.rs` or `stream/src/haste.rs`"), ["stream/src/haste.rs"]);
}
