//! Conventions of this repository that can be tested.

mod comments;
mod docs;
mod ignored;
mod names;

use crate::sources::{Source, sources};

/// Sources in Rust, TypeScript, JavaScript and WGSL, without generated ones and without these tests, which name what
/// they refuse.
fn our_sources() -> Vec<Source> {
    let folders = ["crates", "protocol", "tests", "web-client/src", "web-client/test"];
    let mut sources = sources(&folders, &["rs", "ts", "tsx", "mjs", "wgsl"]);
    for (extension, least) in [(".rs", 400), (".ts", 60), (".tsx", 40), (".mjs", 20), (".wgsl", 40)] {
        let count = sources.iter().filter(|source| source.path.ends_with(extension)).count();
        assert!(count > least, "{count} files in {extension}");
    }
    let left_out = ["tests/conventions/comments.rs", "tests/conventions/names.rs", "web-client/src/core/protocol.ts"];
    sources.retain(|source| !left_out.contains(&&*source.path));
    sources
}
