//! Tests the layers of ARCHITECTURE.md with `cargo metadata`: the crates that each crate uses.
//!
//! Only shipped code counts: normal dependencies, direct and transitive, not those of tests and build scripts.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use serde_json::Value;

use crate::processes::output_of;

use crate::sources::sources;

/// Rules for the dependencies of a crate of the workspace.
struct Layer {
    name: &'static str,
    /// Crates of the workspace that its manifest may name, with a space between names.
    uses: &'static str,
    /// Packages that it must not reach.
    never: &'static [&'static str],
    /// True if it may use no clock, IO or environment: it is a function of its arguments alone.
    pure: bool,
}

/// Packages that exist for studies alone: the program that users install must not contain them.
const OF_STUDIES: &[&str] = &["studies", "proptest"];

/// Packages that a crate without IO and wire form must not reach.
const NO_IO: &[&str] = &["tokio", "wgpu", "axum", "serde", "serde_core", "rand", "getrandom"];

/// Crate that may use those of `uses` and must not reach those of `never`.
const fn layer(name: &'static str, uses: &'static str, never: &'static [&'static str]) -> Layer {
    Layer { name, uses, never, pure: false }
}

/// Crate that may use those of `uses`, without IO and wire form.
const fn pure(name: &'static str, uses: &'static str) -> Layer {
    Layer { name, uses, never: NO_IO, pure: true }
}

const LAYERS: &[Layer] = &[
    pure("light", ""),
    pure("scene", "light hierarchy"),
    pure("hierarchy", ""),
    pure("document", "light scene raycast drag"),
    pure("raycast", "light scene hierarchy"),
    pure("drag", "light scene raycast"),
    layer("reference", "light scene raycast", &["tokio", "wgpu", "axum", "serde", "render"]),
    pure("edit", "light scene document"),
    layer("assets", "light scene document", &["tokio", "wgpu", "axum", "protocol"]),
    layer("relight", "light hierarchy", NO_IO),
    pure("shadow", "light scene relight"),
    layer("render", "light scene hierarchy relight shadow", &["tokio", "axum", "protocol"]),
    layer("stream", "", &["tokio", "wgpu", "axum"]),
    layer("protocol", "light scene document edit drag reference", &["tokio", "wgpu", "axum"]),
    layer("store", "light scene document edit protocol", &["tokio", "wgpu", "axum"]),
    layer("server", "light scene raycast drag reference document assets edit render store stream protocol", &["clap"]),
    layer(
        "bendylights",
        "light scene document edit assets raycast drag reference render protocol store server bench cli",
        OF_STUDIES,
    ),
    layer("bench", "light scene raycast drag reference relight render protocol stream", &["tokio", "axum"]),
    layer("studies", "light scene assets raycast drag reference relight render protocol bench cli", &["tokio", "axum"]),
    layer("cli", "protocol", &["tokio", "wgpu", "axum", "clap"]),
    layer("bendylights-tests", "", &[]),
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
    members: Vec<String>,
    uses: Graph,
}

fn workspace() -> Workspace {
    // One platform's dependencies are enough, and are the only ones that a build has downloaded.
    let platform = format!("{}-unknown-linux-gnu", std::env::consts::ARCH);
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["metadata", "--format-version", "1", "--locked", "--filter-platform", &platform]);
    let metadata: Value = serde_json::from_str(&output_of(&mut cargo)).expect("JSON");
    let list = |value: &Value| value.as_array().expect("a list").clone();
    let packages = list(&metadata["packages"]);
    let names: BTreeMap<String, String> =
        packages.iter().map(|package| (text(&package["id"]), text(&package["name"]))).collect();
    let mut uses = Graph::new();
    for node in list(&metadata["resolve"]["nodes"]) {
        // A normal dependency has no kind.
        let is_normal = |dep: &Value| list(&dep["dep_kinds"]).iter().any(|kind| kind["kind"].is_null());
        let normal = list(&node["deps"]).into_iter().filter(is_normal).map(|dep| names[&text(&dep["pkg"])].clone());
        uses.entry(names[&text(&node["id"])].clone()).or_default().extend(normal);
    }
    let members = list(&metadata["workspace_members"]).iter().map(|id| names[&text(id)].clone()).collect();
    Workspace { members, uses }
}

fn text(value: &Value) -> String {
    value.as_str().expect("a text").into()
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
        let may_use = |used: &str| layer.uses.split(' ').any(|name| name == used);
        for used in members.iter().filter(|used| uses[name].contains(**used) && !may_use(used)) {
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
    let members: Vec<_> = workspace.members.iter().map(String::as_str).collect();
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
        let members: Vec<_> = real.members.iter().map(String::as_str).chain(more.iter().copied()).collect();
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

#[test]
fn pure_crates_have_no_clock_and_no_io() {
    for layer in LAYERS.iter().filter(|layer| layer.pure) {
        let files = sources(&[&format!("crates/{}/src", layer.name)], &["rs"]);
        assert!(!files.is_empty(), "{} has source files", layer.name);
        for file in files {
            assert_eq!(impurities(&file.text), [""; 0], "{}", file.path);
        }
    }
    assert_eq!(impurities("use glam::DVec3;\nuse std::time::Instant;").len(), 1, "a planted clock is caught");
}
