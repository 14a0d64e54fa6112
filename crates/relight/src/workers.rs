//! Worker threads for relighting: one per core, regardless of the number of callers. Work on many items stops between
//! two items if other work has to be done first.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rayon::{ThreadPool, ThreadPoolBuilder};

/// Pool of threads for relighting. Calls block until the work is done.
#[derive(Debug)]
pub struct Workers {
    pool: ThreadPool,
    pub(crate) yielding: YieldPolicy,
}

/// Bytes of new memory that are written between two yield points: some milliseconds on a machine with slow page faults.
const NEW_BYTES_AT_ONCE: usize = 1 << 20;

/// Policy by which long work stops at yield points to let other work go first. By default it never stops.
#[derive(Clone, Default)]
pub struct YieldPolicy(Option<Arc<YieldCallbacks>>);

/// Callbacks that a yield point calls.
struct YieldCallbacks {
    should_yield: Box<dyn Fn() -> bool + Send + Sync>,
    yield_now: Box<dyn Fn() -> bool + Send + Sync>,
    run_in_background: Box<BackgroundRunner>,
}

/// Runs the given work while other work goes first. Returns false if the caller has been cancelled meanwhile.
type BackgroundRunner = dyn Fn(&mut (dyn FnMut() + Send)) -> bool + Send + Sync;

/// Error of work that was cancelled at a yield point. Its partial result is useless.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cancelled;

/// Items that a call of `Workers::each` has not finished.
struct Queue<I, T> {
    new: I,
    /// Items whose work has begun and returned before it was finished.
    begun: Vec<T>,
}

impl YieldPolicy {
    /// Makes a policy from three callbacks.
    ///
    /// `should_yield` returns true if other work has to go first. It may be called on any thread, and does not block.
    /// If it returned true, `yield_now` is called on the thread that requested the work. `yield_now` returns when the
    /// work may go on, or returns false if the work is cancelled. `run_in_background` runs long work that does not
    /// hinder other work, while that goes first. It returns when the long work is done and its caller may go on, or
    /// returns false if the caller is cancelled.
    pub fn new(
        should_yield: impl Fn() -> bool + Send + Sync + 'static,
        yield_now: impl Fn() -> bool + Send + Sync + 'static,
        run_in_background: impl Fn(&mut (dyn FnMut() + Send)) -> bool + Send + Sync + 'static,
    ) -> Self {
        Self(Some(Arc::new(YieldCallbacks {
            should_yield: Box::new(should_yield),
            yield_now: Box::new(yield_now),
            run_in_background: Box::new(run_in_background),
        })))
    }

    /// True if other work has to go first.
    pub fn should_yield(&self) -> bool {
        self.0.as_deref().is_some_and(|calls| (calls.should_yield)())
    }

    /// Lets other work go first if it has to. Gives an error if the present work is cancelled meanwhile.
    pub fn yield_point(&self) -> Result<(), Cancelled> {
        match self.0.as_deref() {
            Some(calls) if (calls.should_yield)() && !(calls.yield_now)() => Err(Cancelled),
            _ => Ok(()),
        }
    }

    /// Runs long work that does not use the device, while other work uses it. Gives an error if the caller is cancelled
    /// meanwhile.
    pub fn run_in_background<T: Send>(&self, work: impl FnOnce() -> T + Send) -> Result<T, Cancelled> {
        let Some(calls) = self.0.as_deref() else { return Ok(work()) };
        let (mut work, mut done) = (Some(work), None);
        let goes_on = (calls.run_in_background)(&mut || done = work.take().map(|work| work()));
        done.filter(|_| goes_on).ok_or(Cancelled)
    }
}

impl std::fmt::Debug for YieldPolicy {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(if self.0.is_some() { "Yielding" } else { "Yielding(never)" })
    }
}

impl Workers {
    /// Makes a pool of `count` threads, 0 for one per core. It never yields.
    pub fn with_threads(count: usize) -> Self {
        let name = |index| format!("relight {index}");
        let pool = ThreadPoolBuilder::new().num_threads(count).thread_name(name).build();
        let pool = pool.expect("a program that cannot start threads cannot draw");
        Self { pool, yielding: YieldPolicy::default() }
    }

    /// Returns the pool with another yield policy.
    #[must_use]
    pub fn with_yield_policy(self, yielding: YieldPolicy) -> Self {
        Self { yielding, ..self }
    }

    /// Returns the number of threads in the pool.
    pub fn count(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Runs `work` in the pool, where rayon's iterators use its threads.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.pool.install(work)
    }

    /// Runs `work` on each item, in any order. Each thread takes the next item when it has finished one.
    ///
    /// Other work goes first if [`YieldPolicy::should_yield`] is true after an item. `work` may also return false in
    /// the middle of an item if it finds that. The item is then continued later.
    pub(crate) fn each<T: Send>(
        &self,
        items: impl ExactSizeIterator<Item = T> + Send,
        work: impl Fn(&mut T) -> bool + Sync,
    ) -> Result<(), Cancelled> {
        let queue = Mutex::new(Queue { new: items, begun: Vec::new() });
        // A closure, since the condition of a loop would hold the lock while the item is worked on.
        let next = || lock(&queue).next();
        loop {
            let unfinished = Mutex::new(Vec::new());
            self.pool.broadcast(|_| {
                while let Some(mut item) = next() {
                    if !work(&mut item) {
                        lock(&unfinished).push(item);
                    }
                    if self.yielding.should_yield() {
                        break;
                    }
                }
            });
            let mut left = lock(&queue);
            left.begun.append(&mut lock(&unfinished));
            if left.begun.is_empty() && left.new.len() == 0 {
                return Ok(());
            }
            drop(left);
            self.yielding.yield_point()?;
        }
    }

