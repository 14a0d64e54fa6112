//! Runs scripts of the page's browser tests on a server.

use std::path::Path;
use std::process::Command;

use bench::ServerAddress;

/// Runs a script in Chromium, with a new session of the scene of session `of`, or without a session. The script gets
/// its input as JSON. It fails with a sentence, also if one of its pictures breaks a rule of accessibility.
pub fn run_in_browser(
    script: &str,
    ServerAddress { host, token }: &ServerAddress,
    of: Option<&str>,
    facts: Option<&str>,
) {
    let client = Path::new(env!("CARGO_MANIFEST_DIR")).join("../web-client");
    let is_built = client.join("node_modules/playwright-core").is_dir() && client.join("dist/index.html").is_file();
    assert!(is_built, "the page is not built: `make page` builds it");
    let pictures = tempfile::tempdir().expect("a folder");
    let session = of.map(|name| format!("&session={name}")).unwrap_or_default();
    let address = format!("http://{host}/#token={token}{session}");
    let script = client.join("test/browser").join(script);
    let mut node = Command::new("node");
    let status = node.arg(script).arg(address).arg(pictures.path()).args(facts).status().expect("node runs");
    assert!(status.success(), "the page does not do what it should");
}
