//! Checks of all answers against `/openapi.json`.

use std::sync::LazyLock;

use serde_json::{Value, json};

use crate::client::{HttpAnswer, get, post};
use crate::server::SHARED;

/// Checks that the document names an answer for its operation: its status, and its media type or its code.
pub fn check(method: &str, path: &str, answer: &HttpAnswer) -> Result<(), String> {
    static DOCUMENT: LazyLock<Value> = LazyLock::new(protocol::openapi);
    let path = path.split('?').next().unwrap_or_default();
    let operation = |(template, methods): (&String, &'static Value)| {
        if is_of(path, template) { methods.get(method.to_lowercase()) } else { None }
    };
    // Paths that are no operations, such as the page, are not in the document.
    let Some(operation) = DOCUMENT["paths"].as_object().unwrap().iter().find_map(operation) else {
        return Ok(());
    };
    let response = &operation["responses"][answer.status.to_string()];
    if response.is_null() {
        return Err(format!("there is no status {}", answer.status));
    }
    let kind = answer.kind.split(';').next().unwrap_or_default();
    if response["content"].is_null() && kind.is_empty() {
        return Ok(());
    }
    let content = &response["content"][kind];
    if content.is_null() {
        return Err(format!("status {} is never `{kind}`", answer.status));
    }
    let codes = &content["schema"]["properties"]["error"]["properties"]["code"]["enum"];
    match codes.as_array() {
        Some(codes) if !codes.contains(&answer.json()["error"]["code"]) => {
            Err(format!("{} is none of the codes {codes:?}", answer.json()["error"]["code"]))
        }
        _ => Ok(()),
    }
}

fn is_of(path: &str, template: &str) -> bool {
    let (path, template) = (path.split('/'), template.split('/'));
    path.clone().count() == template.clone().count()
        && path.zip(template).all(|(part, of_template)| of_template.starts_with('{') || part == of_template)
}

/// Every answer of these tests is checked. Here are some that the check must refuse.
///
/// Rules: HTTP-3
#[test]
fn an_answer_that_the_document_does_not_name_is_caught() {
    let answer = get(&SHARED, "/sessions/nowhere");
    assert_eq!(check("GET", "/sessions/nowhere", &answer), Ok(()));
    let planted = [
        HttpAnswer { status: 409, ..answer.clone() },
        HttpAnswer { kind: "text/plain".into(), ..answer.clone() },
        HttpAnswer { body: json!({"error": {"code": "exists", "message": "x"}}).to_string().into(), ..answer },
    ];
    for answer in planted {
        assert!(check("GET", "/sessions/nowhere", &answer).is_err(), "{answer:?}");
    }
    let made = post(&SHARED, "/sessions", r#"{"name": "documented"}"#);
    assert_eq!((made.status, check("POST", "/sessions", &made)), (201, Ok(())));
    assert!(check("GET", "/sessions", &made).is_err());
}
