//! Tests that every hostile scene file is handled as its list says: drawn, or refused with one sentence.

use std::path::Path;
use std::time::{Duration, Instant};

use crate::program::{Folder, run};

const HOSTILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/assets/hostile");
/// Limit per file, including the start of the program and of the graphics driver.
const TIME_LIMIT: Duration = Duration::from_secs(20);

#[test]
#[ignore = "needs ../shared/assets"]
fn hostile_scenes_of_shared_assets_are_drawn_or_refused() {
    let list = std::fs::read_to_string(Path::new(HOSTILE).join("EXPECT.tsv")).expect(HOSTILE);
    let folder = Folder::new();
    let mut files = 0;
    for row in list.lines().skip(1) {
        let mut columns = row.split('\t');
        let (Some(file), Some(expected)) = (columns.next(), columns.next()) else { panic!("a bad row: {row}") };
        let picture = format!("{file}.png");
        let start = Instant::now();
        let done = run(&["render", &format!("{HOSTILE}/{file}"), "--size", "32x32", "-o", &folder.path(&picture)]);
        assert!(start.elapsed() < TIME_LIMIT, "{file} took {:?}", start.elapsed());
        let drawn = folder.names().contains(&picture);
        match done.code {
            0 => assert!(drawn, "{file}: no picture"),
            2 => {
                assert!(!drawn, "{file}: refused, but there is a picture");
                assert_eq!((done.stdout.as_str(), done.stderr.lines().count()), ("", 1), "{file}: {}", done.stderr);
                assert!(done.stderr.contains(file), "{file} is not named: {}", done.stderr);
            }
            code => panic!("{file}: exit code {code}: {}", done.stderr),
        }
        // Values are "reject", "accept", "reject or sanitise", "accept or limit" and "limit", with remarks.
        let may_be_drawn = expected.contains("accept") || expected.contains("sanitise");
        let may_be_refused = expected.contains("reject") || expected.contains("limit");
        assert!(if drawn { may_be_drawn } else { may_be_refused }, "{file}: {expected}, but drawn is {drawn}");
        files += 1;
    }
    assert!(files > 60, "only {files} files");
}
