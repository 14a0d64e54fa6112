//! Reads the repository's own text, for tests of it.

use std::path::Path;

pub struct Source {
    /// Path from the root of the repository.
    pub path: String,
    pub text: String,
}

/// Folder of the repository.
pub fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the repository")
}

/// Reads the files in `folders` of the repository and their subfolders whose names end in one of `extensions`, sorted
/// by path.
pub fn sources(folders: &[&str], extensions: &[&str]) -> Vec<Source> {
    let mut sources = Vec::new();
    for folder in folders {
        read(repository(), &repository().join(folder), extensions, &mut sources);
    }
    sources.sort_by(|a, b| a.path.cmp(&b.path));
    sources
}

/// Words of a text: identifiers, keywords and numbers.
pub fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty())
}

fn read(root: &Path, folder: &Path, extensions: &[&str], into: &mut Vec<Source>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.map(|entry| entry.expect("an entry").path()) {
        if path.is_dir() {
            read(root, &path, extensions, into);
        } else if path.extension().is_some_and(|e| extensions.iter().any(|extension| e == *extension))
            && let Ok(text) = std::fs::read_to_string(&path)
        {
            let path = path.strip_prefix(root).expect("a path below the root").display().to_string();
            into.push(Source { path, text });
        }
    }
}
