//! Tests that files of a crate import each other in no circle, except a few pairs: a file can be understood without the
//! files that use it.
//!
//! The test reads text: `use` with its trees, and paths that begin with `crate` or `super`. A name that a module
//! re-exports with `pub use` counts as an import of its origin. A module and those within it may name each other.

use std::collections::{BTreeMap, BTreeSet};

use crate::sources::{repository, sources};

/// Pairs of files that import each other. No crate has any other circle.
const PAIRS: &[&str] =
    &["assets: fault, limits", "edit: session, undo", "light: light, parameters", "stream: error, frame"];

/// Path of a module within its crate; empty for the crate itself.
type Module = Vec<String>;
/// Source of each module, without its tests.
type Crate = BTreeMap<Module, String>;
type Imports = BTreeMap<Module, BTreeSet<Module>>;

/// Reads the crate in a folder of the repository.
fn read(folder: &str) -> Crate {
    let folder = format!("{folder}/src/");
    let module = |path: &str| {
        let names = path.trim_start_matches(&*folder).trim_end_matches(".rs").split('/');
        names.filter(|name| !["lib", "main", "mod"].contains(name)).map(str::to_owned).collect()
    };
    sources(&[&folder], &["rs"]).iter().map(|file| (module(&file.path), source(&file.text))).collect()
}

/// Text of a file without comments and without its module of tests.
fn source(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// Paths of a `use`, with its trees expanded.
fn paths(tree: &str) -> Vec<Vec<String>> {
    let (before, inner) = match tree.split_once('{') {
        None => {
            let path = tree.split(" as ").next().unwrap_or_default();
            return vec![path.split("::").map(|name| name.trim().to_owned()).collect()];
        }
        Some((before, rest)) => (before, rest.rsplit_once('}').map_or(rest, |(inner, _)| inner)),
    };
    let before: Vec<String> =
        before.split("::").map(str::trim).filter(|name| !name.is_empty()).map(str::to_owned).collect();
    let (mut depth, mut parts) = (0_i32, vec![String::new()]);
    for letter in inner.chars() {
        depth += i32::from(letter == '{') - i32::from(letter == '}');
        if letter == ',' && depth == 0 {
            parts.push(String::new());
        } else if let Some(part) = parts.last_mut() {
            part.push(letter);
        }
    }
    let named = parts.iter().map(|part| part.trim()).filter(|part| !part.is_empty());
    named.flat_map(paths).map(|path| [&before[..], &path].concat()).collect()
}

/// Trees of the `use` items in `text`. The flag is true for re-exports.
fn uses(text: &str) -> Vec<(bool, &str)> {
    let starts = ["use ", "pub use ", "pub(crate) use ", "pub(super) use "];
    let mut found = Vec::new();
    for (at, line) in text.lines().map(|line| (line.as_ptr() as usize - text.as_ptr() as usize, line)) {
        let indent = line.len() - line.trim_start().len();
        if let Some(start) = starts.iter().find(|start| line.trim_start().starts_with(**start)) {
            let tree = text[at + indent + start.len()..].split(';').next().unwrap_or_default();
            found.push((*start != "use ", tree));
        }
    }
    found
}

/// Paths in `text` that begin with `crate` or `super`, outside of `use`.
fn inline_paths(text: &str) -> Vec<Vec<String>> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let words = text.split(|c| !is_part(c)).filter(|word| word.contains("::"));
    words
        .map(|word| word.split("::").map(str::to_owned).collect::<Vec<_>>())
        .filter(|path| path[0] == "crate" || path[0] == "super")
        .collect()
}

/// Module to which a path in `module` leads; `None` outside of the crate.
fn resolve(modules: &Crate, module: &Module, path: &[String]) -> Option<Module> {
    let (mut base, mut rest) = (module.clone(), path);
    match path.first()?.as_str() {
        "crate" => (base, rest) = (Vec::new(), &path[1..]),
        "self" => rest = &path[1..],
        "super" => {
            while rest.first().is_some_and(|name| name == "super") {
                base.pop();
                rest = &rest[1..];
            }
        }
        name => drop(modules.get(&[&base[..], &[name.to_owned()]].concat())?),
    }
    while let Some(name) = rest.first() {
        let inner = [&base[..], std::slice::from_ref(name)].concat();
        if !modules.contains_key(&inner) {
            let given_on = uses(&modules[&base]).into_iter().filter(|(is_given_on, _)| *is_given_on);
            let mut origins = given_on.flat_map(|(_, tree)| paths(tree)).filter(|path| path.last() == Some(name));
            return origins.next().and_then(|path| resolve(modules, &base, &path)).or(Some(base));
        }
        (base, rest) = (inner, &rest[1..]);
    }
    Some(base)
}

