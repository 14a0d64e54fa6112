//! Tests the layers of ARCHITECTURE.md with `cargo metadata`: the crates that each crate uses.
//!
//! Only shipped code counts: normal dependencies, direct and transitive, not those of tests and build scripts.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use cargo_metadata::{DependencyKind, MetadataCommand};

/// Rules for the dependencies of a crate of the workspace.
struct Layer {
    name: &'static str,
    /// Crates of the workspace that its manifest may name.
    uses: &'static [&'static str],
    /// Packages that it must not reach.
    never: &'static [&'static str],
    /// True if it may use no clock, IO or environment: it is a function of its arguments alone.
    pure: bool,
}

/// Packages that exist for studies alone: the program that users install must not contain them.
const OF_STUDIES: &[&str] = &["studies", "proptest"];

/// Packages that a crate without IO and wire form must not reach.
const NO_IO: &[&str] = &["tokio", "wgpu", "axum", "serde", "serde_core", "rand", "getrandom"];

const LAYERS: &[Layer] = &[
    Layer { name: "light", uses: &[], never: NO_IO, pure: true },
    Layer { name: "scene", uses: &["light"], never: NO_IO, pure: true },
    Layer { name: "hierarchy", uses: &[], never: NO_IO, pure: true },
    Layer { name: "document", uses: &["light", "scene", "raycast", "drag"], never: NO_IO, pure: true },
    Layer { name: "raycast", uses: &["light", "scene", "hierarchy"], never: NO_IO, pure: true },
    Layer { name: "drag", uses: &["light", "scene", "raycast"], never: NO_IO, pure: true },
    Layer {
        name: "reference",
        uses: &["light", "scene", "raycast"],
        never: &["tokio", "wgpu", "axum", "serde", "render"],
        pure: false,
    },
    Layer { name: "edit", uses: &["light", "scene", "document"], never: NO_IO, pure: true },
    Layer {
        name: "assets",
        uses: &["light", "scene", "document"],
        never: &["tokio", "wgpu", "axum", "protocol"],
        pure: false,
    },
    Layer { name: "relight", uses: &["light"], never: NO_IO, pure: false },
    Layer {
        name: "render",
        uses: &["light", "scene", "hierarchy", "relight"],
        never: &["tokio", "axum", "protocol"],
        pure: false,
    },
    Layer { name: "stream", uses: &[], never: &["tokio", "wgpu", "axum"], pure: false },
    Layer {
        name: "protocol",
        uses: &["light", "scene", "document", "edit", "drag", "reference"],
        never: &["tokio", "wgpu", "axum"],
        pure: false,
    },
    Layer {
        name: "store",
        uses: &["light", "scene", "document", "edit", "protocol"],
        never: &["tokio", "wgpu", "axum"],
        pure: false,
    },
    Layer {
        name: "server",
        uses: &[
            "light",
            "scene",
            "raycast",
            "drag",
            "reference",
            "document",
            "assets",
            "edit",
            "render",
            "store",
            "stream",
            "protocol",
        ],
        never: &["clap"],
        pure: false,
    },
    Layer {
        name: "bendylights",
        uses: &[
            "light",
            "scene",
            "document",
            "edit",
            "assets",
            "raycast",
            "drag",
            "reference",
            "render",
            "protocol",
            "store",
            "server",
            "bench",
            "cli",
        ],
        never: OF_STUDIES,
        pure: false,
    },
    Layer {
        name: "bench",
        uses: &["light", "scene", "raycast", "drag", "reference", "relight", "render", "protocol", "stream"],
        never: &["tokio", "axum"],
        pure: false,
    },
    Layer {
        name: "studies",
        uses: &[
            "light",
            "scene",
            "assets",
            "raycast",
            "drag",
            "reference",
            "relight",
            "render",
            "protocol",
            "bench",
            "cli",
        ],
        never: &["tokio", "axum"],
        pure: false,
    },
    Layer { name: "cli", uses: &["protocol"], never: &["tokio", "wgpu", "axum", "clap"], pure: false },
    Layer { name: "bendylights-tests", uses: &[], never: &[], pure: false },
];

/// Names that do not describe a crate.
const EMPTY_NAMES: &[&str] = &["util", "utils", "common", "core", "manager", "helpers", "misc"];

/// Words that the source of a pure crate must not contain.
const IMPURE: &[&str] = &[
    "std::time",
    "std::fs",
    "std::net",
    "std::env",
    "std::process",
    "std::thread",
    "SystemTime",
    "Instant::now",
    // Permission to call the functions that clippy.toml forbids: std's transcendental functions, whose bits differ
    // between machines.
    "disallowed_methods",
];

/// Names of packages, each with the names of the packages that it uses.
type Graph = BTreeMap<String, BTreeSet<String>>;

struct Workspace {
    members: BTreeMap<String, PathBuf>,
    uses: Graph,
}

