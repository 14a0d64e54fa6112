//! Threads that solve drags. The least charged client is next.
//!
//! Each solve has its own thread. As many run at once as there are cores, and the others wait. Every few milliseconds
//! of counted work a solve charges its client (`crate::charges`). It yields if a waiting solve is of a less charged
//! client. Short solves precede long ones. Long solves run on threads of idle priority, so pictures are hardly delayed.
//! All solves of a client that has used up its allowance count as long, even cancelled ones. A cancelled solve ends at
//! its next check.

use std::cmp::Ordering as Order;
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, Thread};
use std::time::{Duration, Instant};

use prometheus_client::metrics::gauge::Gauge;
use tokio::sync::oneshot;

use crate::ServerError;
use crate::allowances::Allowances;
use crate::background;
use crate::charges::{Charges, Payer};
use crate::limits::{MAX_SOLVES, SHORT_SOLVE_RATE, SHORT_SOLVE_STEPS};
use crate::views::MovingPixels;

/// Factor of the pause of a long solve to the work before it, while views of other clients move.
const LONG_SOLVE_REST_FACTOR: u32 = 3;
/// Greatest pause of a long solve. It limits the pause if the thread was delayed and so seems to have worked long.
const MAX_REST: Duration = Duration::from_millis(60);

/// Handle to the threads that solve drags. Clones share them.
#[derive(Clone)]
pub struct Solver {
    queue: Arc<Mutex<SolveQueue>>,
    /// Actors whose views move, by whom long solves are slowed.
    moving: Arc<MovingPixels>,
    /// Number of solves that run or wait.
    under_way: Gauge,
}

impl fmt::Debug for Solver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Solver({} under way)", self.under_way.get())
    }
}

/// Queue of solves and their charges.
struct SolveQueue {
    charges: Charges,
    /// Solver time that each client may still use before its solves count as long.
    allowances: Allowances,
    waiting: Vec<QueuedSolve>,
    /// Number of running short solves, and of running long ones. A long solve may yield late, because everything else
    /// runs before it.
    running: [usize; 2],
    /// Greatest number of running short solves. A long solve runs if short ones leave a slot of this number free.
    max_running: usize,
    /// Number of solves that run or wait.
    total: usize,
    next_number: u64,
}

struct QueuedSolve {
    number: u64,
    payer: Payer,
    is_long: bool,
    thread: Thread,
}

impl SolveQueue {
    /// True if there is a slot for another solve.
    fn has_room(&self, is_long: bool) -> bool {
        let [short, long] = self.running;
        if is_long { short + long < self.max_running } else { short < self.max_running }
    }

    /// Returns the index of the next waiting solve: short before long, then the least charged client, then the oldest.
    fn next(&self) -> Option<usize> {
        let order = |a: &usize, b: &usize| {
            let (a, b) = (&self.waiting[*a], &self.waiting[*b]);
            self.cmp_priority(a.is_long, &a.payer, b).then(a.number.cmp(&b.number))
        };
        (0..self.waiting.len()).min_by(order)
    }

    /// Compares a solve with a waiting one. The lesser is next.
    fn cmp_priority(&self, is_long: bool, payer: &Payer, other: &QueuedSolve) -> Order {
        let by_charge = || self.charges.of(payer).order(&self.charges.of(&other.payer));
        is_long.cmp(&other.is_long).then_with(by_charge)
    }

    /// Lets waiting solves run while there are slots.
    fn admit_waiting(&mut self) {
        while let Some(next) = self.next()
            && self.has_room(self.waiting[next].is_long)
        {
            let QueuedSolve { is_long, thread, .. } = self.waiting.remove(next);
            self.running[usize::from(is_long)] += 1;
            thread.unpark();
        }
    }
}

/// A solve on its own thread, running or waiting.
pub struct SolveTurn {
    solver: Solver,
    payer: Payer,
    number: u64,
    is_long: bool,
    /// Start of the time that is not charged yet. `None` while the solve waits.
    since: Option<Instant>,
    is_cancelled: Arc<AtomicBool>,
}

/// Cancels a solve when its asker is dropped.
struct CancelOnDrop {
    is_cancelled: Arc<AtomicBool>,
    thread: Thread,
}

impl Drop for CancelOnDrop {
    fn drop(&mut self) {
        self.is_cancelled.store(true, Ordering::Release);
        self.thread.unpark();
    }
}

impl Solver {
    /// Makes a solver that runs up to `most` solves at once. `under_way` counts the solves that run or wait. Long
    /// solves work a quarter of the time while views of other clients move.
    pub fn new(most: usize, under_way: Gauge, moving: Arc<MovingPixels>) -> Self {
        let (charges, waiting) = (Charges::default(), Vec::new());
        let allowances = Allowances::new(SHORT_SOLVE_RATE);
        let queue =
            SolveQueue { charges, allowances, waiting, running: [0; 2], max_running: most, total: 0, next_number: 0 };
        Self { queue: Arc::new(Mutex::new(queue)), moving, under_way }
    }

