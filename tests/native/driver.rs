//! Drivers that a program opens.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::program::program;

/// Draws a demo by `backend`, in an empty folder. Returns the files of graphics drivers and their loaders that the
/// program tried to open.
fn driver_files(backend: &str) -> Vec<String> {
    let folder = tempfile::tempdir().expect("a folder");
    let (calls, picture) = (folder.path().join("calls"), folder.path().join("out.png"));
    let mut strace = Command::new("strace");
    strace.args(["-f", "-e", "trace=open,openat", "-o"]).arg(&calls).arg(program());
    strace.args(["render", "demo:vases", "--size", "64x48", "--backend", backend, "-o"]).arg(&picture);
    let output = strace.output().expect("strace");
    assert!(output.status.success() && picture.exists(), "{}", String::from_utf8_lossy(&output.stderr));
    let calls = fs::read_to_string(&calls).expect("a log of calls");
    let paths = calls.lines().filter_map(|call| call.split('"').nth(1));
    let name = |path: &&str| Path::new(path).file_name().map(|name| name.to_string_lossy().to_lowercase());
    let is_driver = |path: &&str| {
        name(path).is_some_and(|name| {
            ["vulkan", "libegl", "libgl.", "lvp_icd", "_dri.so"].iter().any(|part| name.contains(part))
        })
    };
    paths.filter(is_driver).map(str::to_owned).collect()
}

/// The native backend needs no driver, so it works where none is installed. A planted fault, a picture by wgpu, opens
/// some.
#[test]
#[ignore = "needs strace"]
fn the_native_backend_opens_no_driver() {
    assert_eq!(driver_files("native"), [""; 0]);
    assert!(!driver_files("wgpu").is_empty());
}
