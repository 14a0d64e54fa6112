//! Measures a small piece of work on one core.

use std::hint::black_box;
use std::time::Instant;

/// Number of passes over the cases. The fastest counts, since other work of the machine only adds time.
const PASSES: usize = 15;

/// Returns the nanoseconds per case of the fastest pass of `work` over all `cases`.
pub fn nanoseconds<C, R>(cases: &[C], work: impl Fn(&C) -> R) -> f64 {
    let pass = |_| {
        let start = Instant::now();
        for case in cases {
            black_box(work(black_box(case)));
        }
        start.elapsed().as_secs_f64() * 1e9 / cases.len() as f64
    };
    (0..PASSES).map(pass).fold(f64::INFINITY, f64::min)
}