    /// Runs `solve` on its own thread once the queue admits it, and returns its result. Dropping the future cancels the
    /// solve: [`SolveTurn::may_continue`] returns false within some milliseconds.
    pub async fn run<T: Send + 'static>(
        &self,
        payer: Payer,
        solve: impl FnOnce(&mut SolveTurn) -> T + Send + 'static,
    ) -> Result<T, ServerError> {
        let mut turn = self.turn(payer)?;
        let is_cancelled = Arc::clone(&turn.is_cancelled);
        let (done, answer) = oneshot::channel();
        let run = move || {
            if turn.is_long {
                background::set_idle_priority();
            }
            if turn.wait() {
                let solved = solve(&mut turn);
                drop(turn);
                // Without an asker the answer is dropped.
                let _ = done.send(solved);
            }
        };
        let thread = thread::Builder::new().name("solve".into()).spawn(run).map_err(|error| {
            tracing::error!("no thread could be started to solve a drag: {error}");
            ServerError::Internal
        })?;
        let _asker = CancelOnDrop { is_cancelled, thread: thread.thread().clone() };
        answer.await.map_err(|_| ServerError::Internal)
    }

    fn queue(&self) -> MutexGuard<'_, SolveQueue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a solve to the count of those under way. Gives an error if there are too many. The solve does not run until
    /// `SolveTurn::wait` returns true.
    fn turn(&self, payer: Payer) -> Result<SolveTurn, ServerError> {
        let mut queue = self.queue();
        if queue.total >= MAX_SOLVES {
            return Err(ServerError::TooMany { what: "drags that are solved", limit: MAX_SOLVES });
        }
        queue.total += 1;
        queue.next_number += 1;
        self.under_way.inc();
        Ok(SolveTurn {
            solver: self.clone(),
            number: queue.next_number,
            is_long: !queue.allowances.has_tokens(&payer, Instant::now()),
            payer,
            since: None,
            is_cancelled: Arc::default(),
        })
    }
}

impl SolveTurn {
    /// Charges the work since the last call, and waits if a less charged client is next. Returns false if the solve is
    /// cancelled. `steps` is the number of steps that the solve has taken. Above a limit the solve counts as long.
    pub fn may_continue(&mut self, steps: u64) -> bool {
        if self.is_cancelled.load(Ordering::Acquire) {
            return false;
        }
        let worked = self.charge();
        let has_allowance = || self.solver.queue().allowances.has_tokens(&self.payer, Instant::now());
        if !self.is_long && (steps >= SHORT_SOLVE_STEPS || !has_allowance()) {
            self.is_long = true;
            let mut queue = self.solver.queue();
            let [short, long] = queue.running;
            queue.running = [short - 1, long + 1];
            queue.admit_waiting();
            drop(queue);
            background::set_idle_priority();
        }
        if self.is_long && self.solver.moving.is_another_interacting(self.payer.actor_id(), Instant::now()) {
            // Even a thread of idle priority uses caches, memory and half of a core shared by two threads.
            thread::park_timeout((worked * LONG_SOLVE_REST_FACTOR).min(MAX_REST));
            self.since = Some(Instant::now());
        }
        let queue = self.solver.queue();
        let has_priority = |next: usize| queue.cmp_priority(self.is_long, &self.payer, &queue.waiting[next]).is_gt();
        let yields = queue.next().is_some_and(has_priority);
        drop(queue);
        !yields || {
            self.release_slot();
            self.wait()
        }
    }

    /// Waits for a slot. Returns `false` if the solve is cancelled.
    fn wait(&mut self) -> bool {
        let mut queue = self.solver.queue();
        queue.waiting.push(QueuedSolve {
            number: self.number,
            payer: self.payer.clone(),
            is_long: self.is_long,
            thread: thread::current(),
        });
        queue.admit_waiting();
        while let Some(index) = queue.waiting.iter().position(|waiting| waiting.number == self.number) {
            if self.is_cancelled.load(Ordering::Acquire) {
                queue.waiting.remove(index);
                return false;
            }
            drop(queue);
            thread::park();
            queue = self.solver.queue();
        }
        self.since = Some(Instant::now());
        true
    }

    /// Charges the time since the last charge and returns it.
    fn charge(&mut self) -> Duration {
        let now = Instant::now();
        let Some(since) = self.since.replace(now) else { return Duration::ZERO };
        let worked = now.saturating_duration_since(since);
        let mut queue = self.solver.queue();
        queue.charges.charge(&self.payer, worked.as_secs_f64());
        if !self.is_long {
            queue.allowances.take(&self.payer, worked.as_secs_f64(), now);
        }
        worked
    }

    /// Frees the solve's slot for another solve.
    fn release_slot(&mut self) {
        if self.since.take().is_some() {
            let mut queue = self.solver.queue();
            queue.running[usize::from(self.is_long)] -= 1;
            queue.admit_waiting();
        }
    }
}

