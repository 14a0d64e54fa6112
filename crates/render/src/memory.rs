//! What is kept on a device, in bytes: one budget for all renderers, and what goes when there is too much.

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
    /// What each light alone adds to viewers' pictures.
    Layers,
    /// Pictures that are drawn in tiles: a tile, and what there is of the picture.
    Tiled,
}

impl MemoryKind {
    /// All of them, in the order of the variants.
    pub const ALL: [Self; 6] =
        [Self::Scenes, Self::ShadowMaps, Self::ShadowWork, Self::Views, Self::Layers, Self::Tiled];

    /// A name for programs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scenes => "scenes",
            Self::ShadowMaps => "shadow_maps",
            Self::ShadowWork => "shadow_work",
            Self::Views => "views",
            Self::Layers => "layers",
            Self::Tiled => "tiled_pictures",
        }
    }
}

/// How much memory of a device is in use, and how much may be. Clones share it.
///
/// Each allocation of some size is counted with its bytes. Those that can be made again are only kept: where room is
/// short they go, first what no view or picture under way needs, then what was used longest ago. What the picture
/// that is being drawn has used stays until it is done: its bytes and those of scenes and tiles can pass the budget.
#[derive(Clone, Debug)]
pub struct MemoryBudget(Arc<Mutex<Account>>);

#[derive(Debug)]
struct Account {
    budget: u64,
    /// Counts pictures that were begun.
    picture_number: u64,
    last_id: u64,
    allocations: BTreeMap<u64, Allocation>,
}

struct Allocation {
    kind: MemoryKind,
    bytes: u64,
    /// When it was last used.
    used: u64,
    needed: bool,
    /// Drops what it is of; `None` where that cannot be made again.
    evict: Option<Box<dyn FnOnce() + Send>>,
}

impl std::fmt::Debug for Allocation {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{} {} bytes, used {}, needed {}", self.kind.name(), self.bytes, self.used, self.needed)
    }
}

impl MemoryBudget {
    /// What is kept at most where nobody says otherwise: the maps of 200 lights and a dozen large views.
    pub const DEFAULT_BUDGET: u64 = 4 << 30;

    /// An empty one; `budget` is in bytes.
    pub fn new(budget: u64) -> Self {
        Self(Arc::new(Mutex::new(Account {
            budget,
            picture_number: 0,
            last_id: 0,
            allocations: BTreeMap::new(),
        })))
    }

    /// Bytes that are kept at most, but for what a picture needs at once.
    pub fn budget(&self) -> u64 {
        self.account().budget
    }

    /// Bytes of one kind.
    pub fn bytes(&self, kind: MemoryKind) -> u64 {
        self.account()
            .allocations
            .values()
            .filter(|allocation| allocation.kind == kind)
            .map(|allocation| allocation.bytes)
            .sum()
    }

    /// Bytes of all kinds.
    pub fn total(&self) -> u64 {
        self.account().total()
    }

    /// Another picture is begun: what earlier ones have used may go.
    pub(crate) fn begin_picture(&self) {
        self.account().picture_number += 1;
    }

    /// Counts what lives as long as the answer.
    pub(crate) fn reserve(&self, kind: MemoryKind, bytes: u64) -> Reservation {
        self.make_room(bytes);
        Reservation { allocation: self.add(kind, bytes, None), memory: self.clone() }
    }

    /// Counts what may go when room is short.
    pub(crate) fn keep<T: Send + 'static>(&self, kind: MemoryKind, bytes: u64, value: T) -> Evictable<T> {
        self.make_room(bytes);
        let value = Arc::new(Mutex::new(Some(value)));
        let kept = Arc::clone(&value);
        let evict = move || drop(lock(&kept).take());
        Evictable {
            reservation: Reservation {
                allocation: self.add(kind, bytes, Some(Box::new(evict))),
                memory: self.clone(),
            },
            value,
        }
    }

    /// Lets go of as much as makes room for so many bytes, and says whether there is room now.
    pub(crate) fn make_room(&self, bytes: u64) -> bool {
        let mut gone = Vec::new();
        let mut account = self.account();
        while account.total() + bytes > account.budget {
            let now = account.picture_number;
            let may_go =
                account.allocations.iter().filter(|(_, a)| a.evict.is_some() && (a.used < now || !a.needed));
            let Some((&first, _)) = may_go.min_by_key(|(_, allocation)| (allocation.needed, allocation.used))
            else {
                break;
            };
            gone.extend(account.allocations.remove(&first).and_then(|allocation| allocation.evict));
        }
        let room = account.total() + bytes <= account.budget;
        // What goes may hold reservations of its own.
        drop(account);
        for evict in gone {
            evict();
        }
        room
    }

    fn add(&self, kind: MemoryKind, bytes: u64, evict: Option<Box<dyn FnOnce() + Send>>) -> u64 {
        let mut account = self.account();
        account.last_id += 1;
        let (allocation, used) = (account.last_id, account.picture_number);
        account.allocations.insert(allocation, Allocation { kind, bytes, used, needed: true, evict });
        allocation
    }

    fn account(&self) -> MutexGuard<'_, Account> {
        lock(&self.0)
    }
}

