//! What is kept on a device, in bytes: one account for all renderers, and what goes when there is too much.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What memory is kept for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemoryKind {
    /// Geometry and textures of scenes.
    Scenes,
    /// Shadow maps.
    ShadowMaps,
    /// What bent shadow maps are made in.
    ShadowWork,
    /// What viewers' pictures are drawn into.
    Views,
    /// Pictures that are drawn in tiles: a tile, and what there is of the picture.
    Tiled,
}

impl MemoryKind {
    /// All of them, in the order of the variants.
    pub const ALL: [Self; 5] = [Self::Scenes, Self::ShadowMaps, Self::ShadowWork, Self::Views, Self::Tiled];

    /// A name for programs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scenes => "scenes",
            Self::ShadowMaps => "shadow_maps",
            Self::ShadowWork => "shadow_work",
            Self::Views => "views",
            Self::Tiled => "tiled_pictures",
        }
    }
}

/// The account of a device's memory. Clones share it.
///
/// Each allocation of some size is entered with its bytes. Those that can be made again are only kept: where room is
/// short they go, first what no view or picture under way needs, then what was used longest ago. What the picture
/// that is being drawn has used stays until it is done: its bytes and those of scenes and tiles can pass the budget.
#[derive(Clone, Debug)]
pub struct Ledger(Arc<Mutex<Book>>);

#[derive(Debug)]
struct Book {
    budget: u64,
    /// Counts pictures that were begun.
    now: u64,
    last_line: u64,
    lines: BTreeMap<u64, Line>,
}

struct Line {
    kind: MemoryKind,
    bytes: u64,
    /// When it was last used.
    used: u64,
    needed: bool,
    /// Drops what it is of; `None` where that cannot be made again.
    evict: Option<Box<dyn FnOnce() + Send>>,
}

impl std::fmt::Debug for Line {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{} {} bytes, used {}, needed {}", self.kind.name(), self.bytes, self.used, self.needed)
    }
}

impl Ledger {
    /// What is kept at most where nobody says otherwise: the maps of 200 lights and a dozen large views.
    pub const DEFAULT_BUDGET: u64 = 4 << 30;

    /// An empty one; `budget` is in bytes.
    pub fn new(budget: u64) -> Self {
        Self(Arc::new(Mutex::new(Book { budget, now: 0, last_line: 0, lines: BTreeMap::new() })))
    }

    /// Bytes that are kept at most, but for what a picture needs at once.
    pub fn budget(&self) -> u64 {
        self.book().budget
    }

    /// Bytes of one kind.
    pub fn bytes(&self, kind: MemoryKind) -> u64 {
        self.book().lines.values().filter(|line| line.kind == kind).map(|line| line.bytes).sum()
    }

    /// Bytes of all kinds.
    pub fn total(&self) -> u64 {
        self.book().total()
    }

    /// Another picture is begun: what earlier ones have used may go.
    pub(crate) fn begin(&self) {
        self.book().now += 1;
    }

    /// Enters what lives as long as the answer.
    pub(crate) fn enter(&self, kind: MemoryKind, bytes: u64) -> Entry {
        self.make_room(bytes);
        Entry { line: self.add(kind, bytes, None), ledger: self.clone() }
    }

    /// Enters what may go when room is short.
    pub(crate) fn keep<T: Send + 'static>(&self, kind: MemoryKind, bytes: u64, value: T) -> Kept<T> {
        self.make_room(bytes);
        let value = Arc::new(Mutex::new(Some(value)));
        let kept = Arc::clone(&value);
        let evict = move || drop(lock(&kept).take());
        Kept {
            entry: Entry { line: self.add(kind, bytes, Some(Box::new(evict))), ledger: self.clone() },
            value,
        }
    }

    /// Lets go of as much as makes room for so many bytes, and says whether there is room now.
    pub(crate) fn make_room(&self, bytes: u64) -> bool {
        let mut gone = Vec::new();
        let mut book = self.book();
        while book.total() + bytes > book.budget {
            let now = book.now;
            let may_go = book.lines.iter().filter(|(_, l)| l.evict.is_some() && (l.used < now || !l.needed));
            let Some((&first, _)) = may_go.min_by_key(|(_, line)| (line.needed, line.used)) else { break };
            gone.extend(book.lines.remove(&first).and_then(|line| line.evict));
        }
        let room = book.total() + bytes <= book.budget;
        // What goes may hold entries of its own.
        drop(book);
        for evict in gone {
            evict();
        }
        room
    }

    fn add(&self, kind: MemoryKind, bytes: u64, evict: Option<Box<dyn FnOnce() + Send>>) -> u64 {
        let mut book = self.book();
        book.last_line += 1;
        let (line, used) = (book.last_line, book.now);
        book.lines.insert(line, Line { kind, bytes, used, needed: true, evict });
        line
    }

    fn book(&self) -> MutexGuard<'_, Book> {
        lock(&self.0)
    }
}

