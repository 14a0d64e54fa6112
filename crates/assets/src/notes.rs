//! Notes about content that was left out, grouped by kind.

/// Collects notes for people. All notes of one kind become one sentence, with the first example and a count.
#[derive(Debug, Default)]
pub struct Notes(Vec<Note>);

#[derive(Debug)]
struct Note {
    what: &'static str,
    first: String,
    count: usize,
}

impl Notes {
    /// Adds a note that `what` applies to the object called `whom`.
    pub fn add(&mut self, what: &'static str, whom: impl Into<String>) {
        match self.0.iter_mut().find(|note| note.what == what) {
            Some(note) => note.count += 1,
            None => self.0.push(Note { what, first: whom.into(), count: 1 }),
        }
    }

    /// Returns one sentence per kind, in the order of first appearance.
    pub fn into_sentences(self) -> Vec<String> {
        let sentence = |note: Note| match note.count {
            1 => format!("{}: {}", note.what, note.first),
            n => format!("{}: {} and {} more", note.what, note.first, n - 1),
        };
        self.0.into_iter().map(sentence).collect()
    }
}