fn workspace() -> Workspace {
    // One platform's dependencies are enough, and are the only ones that a build has downloaded.
    let platform = format!("{}-unknown-linux-gnu", std::env::consts::ARCH);
    let metadata = MetadataCommand::new()
        .manifest_path(concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml"))
        .other_options(["--locked".into(), "--filter-platform".into(), platform])
        .exec()
        .expect("cargo metadata");
    let members = metadata.workspace_packages().into_iter().map(|package| {
        let folder = package.manifest_path.parent().expect("a manifest lies in a folder");
        (package.name.to_string(), folder.as_std_path().to_owned())
    });
    let resolve = metadata.resolve.as_ref().expect("a dependency graph");
    let mut uses = Graph::new();
    for node in &resolve.nodes {
        let normal =
            node.deps.iter().filter(|dep| dep.dep_kinds.iter().any(|k| k.kind == DependencyKind::Normal));
        let names = normal.map(|dep| metadata[&dep.pkg].name.to_string());
        uses.entry(metadata[&node.id].name.to_string()).or_default().extend(names);
    }
    Workspace { members: members.collect(), uses }
}

/// Returns a sentence for each broken rule.
fn violations(members: &[&str], uses: &Graph) -> Vec<String> {
    let mut broken = Vec::new();
    for &name in members {
        if name.split(['-', '_']).any(|word| EMPTY_NAMES.contains(&word)) {
            broken.push(format!("{name}: the name says nothing about what it is for"));
        }
        let Some(layer) = LAYERS.iter().find(|layer| layer.name == name) else {
            broken.push(format!("{name}: has no layer: say in LAYERS what it may use"));
            continue;
        };
        for used in members.iter().filter(|used| uses[name].contains(**used) && !layer.uses.contains(used)) {
            broken.push(format!("{name}: must not use {used}"));
        }
        for (reached, path) in reach(name, uses) {
            if layer.never.contains(&reached) {
                broken.push(format!("{name}: must know nothing of {reached}, but {}", path.join(" uses ")));
            }
        }
    }
    broken
}

/// Finds every package reachable from `start`, with one path to it.
fn reach<'a>(start: &'a str, uses: &'a Graph) -> BTreeMap<&'a str, Vec<&'a str>> {
    let mut found = BTreeMap::new();
    let mut open = vec![vec![start]];
    while let Some(path) = open.pop() {
        let last = path[path.len() - 1];
        for next in uses.get(last).into_iter().flatten().map(String::as_str) {
            if !found.contains_key(next) {
                let longer: Vec<_> = path.iter().copied().chain([next]).collect();
                found.insert(next, longer.clone());
                open.push(longer);
            }
        }
    }
    found
}

#[test]
fn the_workspace_keeps_its_layers() {
    let workspace = workspace();
    assert!(workspace.uses["scene"].contains("light"), "the graph has its edges");
    let members: Vec<_> = workspace.members.keys().map(String::as_str).collect();
    let broken = violations(&members, &workspace.uses);
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn planted_violations_are_caught() {
    let real = workspace();
    let caught = |more: &[&str], edges: &[(&str, &str)], expected: &str| {
        let mut uses = real.uses.clone();
        for &(from, to) in edges {
            uses.entry(from.into()).or_default().insert(to.into());
            uses.entry(to.into()).or_default();
        }
        let members: Vec<_> = real.members.keys().map(String::as_str).chain(more.iter().copied()).collect();
        let broken = violations(&members, &uses);
        assert!(broken.iter().any(|sentence| sentence.contains(expected)), "{expected}: {broken:?}");
    };
    caught(&[], &[("light", "serde")], "light: must know nothing of serde, but light uses serde");
    caught(&[], &[("libm", "a"), ("a", "wgpu")], "scene: must know nothing of wgpu");
    caught(&[], &[("wgpu", "tokio")], "render: must know nothing of tokio");
    caught(&[], &[("bench", "proptest")], "bendylights: must know nothing of proptest");
    caught(&[], &[("scene", "render")], "scene: must not use render");
    caught(&[], &[("render", "protocol")], "render: must not use protocol");
    caught(&["scene-utils"], &[("scene-utils", "light")], "scene-utils: the name says nothing");
    caught(&["gateway"], &[("gateway", "light")], "gateway: has no layer");
}

/// Lines of `source` that use impure functions, tests included: tests must be deterministic too.
fn impurities(source: &str) -> Vec<&str> {
    source.lines().filter(|line| IMPURE.iter().any(|word| line.contains(word))).collect()
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let (folders, files): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
    let here = files.into_iter().filter(|path| path.extension().is_some_and(|e| e == "rs"));
    here.chain(folders.iter().flat_map(|folder| rust_files(folder))).collect()
}

#[test]
fn pure_crates_have_no_clock_and_no_io() {
    let workspace = workspace();
    for layer in LAYERS.iter().filter(|layer| layer.pure) {
        let files = rust_files(&workspace.members[layer.name].join("src"));
        assert!(!files.is_empty(), "{} has source files", layer.name);
        for file in files {
            let source = std::fs::read_to_string(&file).expect("a source file");
            assert_eq!(impurities(&source), [""; 0], "{}", file.display());
        }
    }
    assert_eq!(impurities("use glam::DVec3;\nuse std::time::Instant;").len(), 1, "a planted clock is caught");
}
