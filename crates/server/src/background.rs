//! Work of the processor that is not for the next picture: decoding scenes, getting them ready for rays, probes. It runs on threads
//! that give way to those that draw, so that a file which takes a second to decode costs nobody a second of theirs.

use std::thread;

use tokio::sync::oneshot;

use crate::ServerError;

/// By so much less are such threads important to the system than others: one of them has a seventieth of a core that somebody draws
/// with, and all of one that nobody does.
const NICE: i32 = 19;

/// Does `work` on a thread of its own. How many there are is bounded by whoever asks.
pub async fn run<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Result<T, ServerError> {
    let (done, result) = oneshot::channel();
    let named = thread::Builder::new().name("background".into());
    let started = named.spawn(move || {
        give_way();
        // Whoever asked may have gone.
        drop(done.send(work()));
    });
    if let Err(error) = started {
        tracing::error!("no thread can be started: {error}");
        return Err(ServerError::Fault);
    }
    result.await.map_err(|_| ServerError::Fault)
}

/// Does `work` on such a thread and waits for it. What it panicked with where it did; false where no thread could be started.
pub fn run_here(work: &mut (dyn FnMut() + Send)) -> thread::Result<bool> {
    thread::scope(|scope| {
        let started = thread::Builder::new().name("background".into()).spawn_scoped(scope, || {
            give_way();
            work();
        });
        let thread = started.inspect_err(|error| tracing::error!("no thread can be started: {error}"));
        thread.map_or(Ok(false), |thread| thread.join().map(|()| true))
    })
}

/// Makes this thread as important as background work is.
fn give_way() {
    // On Linux that is of this thread alone. Where it is refused the work is as important as any.
    if let Err(error) = rustix::process::nice(NICE) {
        tracing::debug!("a background thread keeps its priority: {error}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn its_threads_give_way_and_others_do_not() {
        let nice_of_this = || {
            let stat = std::fs::read_to_string("/proc/thread-self/stat").expect("Linux");
            let after_name = stat.rsplit(')').next().expect("fields").split_whitespace();
            after_name.clone().nth(16).and_then(|text| text.parse::<i32>().ok()).expect("a number")
        };
        let before = nice_of_this();
        assert_eq!(run(nice_of_this).await.expect("done"), (before + NICE).min(19));
        assert_eq!(nice_of_this(), before);
    }

    #[tokio::test]
    async fn work_that_panics_is_a_fault() {
        let panics: fn() = || panic!("planted");
        assert!(matches!(run(panics).await, Err(ServerError::Fault)));
    }
}
