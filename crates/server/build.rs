//! The page is part of the program: a new page makes a new program.

use std::path::Path;

fn main() {
    // Before the first build of the page only its folder can be watched.
    let built = "../../web-client/dist";
    let watched = if Path::new(built).is_dir() { built } else { "../../web-client" };
    println!("cargo::rerun-if-changed={watched}");
}
