//! The first message, and messages that cannot be read.

use protocol::{ClientMessage, GestureStatus, ServerMessage};

use crate::client::{Client, hello};
use crate::server::{OwnServer, SHARED};

/// Returns the code of a fatal error, after which the socket is closed.
async fn fatal(client: &mut Client) -> String {
    let (code, message) = client.fatal_error().await;
    assert!(message.len() > 20, "{message}");
    assert!(client.next().await.is_none(), "the socket stays open");
    code.name().into()
}

/// Rules: SOCK-1
#[tokio::test]
async fn a_hello_that_does_not_fit_is_answered_and_the_socket_closed() {
    let token = SHARED.token.as_str();
    let text = |message: &ClientMessage| serde_json::to_string(message).unwrap();
    let other_protocol = text(&hello(token, "main", "Ada")).replace("\"protocol\":1", "\"protocol\":2");
    let cases = [
        (text(&hello("0123456789abcdef0123456789abcdef", "main", "Ada")), "unauthorized"),
        (text(&hello("", "main", "Ada")), "unauthorized"),
        (text(&hello(token, "nowhere", "Ada")), "notFound"),
        (other_protocol, "protocol"),
        (text(&ClientMessage::Ping { sent: 1.0 }), "protocol"),
    ];
    for (message, code) in cases {
        let mut client = Client::connect(&SHARED).await;
        client.say_text(message).await;
        // A later message of the client must not prevent it from reading the reason.
        client.say(&ClientMessage::Ping { sent: 2.0 }).await;
        assert_eq!(fatal(&mut client).await, code);
    }
    let (_, welcome) = Client::join(&SHARED, "main", "Ada").await;
    assert_eq!((welcome.protocol, welcome.session.as_str()), (1, "main"));
}

/// Rules: SOCK-1, GEST-3
#[tokio::test]
async fn hello_and_gestures_have_their_time() {
    let own = OwnServer::start().await;
    let (mut client, welcome) = Client::join(&own.door, "main", "Ada").await;
    let mut silent = Client::connect(&own.door).await;
    client.say(&ClientMessage::GestureBegin { gesture: "g".into(), light: 1, base_seq: welcome.seq }).await;
    let status = |message| if let ServerMessage::GestureState(state) = message { Some(state.status) } else { None };
    assert_eq!(client.until(status).await, GestureStatus::Held { refused: None });
    // From here on time advances once everybody waits.
    tokio::time::pause();
    let began = tokio::time::Instant::now();
    assert_eq!(fatal(&mut silent).await, "helloTooLate");
    assert!(began.elapsed().as_secs() < 30, "the gesture's lease is longer than the time for a hello");
    assert_eq!(client.until(status).await, GestureStatus::Expired);
}

/// Rules: SOCK-6
#[tokio::test]
async fn an_unreadable_message_is_named_and_the_connection_goes_on() {
    let (mut client, _) = Client::join(&SHARED, "main", "Eve").await;
    let texts = [
        ("{", "JSON"),
        (r#"{"type": "paint"}"#, "paint"),
        (r#"{"type": "ack"}"#, "frame"),
        (r#"{"type": "presence", "selection": null, "mood": 1}"#, "mood"),
    ];
    for (text, named) in texts {
        client.say_text(text).await;
        let (code, message) = client.until(complaint).await;
        assert!(code == "badMessage" && message.contains(named), "{text}: {code}: {message}");
    }
    client.say_bytes(vec![1, 2, 3]).await;
    assert_eq!(client.until(complaint).await.0, "badMessage");
    client.say(&ClientMessage::Ping { sent: 7.5 }).await;
    client.until(|message| matches!(message, ServerMessage::Pong { sent: 7.5, .. }).then_some(())).await;
}

/// Returns the code and message of an error that is not fatal.
pub fn complaint(message: ServerMessage) -> Option<(String, String)> {
    match message {
        ServerMessage::Error { code, message, fatal: false } => Some((code.name().into(), message)),
        _ => None,
    }
}
