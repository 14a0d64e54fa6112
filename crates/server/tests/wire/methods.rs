//! Methods of paths, and media types of bodies.

use crate::client::{bearer, get, send};
use crate::server::SHARED;

const METHODS: [&str; 6] = ["GET", "HEAD", "POST", "PUT", "PATCH", "DELETE"];

/// Rules: HTTP-16, HTTP-1
#[test]
fn a_known_address_says_which_methods_it_takes() {
    let addresses = [
        ("/sessions", "GET,HEAD,POST"),
        ("/sessions/main", "GET,HEAD,PATCH,DELETE"),
        ("/sessions/main/duplicate", "POST"),
        ("/sessions/main/edits", "POST"),
        ("/sessions/main/log", "GET,HEAD"),
        ("/sessions/main/render", "GET,HEAD"),
        ("/sessions/main/pick", "POST"),
        ("/sessions/main/probe", "POST"),
        ("/metrics", "GET,HEAD"),
        ("/scenes", "GET,HEAD"),
        ("/assets", "POST"),
        ("/healthz", "GET,HEAD"),
        ("/readyz", "GET,HEAD"),
        ("/openapi.json", "GET,HEAD"),
        ("/socket", "GET,HEAD"),
        ("/", "GET,HEAD"),
    ];
    let bearer = bearer(&SHARED);
    for (path, allowed) in addresses {
        for method in METHODS {
            let answer = send(&SHARED, method, path, &[("authorization", &bearer)], b"");
            if allowed.split(',').any(|taken| taken == method) {
                assert!(![404, 405].contains(&answer.status), "{method} {path}: {}", answer.status);
                continue;
            }
            assert_eq!(answer.status, 405, "{method} {path}");
            assert_eq!(answer.headers["allow"], allowed, "{method} {path}");
            // The answer to HEAD has no body.
            if method != "HEAD" {
                assert_eq!(answer.refusal(), (405, "methodNotAllowed".into()), "{method} {path}");
                assert!(answer.text().contains(method) && answer.text().contains(path), "{}", answer.text());
            }
        }
        let needs_token = !["/healthz", "/readyz", "/openapi.json", "/socket", "/"].contains(&path);
        let status = send(&SHARED, "DELETE", path, &[], b"").status;
        assert_eq!(status, if needs_token { 401 } else { 405 }, "{path}");
    }
    for path in ["/nowhere", "/sessions/main/edit", "/sessions/", "/assets/nothing.js", "/index.htm"] {
        for method in METHODS {
            assert_eq!(send(&SHARED, method, path, &[("authorization", &bearer)], b"").status, 404, "{method} {path}");
        }
    }
}

/// Rules: HTTP-16
#[test]
fn head_is_answered_as_get_is_but_for_the_body() {
    let bearer = bearer(&SHARED);
    for path in ["/healthz", "/sessions", "/sessions/main", "/sessions/nowhere", "/openapi.json", "/"] {
        let head = send(&SHARED, "HEAD", path, &[("authorization", &bearer)], b"");
        let full = get(&SHARED, path);
        assert_eq!((head.status, head.kind.as_str(), head.body.len()), (full.status, full.kind.as_str(), 0), "{path}");
    }
}

/// Rules: HTTP-17
#[test]
fn a_body_that_is_not_json_is_refused_for_its_type() {
    let bearer = bearer(&SHARED);
    let session = br#"{"name": "of-a-type"}"#;
    let kinds = [
        "application/x-www-form-urlencoded",
        "text/plain",
        "multipart/form-data; boundary=x",
        "application/octet-stream",
        "application/jsonl",
        "json",
    ];
    for path in ["/sessions", "/sessions/main/edits"] {
        for kind in kinds {
            let headers = [("authorization", bearer.as_str()), ("content-type", kind)];
            let answer = send(&SHARED, "POST", path, &headers, session);
            assert_eq!(answer.refusal(), (415, "unsupportedMediaType".into()), "{path} {kind}");
            let sentence = answer.text();
            assert!(sentence.contains(kind) && sentence.contains("Content-Type: application/json"), "{sentence}");
        }
    }
    assert_eq!(get(&SHARED, "/sessions/of-a-type").status, 404, "none of them made the session");
    let taken = ["application/json", "Application/JSON; charset=utf-8", "application/vnd.api+json"];
    for (index, kind) in taken.iter().map(Some).chain([None]).enumerate() {
        let headers = [Some(("authorization", bearer.as_str())), kind.map(|kind| ("content-type", *kind))];
        let headers: Vec<_> = headers.into_iter().flatten().collect();
        let session = format!(r#"{{"name": "of-type-{index}"}}"#);
        assert_eq!(send(&SHARED, "POST", "/sessions", &headers, session.as_bytes()).status, 201, "{kind:?}");
    }
}
