//! Tests that `--help` has examples, and that README and docs show only existing commands and options.

use crate::program::printed;

const COMMANDS: [&str; 15] = [
    "render",
    "eval",
    "bend",
    "drag",
    "probe",
    "parameters",
    "scenes",
    "example",
    "serve",
    "sessions",
    "backup",
    "export",
    "import",
    "replay",
    "bench",
];

#[test]
fn help_names_every_command_and_shows_examples() {
    let text = printed(&["--help"]);
    for command in COMMANDS {
        assert!(text.contains(&format!("  {command} ")), "{command}");
        assert!(printed(&[command, "--help"]).contains("Usage: bendylights "), "{command}");
    }
    for command in ["render", "eval", "bend", "drag", "probe", "serve", "sessions", "export", "import", "replay"] {
        assert!(printed(&[command, "--help"]).contains("Example"), "{command}");
    }
    assert!(printed(&["--version"]).starts_with("bendylights 0."));
}

/// Returns the faults of the commands in `text`, each on a line that starts with `bendylights`.
fn unknown_words(text: &str) -> Vec<String> {
    let lines = text.lines().map(str::trim).filter(|line| line.starts_with("bendylights "));
    lines
        .flat_map(|line| {
            let mut words = line.split_whitespace().skip(1).map(|word| word.trim_matches(['[', ']']));
            let command = words.next().unwrap_or_default();
            if !COMMANDS.contains(&command) {
                return vec![format!("{line}: no command {command}")];
            }
            let kind = words.clone().next().filter(|kind| command == "bench" && !kind.starts_with('-'));
            let known = printed(&[Some(command), kind, Some("--help")].into_iter().flatten().collect::<Vec<_>>());
            let options = words.filter(|word| word.starts_with('-') && word.len() > 1);
            let unknown = options.filter(|option| !known.contains(&format!("{option} ")));
            unknown.map(|option| format!("{line}: no option {option}")).collect()
        })
        .collect()
}

#[test]
fn readme_and_docs_show_commands_that_exist() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let docs = std::fs::read_dir(format!("{root}/docs")).expect("a folder");
    let mut pages: Vec<_> = docs.map(|page| page.expect("a page").path()).collect();
    pages.push(format!("{root}/README.md").into());
    let mut count = 0;
    for page in pages.iter().filter(|page| page.extension().is_some_and(|extension| extension == "md")) {
        let text = std::fs::read_to_string(page).expect("text");
        count += text.lines().filter(|line| line.trim().starts_with("bendylights ")).count();
        assert_eq!(unknown_words(&text), [""; 0], "{}", page.display());
    }
    assert!(count >= 30, "{count} commands");
    let planted = "bendylights render demo:vases --quality 3 -o out.png\nbendylights paint";
    assert_eq!(unknown_words(planted).len(), 2);
}