fn imports(modules: &Crate) -> Imports {
    let mut imports = Imports::new();
    for (module, text) in modules {
        let used = uses(text).into_iter().flat_map(|(_, tree)| paths(tree)).chain(inline_paths(text));
        let named = used.filter_map(|path| resolve(modules, module, &path));
        // A module may name those that contain it.
        imports.insert(module.clone(), named.filter(|named| !module.starts_with(named)).collect());
    }
    imports
}

/// Circles: sets of modules that reach each other, sorted.
fn circles(imports: &Imports) -> BTreeSet<Vec<String>> {
    fn reached<'a>(imports: &'a Imports, start: &'a Module) -> BTreeSet<&'a Module> {
        let (mut seen, mut open) = (BTreeSet::new(), vec![start]);
        while let Some(module) = open.pop() {
            open.extend(imports.get(module).into_iter().flatten().filter(|next| seen.insert(*next)));
        }
        seen
    }
    let reached: BTreeMap<_, _> = imports.keys().map(|module| (module, reached(imports, module))).collect();
    let circle = |module: &Module| {
        let others =
            reached.iter().filter(|(other, reach)| reach.contains(module) && reached[module].contains(**other));
        others.map(|(other, _)| other.join("::")).collect::<Vec<_>>()
    };
    imports.keys().map(circle).filter(|circle| !circle.is_empty()).collect()
}

#[test]
fn files_import_each_other_in_no_circle() {
    let crates = std::fs::read_dir(repository().join("crates")).expect("a folder");
    let names = crates.map(|entry| entry.expect("an entry").file_name().into_string().expect("a name"));
    let folders = names.map(|name| format!("crates/{name}")).chain(["protocol".into()]);
    let mut found = BTreeSet::new();
    for folder in folders {
        let imports = imports(&read(&folder));
        assert!(imports.values().any(|of_module| !of_module.is_empty()), "{folder} has imports");
        let name = folder.trim_start_matches("crates/");
        found.extend(circles(&imports).into_iter().map(|circle| format!("{name}: {}", circle.join(", "))));
    }
    assert_eq!(found, PAIRS.iter().map(|&pair| pair.to_owned()).collect());
}

#[test]
fn planted_circles_are_caught() {
    let planted = |sources: &[(&str, &str)]| {
        let module = |name: &str| name.split("::").filter(|part| !part.is_empty()).map(str::to_owned).collect();
        let modules: Crate = sources.iter().map(|(name, text)| (module(name), source(text))).collect();
        circles(&imports(&modules)).into_iter().flatten().collect::<Vec<_>>()
    };
    let root = ("", "mod a;\nmod b;\nmod c;\npub use b::{\n    Thing, Other as Another,\n};");
    let none: [&str; 0] = [];
    assert_eq!(planted(&[root, ("a", "use crate::b::Thing;"), ("b", "struct Thing;")]), none);
    assert_eq!(planted(&[root, ("a", "use crate::b::Thing;"), ("b", "use super::a;")]), ["a", "b"]);
    let through_root = [root, ("a", "use crate::{c::{self, X}, Thing};"), ("b", "fn f() -> crate::a::Y {}"), ("c", "")];
    assert_eq!(planted(&through_root), ["a", "b"], "what the root gives on is where it comes from");
    let of_three = [root, ("a", "use crate::b;"), ("b", "    pub(super) use crate::c::Z;"), ("c", "use crate::a;")];
    assert_eq!(planted(&of_three), ["a", "b", "c"]);
    let family = [root, ("a", "mod d;\nuse d::D;"), ("a::d", "use super::A;\nuse crate::b;"), ("b", ""), ("c", "")];
    assert_eq!(planted(&family), none, "a module and those within it are one");
    let in_words =
        [root, ("a", "// use crate::b;\nuse std::a;"), ("b", "use crate::a;\n#[cfg(test)]\nmod tests {}"), ("c", "")];
    assert_eq!(planted(&in_words), none, "comments import nothing");
}

/// One folder of the store contains all code that names SQLite, so another database could replace that folder.
#[test]
fn sqlite_is_named_in_one_folder() {
    let others = |name: &str| -> Vec<String> {
        let modules = read(&format!("crates/{name}"));
        let says = modules.iter().filter(|(_, text)| text.contains("rusqlite") || text.contains("SELECT "));
        let named = says.map(|(module, _)| module.join("::"));
        named.filter(|module| module.split("::").next() != Some("sqlite")).collect()
    };
    assert_eq!([others("store"), others("server"), others("bendylights")], [const { Vec::<String>::new() }; 3]);
    let modules = read("crates/store");
    assert!(modules[&vec!["sqlite".to_owned()]].contains("rusqlite"), "where it is, it is found");
}
