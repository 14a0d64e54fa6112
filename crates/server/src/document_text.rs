//! JSON of a document, made once per revision for all clients.

use std::sync::{Arc, OnceLock};

use axum::body::Bytes;
use document::Document;

use crate::in_flight::{ByteBudget, ByteReservation};

/// JSON of the document after one record. Its bytes count as in flight as long as any clone exists.
#[derive(Debug)]
pub struct DocumentText {
    document: Document,
    in_flight: ByteBudget,
    made: OnceLock<(String, ByteReservation)>,
}

impl DocumentText {
    /// Wraps the document. The text is made when it is first needed.
    pub fn new(document: Document, in_flight: ByteBudget) -> Self {
        Self { document, in_flight, made: OnceLock::new() }
    }

    /// Returns the text, and makes it first if necessary. That takes long for a large document.
    pub fn bytes(self: Arc<Self>) -> Bytes {
        self.json();
        Bytes::from_owner(Shared(self))
    }

    fn json(&self) -> &str {
        let make = || {
            let document = protocol::Document::from(&self.document);
            let json = serde_json::to_string(&document).expect("plain data with string keys");
            let reservation = self.in_flight.reserve_unchecked(json.len());
            (json, reservation)
        };
        &self.made.get_or_init(make).0
    }
}

struct Shared(Arc<DocumentText>);

impl AsRef<[u8]> for Shared {
    fn as_ref(&self) -> &[u8] {
        self.0.json().as_bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_made_once_and_counts_as_in_flight_while_a_clone_exists() {
        let in_flight = ByteBudget::default();
        let text = Arc::new(DocumentText::new(Document::default(), in_flight.clone()));
        assert_eq!(in_flight.bytes(), 0, "nobody has asked");
        let (one, two) = (Arc::clone(&text).bytes(), Arc::clone(&text).bytes());
        assert!(one.as_ptr() == two.as_ptr() && in_flight.bytes() == one.len(), "both are the same bytes");
        drop((text, one));
        assert_eq!(in_flight.bytes(), two.len());
        drop(two);
        assert_eq!(in_flight.bytes(), 0);
    }
}
