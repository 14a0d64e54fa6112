//! Anonymous requests: constant answers, and limits of the rest.

use std::time::{Duration, Instant};

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::spawn;

use crate::client::{bearer, get, get_unless, send_raw};
use crate::server::{SHARED, ServerDoor};

/// Rules: HTTP-24
#[test]
fn constant_answers_have_a_tag_by_which_clients_keep_them() {
    for path in ["/openapi.json", "/parameters"] {
        let full = get(&SHARED, path);
        let tag = full.headers["etag"].to_str().unwrap().to_owned();
        assert!(tag.starts_with('"') && tag.len() == 66, "a strong tag: {tag}");
        for known in [tag.clone(), format!("\"older\", W/{tag}"), "*".into()] {
            let answer = get_unless(&SHARED, path, &known);
            assert_eq!((answer.status, answer.body.len()), (304, 0), "{path} {known}");
            assert_eq!(answer.headers["etag"], tag.as_str());
        }
        for other in ["\"older\"", &tag[1..65], "W/"] {
            let answer = get_unless(&SHARED, path, other);
            assert_eq!((answer.status, &answer.body), (200, &full.body), "{path} {other}");
        }
    }
}

/// Requests a path that many times on one connection, one request after the other.
async fn ask_repeatedly(door: ServerDoor, path: &'static str, headers: String, count: usize) {
    let mut stream = send_raw(&door, "").await;
    let request = format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n{headers}\r\n");
    for _ in 0..count {
        stream.write_all(request.as_bytes()).await.unwrap();
        let mut head = Vec::new();
        while !head.ends_with(b"\r\n\r\n") {
            head.push(stream.read_u8().await.unwrap());
        }
        let head = String::from_utf8(head).unwrap().to_lowercase();
        let length = head.split("content-length: ").nth(1).unwrap().split("\r\n").next().unwrap();
        stream.read_exact(&mut vec![0; length.parse().unwrap()]).await.unwrap();
    }
}

/// Measures the time in which `connections` connections request `path`, each of them `count` times.
async fn time_of(path: &'static str, headers: &str, connections: usize, count: usize) -> Duration {
    let began = Instant::now();
    let asking: Vec<_> =
        (0..connections).map(|_| spawn(ask_repeatedly(SHARED.clone(), path, headers.to_owned(), count))).collect();
    for one in asking {
        one.await.unwrap();
    }
    began.elapsed()
}

/// The bound is a lower one on time, so a slow machine cannot break it. Deliberate fault that the check must detect: a
/// client with the token, whose requests are not limited.
///
/// Rules: HTTP-25
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn anonymous_requests_delay_only_each_other() {
    const CONNECTIONS: usize = 40;
    const EACH: usize = 20;
    // 16 at once, 25 ms each.
    let bound = Duration::from_millis(25) * (CONNECTIONS * EACH / 16 - 1) as u32;
    let token = format!("Authorization: {}\r\n", bearer(&SHARED));
    for path in ["/nowhere", "/sessions", "/healthz"] {
        let anonymous = time_of(path, "", CONNECTIONS, EACH).await;
        assert!(anonymous >= bound, "{path}: {anonymous:?} is less than {bound:?}");
    }
    let known = time_of("/nowhere", &token, CONNECTIONS, EACH).await;
    assert!(known < bound, "who has the token waits as anonymous requests do: {known:?}");
    let anonymous = spawn(time_of("/openapi.json", "", CONNECTIONS, EACH));
    let asked = Instant::now();
    time_of("/healthz", "", 1, 1).await;
    let health = asked.elapsed();
    time_of("/nowhere", &token, 1, 1).await;
    assert!(!anonymous.is_finished(), "signs of life are answered while others load pages: {health:?}");
    anonymous.abort();
}
