//! The same function or struct has the same name in Rust and in WGSL. Shaders that evaluate a light in f32 mirror the
//! file of the same name in `light`.
//!
//! A method `offset` of `Curve` is `curve_offset` in WGSL. Methods of `Tube`, `Cone`, `Omni` or `Parallel`, the one
//! light of a shader, have no prefix.

use std::collections::BTreeSet;

/// Rust and WGSL files of the same name, and functions that only WGSL has: spelled-out loops and closures.
const TWINS: [(&str, &str, &[&str]); 11] = [
    (include_str!("../../../../light/src/curve.rs"), include_str!("curve.wgsl"), &[]),
    (include_str!("../../../../light/src/frame.rs"), include_str!("frame.wgsl"), &["cross_section"]),
    (include_str!("../../../../light/src/solve.rs"), include_str!("solve.wgsl"), &["cbrt_above"]),
    (include_str!("../../../../light/src/arc.rs"), include_str!("arc.wgsl"), &[]),
    (include_str!("../../../../light/src/emission.rs"), include_str!("emission.wgsl"), &[]),
    (
        concat!(
            include_str!("../../../../light/src/profile/mod.rs"),
            include_str!("../../../../light/src/profile/cross_falloff.rs"),
            include_str!("../../../../light/src/profile/edge_outline.rs"),
            include_str!("../../../../light/src/profile/section_outline.rs"),
            include_str!("../../../../light/src/profile/distance_ramps.rs"),
        ),
        include_str!("profile.wgsl"),
        &[],
    ),
    (include_str!("../../../../light/src/segment.rs"), include_str!("segment.wgsl"), &[]),
    (include_str!("../../../../light/src/rays/cone.rs"), include_str!("cone.wgsl"), &["scene_axes"]),
    (include_str!("../../../../light/src/rays/omni.rs"), include_str!("omni.wgsl"), &["scene_axes"]),
    (include_str!("../../../../light/src/rays/parallel.rs"), include_str!("parallel.wgsl"), &["scene_axes"]),
    (
        include_str!("../../../../light/src/rays/tube.rs"),
        include_str!("tube.wgsl"),
        &["nearest_inside", "segment_at", "segment_count", "visit_segment", "consider", "u_hat_derivative"],
    ),
];

/// Another Rust file with structs of those shaders.
const PLACE: &str = include_str!("../../../../light/src/light_coords.rs");
/// Structs that only WGSL has: lights as uniforms, and values that Rust returns as an option or keeps in a closure.
const STRUCTS_OF_WGSL: [&str; 5] = ["BendyLight", "Directional", "Spot", "Located", "Search"];

/// Returns the prefix of a method's name in WGSL, by its type.
fn prefix(type_name: &str) -> String {
    if ["Tube", "Cone", "Omni", "Parallel"].contains(&type_name) {
        return String::new();
    }
    let words = type_name.chars().enumerate().map(|(i, c)| match c {
        c if c.is_uppercase() && i > 0 => format!("_{}", c.to_lowercase()),
        c => c.to_lowercase().to_string(),
    });
    words.collect::<String>() + "_"
}

/// Returns the functions of a Rust file by their WGSL names.
fn rust_functions(rust: &str) -> BTreeSet<String> {
    let mut of = String::new();
    let mut found = BTreeSet::new();
    for line in rust.lines() {
        if let Some(header) = line.strip_prefix("impl") {
            let header = ["<F: Real>", "<F: Lanes>"].iter().find_map(|f| header.strip_prefix(f)).unwrap_or(header);
            let type_name = header.rsplit(" for ").next().unwrap_or_default().trim();
            of = prefix(type_name.split(['<', ' ']).next().unwrap_or_default());
        } else if line.starts_with('}') {
            of = String::new();
        } else if let Some((before, name)) = line.split_once("fn ")
            && matches!(before.trim(), "" | "pub" | "pub(crate)")
        {
            found.insert(of.clone() + name.split(['<', '(']).next().unwrap_or_default());
        }
    }
    found
}

fn wgsl_functions(wgsl: &str) -> BTreeSet<String> {
    let names = wgsl.lines().filter_map(|line| line.strip_prefix("fn ")?.split('(').next());
    names.map(str::to_owned).collect()
}

/// Returns the names of structs, and in Rust also of type aliases.
fn structs(source: &str) -> BTreeSet<&str> {
    source
        .lines()
        .filter_map(|line| {
            let line = line.strip_prefix("pub ").unwrap_or(line);
            line.strip_prefix("struct ").or_else(|| line.strip_prefix("type "))?.split(['<', ' ', '(']).next()
        })
        .collect()
}

/// Returns the WGSL functions without a Rust twin, except the `known` ones.
fn alone(rust: &str, wgsl: &str, known: &[&str]) -> Vec<String> {
    let rust = rust_functions(rust);
    let mut alone: Vec<_> = wgsl_functions(wgsl).into_iter().filter(|name| !rust.contains(name)).collect();
    alone.retain(|name| !known.contains(&name.as_str()));
    alone
}

#[test]
fn functions_have_one_name_in_rust_and_in_wgsl() {
    for (rust, wgsl, known) in TWINS {
        assert_eq!(alone(rust, wgsl, known), Vec::<String>::new());
        assert!(wgsl_functions(wgsl).len() > known.len());
        assert!(known.iter().all(|name| wgsl_functions(wgsl).contains(*name)));
    }
    // Deliberate faults that the check must detect: another name, and a method that names another type.
    let rust = "impl<F: Lanes> TubeBox<F> {\n    pub fn contains(&self) {}\n}\npub fn arc_length() {}\n";
    assert!(alone(rust, "fn tube_box_contains() {}\nfn arc_length() {}", &[]).is_empty());
    assert_eq!(alone(rust, "fn length() {}\nfn curve_contains() {}", &[]), ["curve_contains", "length"]);
}

#[test]
fn structs_have_one_name_in_rust_and_in_wgsl() {
    let rust: BTreeSet<_> = TWINS.iter().map(|twin| twin.0).chain([PLACE]).flat_map(structs).collect();
    let wgsl: BTreeSet<_> = TWINS.iter().flat_map(|(_, wgsl, _)| structs(wgsl)).collect();
    let alone: Vec<_> = wgsl.difference(&rust).copied().collect();
    let mut known = STRUCTS_OF_WGSL.to_vec();
    known.sort_unstable();
    assert_eq!(alone, known);
    // Deliberate fault that the check must detect: a name that only one side has.
    assert_eq!(structs("pub struct Curve<F: Real> {\nstruct Piece {\n"), BTreeSet::from(["Curve", "Piece"]));
    assert!(structs("struct Piece {").is_disjoint(&rust));
    assert!(["Curve", "Segment", "TubeRoot", "LightCoords", "LightProfile"].iter().all(|name| wgsl.contains(name)));
}
