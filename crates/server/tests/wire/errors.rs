//! Access and errors.

use crate::client::{ask_with, get, post, socket_with};
use crate::server::SHARED;

/// Rules: HTTP-1
#[test]
fn all_but_the_page_and_signs_of_life_need_the_token() {
    let paths =
        ["/sessions", "/sessions/main", "/sessions/main/log", "/sessions/main/render", "/metrics", "/sessions/nowhere"];
    for path in paths {
        for headers in [&[][..], &[("authorization", "Bearer 0123456789abcdef0123456789abcdef")]] {
            let answer = ask_with(&SHARED, path, headers, None);
            assert_eq!(answer.refusal(), (401, "unauthorized".into()), "{path}");
        }
    }
    for path in ["/sessions", "/sessions/main/edits", "/assets"] {
        assert_eq!(ask_with(&SHARED, path, &[], Some(b"{}")).status, 401, "{path}");
    }
    for path in ["/healthz", "/openapi.json"] {
        assert_eq!(ask_with(&SHARED, path, &[], None).status, 200, "{path}");
    }
    // A page that is not built says how to build it. In both cases it needs no token.
    assert!(ask_with(&SHARED, "/", &[], None).text().contains("<title>BendyLights</title>"));
    assert_eq!(get(&SHARED, "/sessions").status, 200, "the token opens");
}

/// Rules: HTTP-2
#[tokio::test]
async fn pages_of_other_places_are_refused() {
    let own = format!("http://{}", SHARED.address);
    for foreign in ["http://example.org", "null", "http://127.0.0.1:1", "https://example.org:8080"] {
        let answer = ask_with(&SHARED, "/healthz", &[("origin", foreign)], None);
        assert_eq!(answer.refusal(), (403, "foreignOrigin".into()), "{foreign}");
        assert_eq!(socket_with(&SHARED, &[("origin", foreign)]).await, Some(403), "{foreign}");
    }
    assert_eq!(ask_with(&SHARED, "/healthz", &[("origin", &own)], None).status, 200);
    assert_eq!(socket_with(&SHARED, &[("origin", &own)]).await, None);
}

/// A foreign page whose name leads to this machine, and pages behind a proxy.
///
/// Rules: HTTP-2, HTTP-13
#[tokio::test]
async fn foreign_host_names_are_refused() {
    let port = SHARED.address.port();
    let rebound = format!("evil.example:{port}");
    for host in [rebound.as_str(), "localhost.evil.example", "127.0.0.1.evil.example"] {
        let origin = format!("http://{host}");
        for headers in [&[("host", host)][..], &[("host", host), ("origin", &origin)]] {
            let answer = ask_with(&SHARED, "/healthz", headers, None);
            assert_eq!(answer.refusal(), (403, "foreignHost".into()), "{headers:?}");
            assert!(answer.text().contains(host), "{}", answer.text());
            assert_eq!(socket_with(&SHARED, headers).await, Some(403), "{headers:?}");
        }
    }
    let (local, public) = (format!("localhost:{port}"), "https://lights.example.org");
    let lets_in = [
        &[("host", local.as_str())][..],
        &[("host", "localhost:9000")],
        &[("host", "[::1]:9000")],
        &[("host", "lights.example.org"), ("origin", public)],
        &[("host", &local), ("origin", public)],
    ];
    for headers in lets_in {
        assert_eq!(ask_with(&SHARED, "/healthz", headers, None).status, 200, "{headers:?}");
        assert_eq!(socket_with(&SHARED, headers).await, None, "{headers:?}");
    }
}

/// Rules: HTTP-1
#[test]
fn the_scheme_of_the_token_is_understood_in_any_case() {
    for scheme in ["Bearer", "bearer", "BEARER"] {
        let value = format!("{scheme} {}", SHARED.token);
        assert_eq!(ask_with(&SHARED, "/sessions", &[("authorization", &value)], None).status, 200, "{scheme}");
    }
    let basic = format!("Basic {}", SHARED.token);
    assert_eq!(ask_with(&SHARED, "/sessions", &[("authorization", &basic)], None).status, 401);
}

/// Rules: HTTP-13
#[test]
fn answers_have_security_headers() {
    for path in ["/", "/healthz", "/sessions", "/sessions/main", "/nowhere"] {
        let answer = get(&SHARED, path);
        assert_eq!(answer.headers["x-content-type-options"], "nosniff", "{path}");
        assert_eq!(answer.headers["referrer-policy"], "no-referrer", "{path}");
    }
    let policy = get(&SHARED, "/").headers["content-security-policy"].to_str().unwrap().to_owned();
    let directives = ["connect-src 'self'", "base-uri 'none'", "form-action 'none'", "frame-ancestors 'none'"];
    for directive in directives {
        assert!(policy.split(';').any(|found| found.trim() == directive), "{directive}: {policy}");
    }
}

/// Rules: HTTP-3
#[test]
fn every_error_is_json_that_says_what_to_do() {
    let code = |status: u16, code: &str| (status, code.to_owned());
    assert_eq!(get(&SHARED, "/nowhere").refusal(), code(404, "notFound"));
    assert_eq!(get(&SHARED, "/sessions/nowhere").refusal(), code(404, "notFound"));
    assert_eq!(get(&SHARED, "/sessions/%ff").refusal(), code(400, "badMessage"));
    assert_eq!(get(&SHARED, "/assets").refusal(), code(405, "methodNotAllowed"));
    assert_eq!(get(&SHARED, "/socket").refusal(), code(400, "badMessage"));
    assert_eq!(get(&SHARED, "/sessions/main/log?form=1").refusal(), code(400, "badMessage"));
    assert_eq!(get(&SHARED, "/sessions/main/render?aov=colour").refusal(), code(400, "render"));
    let unknown_field = post(&SHARED, "/sessions", r#"{"name": "a", "scenery": "demo:vases"}"#);
    assert_eq!(unknown_field.refusal(), code(400, "badMessage"));
    assert!(unknown_field.text().contains("scenery"), "the field is named: {}", unknown_field.text());
    assert_eq!(ask_with(&SHARED, "/sessions", &[("authorization", "Basic x")], None).kind, "application/json");
}
