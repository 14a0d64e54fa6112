//! Metrics of the server.

use serde_json::json;

use crate::client::{ask_with, get, metric, on_thread, post_edits};
use crate::server::OwnServer;

/// Rules: HTTP-9
#[tokio::test]
async fn requests_refusals_and_latency_are_counted_by_route() {
    let own = OwnServer::start().await;
    on_thread(&own.door, |door| {
        let requests = |label: &str| metric(door, &format!("bendylights_requests_total{{{label}}}"));
        let show = r#"method="GET",route="/sessions/{name}",status="200""#;
        assert_eq!(requests(show), None, "nobody has asked");
        for _ in 0..3 {
            get(door, "/sessions/main");
        }
        get(door, "/sessions/nowhere");
        post_edits(door, "main", &json!({"edits": []}));
        ask_with(door, "/sessions", &[], None);
        get(door, "/no-such-file");
        assert_eq!(requests(show), Some(3.0));
        assert_eq!(requests(r#"method="GET",route="/sessions/{name}",status="404""#), Some(1.0));
        assert_eq!(requests(r#"method="GET",route="/sessions",status="401""#), Some(1.0));
        assert_eq!(requests(r#"method="GET",route="page",status="404""#), Some(1.0));
        for (code, times) in [("notFound", 2.0), ("unauthorized", 1.0)] {
            assert_eq!(metric(door, &format!(r#"bendylights_errors_total{{code="{code}"}}"#)), Some(times), "{code}");
        }
        let seconds = r#"bendylights_request_seconds_count{route="/sessions/{name}"}"#;
        assert_eq!(metric(door, seconds), Some(4.0));
        assert_eq!(metric(door, "bendylights_requests_under_way"), Some(1.0), "the one that asks");
        get(door, "/sessions/main/render?size=64x36&samples=1");
        assert_eq!(metric(door, r#"bendylights_render_queue{urgency="still"}"#), Some(0.0));
    })
    .await;
    own.stopped().await;
}

/// Rules: HTTP-9
#[cfg(target_os = "linux")]
#[tokio::test]
async fn the_process_is_told_of_as_prometheus_clients_do() {
    let own = OwnServer::start().await;
    on_thread(&own.door, |door| {
        let process = |name: &str| metric(door, &format!("process_{name}")).unwrap_or_else(|| panic!("no {name}"));
        assert!(process("resident_memory_bytes") > 1e6 && process("virtual_memory_bytes") > 1e6);
        assert!(process("threads") > 1.0 && process("open_fds") > 3.0 && process("max_fds") > process("open_fds"));
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap().as_secs_f64();
        assert!((0.0..3600.0).contains(&(now - process("start_time_seconds"))), "it started not long ago");
        let before = process("cpu_seconds_total");
        get(door, "/sessions/main/render?size=640x360&samples=16");
        assert!(process("cpu_seconds_total") > before, "a picture takes processor time");
    })
    .await;
    own.stopped().await;
}