    /// Resizes `items` to `count` with copies of `item`. Does so in parts, with a yield point after each, because the
    /// operating system is slow to provide new memory.
    pub(crate) fn resize<T: Copy>(&self, items: &mut Vec<T>, count: usize, item: T) -> Result<(), Cancelled> {
        items.truncate(count);
        items.reserve_exact(count - items.len());
        while items.len() < count {
            let part = (NEW_BYTES_AT_ONCE / size_of::<T>().max(1)).max(1);
            items.resize(count.min(items.len() + part), item);
            self.yielding.yield_point()?;
        }
        Ok(())
    }
}

impl<T, I: Iterator<Item = T>> Queue<I, T> {
    fn next(&mut self) -> Option<T> {
        self.begun.pop().or_else(|| self.new.next())
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::time::{Duration, Instant};

    use super::*;

    /// Makes a policy that always yields and counts how often. It cancels the work at the yield with the number
    /// `cancelled_at`.
    fn counting(cancelled_at: usize) -> (YieldPolicy, Arc<AtomicUsize>) {
        let count = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&count);
        let yield_now = move || counted.fetch_add(1, Ordering::Relaxed) + 1 != cancelled_at;
        (YieldPolicy::new(|| true, yield_now, |work| (work(), true).1), count)
    }

    /// Each of two items waits until work on the other has begun. If one thread ran both, or if one ran after the
    /// other, they would wait for ever.
    #[test]
    fn threads_work_on_items_at_the_same_time() {
        let begun = AtomicUsize::new(0);
        let until = Instant::now() + Duration::from_secs(20);
        let has_met = |others: usize| {
            begun.fetch_add(1, Ordering::SeqCst);
            while begun.load(Ordering::SeqCst) < others && Instant::now() < until {
                std::thread::yield_now();
            }
            begun.load(Ordering::SeqCst) >= others
        };
        let met = AtomicUsize::new(0);
        let ended = Workers::with_threads(2).each([(), ()].into_iter(), |()| {
            met.fetch_add(usize::from(has_met(2)), Ordering::SeqCst);
            true
        });
        assert_eq!((ended, met.into_inner()), (Ok(()), 2));
    }

    #[test]
    fn each_item_is_finished_once_however_often_it_yields() {
        let (yielding, count) = counting(usize::MAX);
        for workers in [Workers::with_threads(2), Workers::with_threads(2).with_yield_policy(yielding)] {
            let done: Vec<AtomicUsize> = (0..100).map(|_| AtomicUsize::new(0)).collect();
            // Every third item takes three turns.
            let items: Vec<(usize, usize)> = (0..100).map(|k| (k, if k % 3 == 0 { 3 } else { 1 })).collect();
            let ended = workers.each(items.into_iter(), |(index, left)| {
                *left -= 1;
                if *left == 0 {
                    done[*index].fetch_add(1, Ordering::Relaxed);
                }
                *left == 0
            });
            assert_eq!(ended, Ok(()));
            assert!(done.iter().all(|done| done.load(Ordering::Relaxed) == 1));
        }
        assert!(count.load(Ordering::Relaxed) >= 160 / 2, "{count:?}");
    }

    #[test]
    fn cancelled_work_ends() {
        let (yielding, count) = counting(3);
        let workers = Workers::with_threads(2).with_yield_policy(yielding);
        let ended = workers.each(0..1_000, |_| true);
        assert_eq!((ended, count.load(Ordering::Relaxed)), (Err(Cancelled), 3));
    }
    #[test]
    fn resizing_yields_between_parts_and_keeps_the_items() {
        let (yielding, count) = counting(4);
        let workers = Workers::with_threads(1).with_yield_policy(yielding);
        let mut items = vec![1_u64; 3];
        let part = NEW_BYTES_AT_ONCE / size_of::<u64>();
        assert_eq!(workers.resize(&mut items, 2 * part, 2), Ok(()));
        assert_eq!((items.len(), &items[..3], items[3], items.last()), (2 * part, &[1; 3][..], 2, Some(&2)));
        assert_eq!(count.load(Ordering::Relaxed), 2, "once a part");
        assert_eq!(workers.resize(&mut items, 2, 3), Ok(()), "what is there already takes no time");
        assert_eq!((items.as_slice(), count.load(Ordering::Relaxed)), (&[1, 1][..], 2));
        assert_eq!(workers.resize(&mut items, 5 * part, 3), Err(Cancelled));
    }

    #[test]
    fn background_work_returns_its_result_unless_it_is_cancelled_or_never_run() {
        let result = |does: bool, goes_on: bool| {
            let run_in_background = move |work: &mut (dyn FnMut() + Send)| {
                if does {
                    work();
                }
                goes_on
            };
            YieldPolicy::new(|| false, || true, run_in_background).run_in_background(|| 7)
        };
        assert_eq!(YieldPolicy::default().run_in_background(|| 7), Ok(7));
        assert_eq!(result(true, true), Ok(7));
        assert_eq!(result(true, false), Err(Cancelled), "its drawing is over");
        assert_eq!(result(false, true), Err(Cancelled), "no thread could be started");
    }
}
