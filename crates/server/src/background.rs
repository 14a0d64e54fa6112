//! Background work of the CPU that is not for the next picture: decoding scenes, building BVHs, probes. Its threads
//! have a lower priority than those that draw. A file that takes a second to decode delays nobody's pictures by that
//! second.

use std::{io, thread};

#[cfg(target_os = "linux")]
use thread_priority::{
    NormalThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy, set_thread_priority_and_policy, thread_native_id,
};
use tokio::runtime::{self, Runtime};
use tokio::sync::oneshot;

use crate::ServerError;

/// Increase of the nice value of threads that answer requests. Beside a thread that draws, such a thread gets a
/// thirtieth of a core, so thousands of requests per second of one client cost a moving picture no more than that.
const NICE: i32 = 15;
/// Number of request threads: enough to answer while one of them writes a long answer.
const REQUEST_THREADS: usize = 2;

/// Makes the runtime on which [`crate::Server::run`] answers HTTP requests. Its threads have a lower priority than
/// drawing and sockets. The caller shuts it down.
pub fn request_runtime() -> io::Result<Runtime> {
    let mut threads = runtime::Builder::new_multi_thread();
    threads.worker_threads(REQUEST_THREADS).thread_name("request").enable_all();
    threads.on_thread_start(|| lower_priority(NICE)).build()
}

/// Runs `work` on a new background thread. The caller limits their number.
pub async fn run<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Result<T, ServerError> {
    let (done, result) = oneshot::channel();
    let named = thread::Builder::new().name("background".into());
    let started = named.spawn(move || {
        set_idle_priority();
        // The asker may be gone.
        drop(done.send(work()));
    });
    if let Err(error) = started {
        tracing::error!("no thread can be started: {error}");
        return Err(ServerError::Internal);
    }
    result.await.map_err(|_| ServerError::Internal)
}

/// Runs `work` like [`run`] while it holds `permit`, and returns the permit with the result. If nobody waits for the
/// result any more, the permit is still held until the work is done.
pub async fn run_with<P: Send + 'static, T: Send + 'static>(
    permit: P,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<(T, P), ServerError> {
    run(move || (work(), permit)).await
}

/// Runs `work` on a background thread and waits for it. Returns the panic of the work as an error, and false if no
/// thread could be started.
pub fn run_blocking(work: &mut (dyn FnMut() + Send)) -> thread::Result<bool> {
    thread::scope(|scope| {
        let started = thread::Builder::new().name("background".into()).spawn_scoped(scope, || {
            set_idle_priority();
            work();
        });
        let thread = started.inspect_err(|error| tracing::error!("no thread can be started: {error}"));
        thread.map_or(Ok(false), |thread| thread.join().map(|()| true))
    })
}

/// Lowers the priority of this thread.
fn lower_priority(nice: i32) {
    // On Linux this affects only this thread. If it is refused, the work keeps its priority.
    if let Err(error) = rustix::process::nice(nice) {
        tracing::debug!("a background thread keeps its priority: {error}");
    }
}

/// Lets this thread run only while a core is otherwise idle. The system treats such a core as idle, so waking threads
/// go there and do not wait for another thread of the server. It cannot be undone.
pub fn set_idle_priority() {
    #[cfg(target_os = "linux")]
    if let Err(error) = set_thread_priority_and_policy(
        thread_native_id(),
        ThreadPriority::Min,
        ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Idle),
    ) {
        tracing::debug!("a background thread keeps its priority: {error}");
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::mpsc::sync_channel;
    use std::time::Duration;

    use tokio::sync::Semaphore;
    use tokio::time::timeout;

    use super::*;

    /// Returns a field of this thread's stat, counted from 1 like in proc(5).
    fn of_this_thread(field: usize) -> i32 {
        let stat = std::fs::read_to_string("/proc/thread-self/stat").expect("Linux");
        let after_name = stat.rsplit(')').next().expect("fields").split_whitespace();
        after_name.clone().nth(field - 3).and_then(|text| text.parse().ok()).expect("a number")
    }

    #[tokio::test]
    async fn background_work_has_the_lowest_priority() {
        // SCHED_OTHER and SCHED_IDLE, see sched(7).
        let (policy, other, idle) = (41, 0, 5);
        assert_eq!(of_this_thread(policy), other);
        assert_eq!(run(move || of_this_thread(policy)).await.expect("done"), idle);
        let mut here = other;
        assert!(run_blocking(&mut || here = of_this_thread(policy)).is_ok_and(|is_done| is_done));
        assert_eq!((here, of_this_thread(policy)), (idle, other));
    }

    #[tokio::test]
    async fn a_permit_is_held_until_the_work_is_done_though_nobody_waits_for_it() {
        let one = Arc::new(Semaphore::new(1));
        let (go_on, wait) = sync_channel::<()>(1);
        let permit = Arc::clone(&one).acquire_owned().await.expect("a permit");
        let waiting = run_with(permit, move || wait.recv());
        assert!(timeout(Duration::from_millis(20), waiting).await.is_err());
        assert!(one.try_acquire().is_err(), "another is let in meanwhile");
        go_on.send(()).expect("the work goes on");
        assert!(one.acquire().await.is_ok());
    }

    #[tokio::test]
    async fn requests_have_a_lower_priority() {
        let nice_of_this = || of_this_thread(19);
        let before = nice_of_this();
        let requests = request_runtime().expect("threads");
        assert_eq!(requests.spawn(async move { nice_of_this() }).await.expect("done"), (before + NICE).min(19));
        requests.shutdown_background();
    }

    #[tokio::test]
    async fn work_that_panics_is_a_fault() {
        let panics: fn() = || panic!("planted");
        assert!(matches!(run(panics).await, Err(ServerError::Internal)));
    }
}
