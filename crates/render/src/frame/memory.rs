//! Counts the memory on a device: one budget for all renderers, and eviction if it is exceeded.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Purpose of memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemoryKind {
    /// Geometry and textures of scenes.
    Scenes,
    ShadowMaps,
    /// Work buffers of bent shadow maps.
    ShadowWork,
    /// Targets of viewers' pictures.
    Views,
    /// Layers: contributions of each light to viewers' pictures.
    Layers,
    /// Pictures that are drawn in tiles: memory for one tile, and for the finished pixels.
    Tiled,
}

impl MemoryKind {
    /// All kinds, in the order of the variants.
    pub const ALL: [Self; 6] =
        [Self::Scenes, Self::ShadowMaps, Self::ShadowWork, Self::Views, Self::Layers, Self::Tiled];

    /// Returns the identifier of the kind in metrics.
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

/// Counts the memory of a device against a limit. Clones share the count.
///
/// The bytes of each large allocation are counted. Data that can be made again is cached. If memory is short, the
/// budget first evicts data that no view or picture in progress needs, then the data that was used least recently. Data
/// that the current picture has used stays until that picture ends. This data, scenes and tiled pictures can exceed the
/// budget.
#[derive(Clone, Debug)]
pub struct MemoryBudget(Arc<Mutex<Account>>);

#[derive(Debug)]
struct Account {
    budget: u64,
    picture_number: u64,
    last_id: u64,
    allocations: BTreeMap<u64, Allocation>,
}

struct Allocation {
    kind: MemoryKind,
    bytes: u64,
    /// Number of the picture that last used the data.
    used: u64,
    needed: bool,
    /// Frees the data; `None` if it cannot be made again.
    evict: Option<Box<dyn FnOnce() + Send>>,
}

impl std::fmt::Debug for Allocation {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{} {} bytes, used {}, needed {}", self.kind.name(), self.bytes, self.used, self.needed)
    }
}

impl MemoryBudget {
    /// Default budget: the maps of 200 lights and a dozen large views.
    pub const DEFAULT_BUDGET: u64 = 4 << 30;

    /// Makes a budget of `budget` bytes, none of which are used.
    pub fn new(budget: u64) -> Self {
        Self(Arc::new(Mutex::new(Account { budget, picture_number: 0, last_id: 0, allocations: BTreeMap::new() })))
    }

    /// Returns the largest number of bytes that are cached. A single picture may need more.
    pub fn budget(&self) -> u64 {
        self.account().budget
    }

    /// Returns the counted bytes of one kind of memory.
    pub fn bytes(&self, kind: MemoryKind) -> u64 {
        self.account()
            .allocations
            .values()
            .filter(|allocation| allocation.kind == kind)
            .map(|allocation| allocation.bytes)
            .sum()
    }

    /// Returns all counted bytes.
    pub fn total(&self) -> u64 {
        self.account().total()
    }

    /// Begins a picture. Data that only earlier pictures have used may be evicted.
    pub(crate) fn begin_picture(&self) {
        self.account().picture_number += 1;
    }

    /// Counts `bytes` bytes until the returned reservation is dropped. Evicts cached data to make room.
    pub(crate) fn reserve(&self, kind: MemoryKind, bytes: u64) -> Reservation {
        self.make_room(bytes);
        Reservation { allocation: self.add(kind, bytes, None), memory: self.clone() }
    }

    /// Caches a value of `bytes` bytes, which may be evicted later.
    pub(crate) fn keep<T: Send + 'static>(&self, kind: MemoryKind, bytes: u64, value: T) -> Evictable<T> {
        self.make_room(bytes);
        let value = Arc::new(Mutex::new(Some(value)));
        let kept = Arc::clone(&value);
        let evict = move || drop(lock(&kept).take());
        Evictable {
            reservation: Reservation { allocation: self.add(kind, bytes, Some(Box::new(evict))), memory: self.clone() },
            value,
        }
    }

    /// Evicts data to make room for `bytes`. Returns true if there is room.
    pub(crate) fn make_room(&self, bytes: u64) -> bool {
        let mut gone = Vec::new();
        let mut account = self.account();
        while account.total() + bytes > account.budget {
            let now = account.picture_number;
            let may_go = account.allocations.iter().filter(|(_, a)| a.evict.is_some() && (a.used < now || !a.needed));
            let Some((&first, _)) = may_go.min_by_key(|(_, allocation)| (allocation.needed, allocation.used)) else {
                break;
            };
            gone.extend(account.allocations.remove(&first).and_then(|allocation| allocation.evict));
        }
        let room = account.total() + bytes <= account.budget;
        // Evicted data may hold reservations of its own.
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

/// Counted bytes of the budget. Dropping the reservation frees them.
#[derive(Debug)]
pub(crate) struct Reservation {
    allocation: u64,
    memory: MemoryBudget,
}

impl Drop for Reservation {
    fn drop(&mut self) {
        let allocation = self.memory.account().allocations.remove(&self.allocation);
        // After the lock is released: the dropped data may hold reservations of its own.
        drop(allocation);
    }
}

/// Cached value, which may have been evicted, and then has to be made again.
#[derive(Debug)]
pub(crate) struct Evictable<T> {
    value: Arc<Mutex<Option<T>>>,
    reservation: Reservation,
}

impl<T> Evictable<T> {
    /// Takes the value out of the cache and marks it as used by the current picture. `None` if it was evicted.
    pub fn take(&self) -> Option<T> {
        let mut account = self.reservation.memory.account();
        let now = account.picture_number;
        if let Some(allocation) = account.allocations.get_mut(&self.reservation.allocation) {
            allocation.used = now;
        }
        lock(&self.value).take()
    }

    pub fn put(&self, value: T) {
        // An allocation evicted meanwhile has no room for the value.
        let account = self.reservation.memory.account();
        if account.allocations.contains_key(&self.reservation.allocation) {
            *lock(&self.value) = Some(value);
        }
    }

    /// Calls `look` with the value, without marking it as used. `None` if it was evicted.
    pub fn peek<R>(&self, look: impl FnOnce(&T) -> R) -> Option<R> {
        lock(&self.value).as_ref().map(look)
    }

    /// Sets if a view or a picture in progress needs the value.
    pub fn set_needed(&self, needed: bool) {
        if let Some(allocation) = self.reservation.memory.account().allocations.get_mut(&self.reservation.allocation) {
            allocation.needed = needed;
        }
    }

    /// Changes the number of bytes of a value that grew or shrank while in use.
    pub fn resize(&self, bytes: u64) {
        let Reservation { allocation, memory } = &self.reservation;
        let before = memory.account().allocations.get(allocation).map_or(bytes, |allocation| allocation.bytes);
        memory.make_room(bytes.saturating_sub(before));
        if let Some(allocation) = memory.account().allocations.get_mut(allocation) {
            allocation.bytes = bytes;
        }
    }

    /// True if the value is in the cache: neither evicted nor taken out.
    pub fn is_present(&self) -> bool {
        lock(&self.value).is_some()
    }
}

/// Locks the mutex. Ignores poisoning, because a thread that panics leaves consistent numbers behind.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Caches three values of 10 bytes, each used by a different picture.
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