impl Default for MemoryBudget {
    fn default() -> Self {
        Self::new(Self::DEFAULT_BUDGET)
    }
}

impl Account {
    fn total(&self) -> u64 {
        self.allocations.values().map(|allocation| allocation.bytes).sum()
    }
}

/// Bytes of the budget, given back when this is dropped.
#[derive(Debug)]
pub(crate) struct Reservation {
    allocation: u64,
    memory: MemoryBudget,
}

impl Drop for Reservation {
    fn drop(&mut self) {
        let allocation = self.memory.account().allocations.remove(&self.allocation);
        // Outside of the lock: what it would drop may hold reservations of its own.
        drop(allocation);
    }
}

/// Something that can be made again, and is gone where others needed its room.
#[derive(Debug)]
pub(crate) struct Evictable<T> {
    value: Arc<Mutex<Option<T>>>,
    reservation: Reservation,
}

impl<T> Evictable<T> {
    /// Takes it out for use, and so as used now; `None` where it is gone.
    pub fn take(&self) -> Option<T> {
        let mut account = self.reservation.memory.account();
        let now = account.picture_number;
        if let Some(allocation) = account.allocations.get_mut(&self.reservation.allocation) {
            allocation.used = now;
        }
        lock(&self.value).take()
    }

    /// Puts it back.
    pub fn put(&self, value: T) {
        // Where it was evicted meanwhile, there is no room for it.
        let account = self.reservation.memory.account();
        if account.allocations.contains_key(&self.reservation.allocation) {
            *lock(&self.value) = Some(value);
        }
    }

    /// Looks at it without using it.
    pub fn peek<R>(&self, look: impl FnOnce(&T) -> R) -> Option<R> {
        lock(&self.value).as_ref().map(look)
    }

    /// Says whether a view or a picture under way needs it.
    pub fn set_needed(&self, needed: bool) {
        if let Some(allocation) =
            self.reservation.memory.account().allocations.get_mut(&self.reservation.allocation)
        {
            allocation.needed = needed;
        }
    }

    /// Counts it with so many bytes from now on; what is in use has grown or shrunk.
    pub fn resize(&self, bytes: u64) {
        let Reservation { allocation, memory } = &self.reservation;
        let before =
            memory.account().allocations.get(allocation).map_or(bytes, |allocation| allocation.bytes);
        memory.make_room(bytes.saturating_sub(before));
        if let Some(allocation) = memory.account().allocations.get_mut(allocation) {
            allocation.bytes = bytes;
        }
    }

    /// Whether it is still there.
    pub fn is_present(&self) -> bool {
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
    fn three(memory: &MemoryBudget) -> [Evictable<u8>; 3] {
        [0, 1, 2].map(|value| {
            memory.begin_picture();
            memory.keep(MemoryKind::ShadowMaps, 10, value)
        })
    }

    fn there(kept: &[Evictable<u8>]) -> Vec<bool> {
        kept.iter().map(Evictable::is_present).collect()
    }

    #[test]
    fn what_was_used_longest_ago_goes() {
        let memory = MemoryBudget::new(30);
        let kept = three(&memory);
        memory.begin_picture();
        kept[0].put(kept[0].take().unwrap());
        memory.begin_picture();
        let more = memory.reserve(MemoryKind::Tiled, 10);
        assert_eq!(there(&kept), [true, false, true]);
        assert_eq!((memory.total(), memory.bytes(MemoryKind::ShadowMaps)), (30, 20));
        drop(more);
        drop(kept);
        assert_eq!(memory.total(), 0);
    }

    #[test]
    fn what_nobody_needs_goes_first() {
        let memory = MemoryBudget::new(30);
        let kept = three(&memory);
        kept[2].set_needed(false);
        let _more = memory.reserve(MemoryKind::Views, 10);
        assert_eq!(there(&kept), [true, true, false]);
    }

    #[test]
    fn what_grows_makes_room_for_itself() {
        let memory = MemoryBudget::new(30);
        let kept = three(&memory);
        memory.begin_picture();
        let value = kept[2].take().unwrap();
        kept[2].resize(20);
        kept[2].put(value);
        assert_eq!((there(&kept), memory.total()), (vec![false, true, true], 30));
        kept[2].resize(5);
        assert_eq!((there(&kept), memory.total()), (vec![false, true, true], 15));
        drop(kept);
        assert_eq!(memory.total(), 0);
    }

    #[test]
    fn what_is_in_use_stays_though_it_passes_the_budget() {
        let memory = MemoryBudget::new(30);
        memory.begin_picture();
        let kept = [0, 1, 2].map(|value| memory.keep(MemoryKind::ShadowMaps, 10, value));
        assert!(!memory.make_room(10), "all is used by this picture");
        assert_eq!(there(&kept), [true; 3]);
        memory.begin_picture();
        assert!(memory.make_room(10), "the next picture may have the room");
        assert_eq!(there(&kept), [false, true, true]);
    }
}
