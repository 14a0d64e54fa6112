//! JSON of everything: vectors, round trips, refusals, generated schemas.

use std::path::Path;

mod generated;
mod light_file;
mod log_lines;
mod messages;
mod refusals;
mod round_trip;
mod vectors;

/// Asserts that a committed file equals the text that the code makes.
fn assert_committed(file: &str, made: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    if std::env::var_os("BENDYLIGHTS_BLESS").is_some() {
        std::fs::write(&path, made).expect("written");
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(committed == made, "{file} is not what the code makes: run this test with BENDYLIGHTS_BLESS=1");
}