impl Default for Ledger {
    fn default() -> Self {
        Self::new(Self::DEFAULT_BUDGET)
    }
}

impl Book {
    fn total(&self) -> u64 {
        self.lines.values().map(|line| line.bytes).sum()
    }
}

/// A line of the ledger, struck out when this is dropped.
#[derive(Debug)]
pub(crate) struct Entry {
    line: u64,
    ledger: Ledger,
}

impl Drop for Entry {
    fn drop(&mut self) {
        let line = self.ledger.book().lines.remove(&self.line);
        // Outside of the lock: what it would drop may hold entries of its own.
        drop(line);
    }
}

/// Something that can be made again, and is gone where others needed its room.
#[derive(Debug)]
pub(crate) struct Kept<T> {
    value: Arc<Mutex<Option<T>>>,
    entry: Entry,
}

impl<T> Kept<T> {
    /// Takes it out for use, and so as used now; `None` where it is gone.
    pub fn take(&self) -> Option<T> {
        let mut book = self.entry.ledger.book();
        let now = book.now;
        if let Some(line) = book.lines.get_mut(&self.entry.line) {
            line.used = now;
        }
        lock(&self.value).take()
    }

    /// Puts it back.
    pub fn put(&self, value: T) {
        // Where its line was struck out meanwhile, there is no room for it.
        let book = self.entry.ledger.book();
        if book.lines.contains_key(&self.entry.line) {
            *lock(&self.value) = Some(value);
        }
    }

    /// Looks at it without using it.
    pub fn peek<R>(&self, look: impl FnOnce(&T) -> R) -> Option<R> {
        lock(&self.value).as_ref().map(look)
    }

    /// Says whether a view or a picture under way needs it.
    pub fn set_needed(&self, needed: bool) {
        if let Some(line) = self.entry.ledger.book().lines.get_mut(&self.entry.line) {
            line.needed = needed;
        }
    }

    /// Whether it is still there.
    pub fn is_there(&self) -> bool {
        lock(&self.value).is_some()
    }
}

/// A thread that panicked while it held this has left whole numbers behind.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Keeps three things of 10 bytes, each used by a picture of its own.
    fn three(ledger: &Ledger) -> [Kept<u8>; 3] {
        [0, 1, 2].map(|value| {
            ledger.begin();
            ledger.keep(MemoryKind::ShadowMaps, 10, value)
        })
    }

    fn there(kept: &[Kept<u8>]) -> Vec<bool> {
        kept.iter().map(Kept::is_there).collect()
    }

    #[test]
    fn what_was_used_longest_ago_goes() {
        let ledger = Ledger::new(30);
        let kept = three(&ledger);
        ledger.begin();
        kept[0].put(kept[0].take().unwrap());
        ledger.begin();
        let more = ledger.enter(MemoryKind::Tiled, 10);
        assert_eq!(there(&kept), [true, false, true]);
        assert_eq!((ledger.total(), ledger.bytes(MemoryKind::ShadowMaps)), (30, 20));
        drop(more);
        drop(kept);
        assert_eq!(ledger.total(), 0);
    }

    #[test]
    fn what_nobody_needs_goes_first() {
        let ledger = Ledger::new(30);
        let kept = three(&ledger);
        kept[2].set_needed(false);
        let _more = ledger.enter(MemoryKind::Views, 10);
        assert_eq!(there(&kept), [true, true, false]);
    }

    #[test]
    fn what_is_in_use_stays_though_it_passes_the_budget() {
        let ledger = Ledger::new(30);
        ledger.begin();
        let kept = [0, 1, 2].map(|value| ledger.keep(MemoryKind::ShadowMaps, 10, value));
        assert!(!ledger.make_room(10), "all is used by this picture");
        assert_eq!(there(&kept), [true; 3]);
        ledger.begin();
        assert!(ledger.make_room(10), "the next picture may have the room");
        assert_eq!(there(&kept), [false, true, true]);
    }
}