impl Drop for SolveTurn {
    fn drop(&mut self) {
        if self.since.is_some() {
            self.charge();
        }
        self.release_slot();
        self.solver.queue().total -= 1;
        self.solver.under_way.dec();
    }
}

#[cfg(test)]
mod tests {
    use render::ViewSlot;

    use super::*;

    fn payer(session: &str) -> Payer {
        Payer::new(&session.into(), session)
    }

    /// Runs solves with the given numbers of checks, each after a millisecond, and returns the order in which they end.
    /// With `yields` set to false they never yield, which is a deliberate fault.
    async fn ends(solves: &[(&'static str, u64)], yields: bool) -> Vec<&'static str> {
        let solver = Solver::new(1, Gauge::default(), Arc::default());
        let ended = Arc::new(Mutex::new(Vec::new()));
        let mut tasks = Vec::new();
        for &(session, questions) in solves {
            let (solver, ended) = (solver.clone(), Arc::clone(&ended));
            tasks.push(tokio::spawn(async move {
                let solve = move |turn: &mut SolveTurn| {
                    for question in 1..=questions {
                        thread::sleep(Duration::from_millis(1));
                        assert!(!yields || turn.may_continue(question * SHORT_SOLVE_STEPS / 4));
                    }
                    ended.lock().unwrap().push(session);
                };
                solver.run(payer(session), solve).await.expect("solved");
            }));
            // Keeps the order of arrival.
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        for task in tasks {
            task.await.expect("it ends");
        }
        assert_eq!(solver.under_way.get(), 0);
        Arc::into_inner(ended).expect("all have ended").into_inner().unwrap()
    }

    /// A client with a little work does not wait for the large work of another. If two have much work, the later one
    /// ends first if it has half as much.
    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn the_less_charged_client_is_next() {
        let greedy = ("greedy", 200);
        assert_eq!(ends(&[greedy, ("short", 3)], true).await, ["short", "greedy"]);
        assert_eq!(ends(&[greedy, ("half", 80)], true).await, ["half", "greedy"]);
        let many = ends(&[greedy, greedy, greedy, ("fair", 100)], true).await;
        assert_eq!(many[0], "fair", "{many:?}");
        // Deliberate fault that the check must detect: first come, first served.
        assert_eq!(ends(&[greedy, ("short", 3)], false).await, ["greedy", "short"]);
    }

    /// Measures the time of a long solve of Ada's while a view of the actor `of` moves.
    async fn takes_while_a_view_moves(of: &str) -> Duration {
        let moving = Arc::<MovingPixels>::default();
        let solver = Solver::new(1, Gauge::default(), Arc::clone(&moving));
        let actor_id = of.into();
        let solve = move |turn: &mut SolveTurn| {
            let began = Instant::now();
            for _ in 0..50 {
                moving.record_picture(&actor_id, ViewSlot(1), true, [640, 360], Instant::now());
                thread::sleep(Duration::from_millis(2));
                assert!(turn.may_continue(SHORT_SOLVE_STEPS));
            }
            began.elapsed()
        };
        solver.run(payer("ada"), solve).await.expect("solved")
    }

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn a_long_solve_rests_three_times_as_long_as_it_works_while_anothers_view_moves() {
        let of_another = takes_while_a_view_moves("ben").await;
        // The one beside another takes at least four times as long. The own one is the least of three, to leave out
        // delays of the machine.
        let mut own = Duration::MAX;
        for _ in 0..3 {
            own = own.min(takes_while_a_view_moves("ada").await);
        }
        assert!(of_another > own.mul_f64(3.0), "{own:?} and {of_another:?}");
    }

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn a_cancelled_solve_ends_also_while_it_waits() {
        let solver = Solver::new(1, Gauge::default(), Arc::default());
        let endless = |turn: &mut SolveTurn| while turn.may_continue(SHORT_SOLVE_STEPS) {};
        let start = || {
            let solver = solver.clone();
            tokio::spawn(async move { solver.run(payer("ada"), endless).await })
        };
        let all: Vec<_> = (0..3).map(|_| start()).collect();
        while solver.under_way.get() < 3 {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        all.iter().for_each(tokio::task::JoinHandle::abort);
        while solver.under_way.get() > 0 {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        let queue = solver.queue();
        assert_eq!((queue.total, queue.running, queue.waiting.len()), (0, [0, 0], 0));
    }

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn a_solve_that_panics_frees_its_slot() {
        let solver = Solver::new(1, Gauge::default(), Arc::default());
        let failed = solver.run(payer("ada"), |_| panic!("planted")).await;
        assert!(matches!(failed, Err::<(), _>(ServerError::Internal)));
        assert_eq!(solver.run(payer("ada"), |_| 7).await.expect("solved"), 7);
    }
}
