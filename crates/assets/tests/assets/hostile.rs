//! Tests that broken and malicious files are refused with a reason, or repaired, in little time and memory.

use std::time::Instant;

/// Limits for the collection: seconds per file, and resident KiB of this process.
const MAX_SECONDS: f64 = 20.0;
const MAX_RESIDENT_KIB: u64 = 2 << 20;

/// Allowed results for a file, from EXPECT.tsv.
struct Expectation {
    may_load: bool,
    may_refuse: bool,
}

fn expectation(text: &str) -> Expectation {
    match text.split([' ', ',']).next().unwrap_or_default() {
        "accept" => Expectation { may_load: true, may_refuse: text == "accept or limit" },
        "limit" => Expectation { may_load: false, may_refuse: true },
        "reject" => {
            Expectation { may_load: text.contains("or sanitise") || text.contains("(or accept)"), may_refuse: true }
        }
        other => panic!("unknown expectation {other}"),
    }
}

#[test]
#[ignore = "needs ../shared/assets"]
fn every_hostile_file_of_shared_assets_is_handled_as_expected() {
    let folder = crate::support::assets_folder();
    let folder = folder.join("hostile");
    let table = std::fs::read_to_string(folder.join("EXPECT.tsv")).unwrap();
    let (mut slowest, mut files) = ((0.0, String::new()), 0);
    for line in table.lines().skip(1) {
        let mut columns = line.split('\t');
        let (name, expected) = (columns.next().unwrap(), expectation(columns.next().unwrap()));
        let start = Instant::now();
        let result = assets::load(&folder.join(name));
        let seconds = start.elapsed().as_secs_f64();
        assert!(seconds < MAX_SECONDS, "{name} took {seconds} s");
        slowest = if seconds > slowest.0 { (seconds, name.into()) } else { slowest };
        match result {
            Ok(loaded) => {
                println!("{name}: loaded {:?}", loaded.notes);
                assert!(expected.may_load, "{name} loaded: {line}");
                crate::support::assert_sound(&loaded, name);
            }
            Err(error) => {
                let message = error.to_string();
                println!("{message}");
                assert!(expected.may_refuse, "{name} was refused: {message}");
                assert!(message.contains(name) && !message.contains('\n') && message.len() < 500, "{message}");
            }
        }
        files += 1;
    }
    println!("{files} files, the slowest {} in {:.3} s", slowest.1, slowest.0);
    if let Ok(status) = std::fs::read_to_string("/proc/self/status") {
        let peak =
            status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB")?.parse().ok());
        println!("peak memory {peak:?} KiB");
        assert!(peak.is_none_or(|kib: u64| kib < MAX_RESIDENT_KIB));
    }
}

/// The expectations above can fail: their three kinds of answer differ.
#[test]
fn expectations_differ() {
    assert!(!expectation("accept").may_refuse);
    assert!(!expectation("reject, and never read outside").may_load);
    assert!(!expectation("limit").may_load);
    assert!(expectation("reject or sanitise").may_load);
}

/// Valid files with one to four changed bytes never cause a panic. If one loads, its scene is sound.
#[test]
#[ignore = "needs ../shared/assets"]
fn changed_bytes_of_shared_assets_never_panic() {
    let folder = crate::support::assets_folder();
    let scratch = tempfile::tempdir().unwrap();
    let (mut loads, mut refusals) = (0, 0);
    let mut random = 1_u64;
    let mut below = |n: usize| {
        // Knuth's MMIX generator, whose high bits are the good ones.
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((random >> 33) % n as u64) as usize
    };
    for name in
        ["hostile/ok_triangle.gltf", "gltf/khronos/BoxInterleaved.glb", "gltf/instancing/pc-simple-instancing.glb"]
    {
        let valid = std::fs::read(folder.join(name)).unwrap();
        let text = valid.windows(4).rposition(|w| w == b"BIN\0").unwrap_or(valid.len());
        let path = scratch.path().join(name.rsplit('/').next().unwrap());
        for _ in 0..700 {
            let mut bytes = valid.clone();
            for _ in 0..=below(4) {
                // Digits and brackets pass the parser more often than arbitrary bytes.
                let alphabet = b"0123456789-.,[]{}\"e";
                let at = if below(8) == 0 { below(bytes.len()) } else { below(text) };
                bytes[at] = if at < text { alphabet[below(alphabet.len())] } else { below(256) as u8 };
            }
            std::fs::write(&path, &bytes).unwrap();
            match assets::load(&path) {
                Ok(loaded) => {
                    crate::support::assert_sound(&loaded, name);
                    loads += 1;
                }
                Err(error) => {
                    assert!(!error.to_string().contains('\n'), "{error}");
                    refusals += 1;
                }
            }
        }
    }
    println!("{loads} loads, {refusals} refusals");
    assert!(loads > 100 && refusals > 500, "both happen: {loads}, {refusals}");
}
