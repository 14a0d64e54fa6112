//! Compares solvers for the curve parameter by speed, accuracy and failures.
//!
//! Each pixel solves this for each segment of each BendyLight (light model, section 5): the parameters `u` in `[0, 1]`
//! at which `(P(u) - q) . P'(u) = 0` with the distance at a minimum. The product's solver and eight others solve it in
//! f32 and f64 for fifteen [families](FAMILIES) of inputs; the true roots are known to thirty digits.
//!
//! A root is *wrong* if a method misses a true root, if it reports a root that is none, or if its error is over the
//! bounds of section 5: 16 eps cond in u for tubes that are far from folding, a bound on the backward error otherwise.

mod blinn;
mod chart;
mod closed_form;
mod cubic;
mod family;
mod found;
mod histogram;
mod iterative;
mod judge;
mod method;
mod report;
#[cfg(test)]
mod tests;
mod timing;
mod truth;
mod width;

pub use family::{FAMILIES, Family};
pub use histogram::Histogram;
pub use judge::{AnswerTally, WrongCase};
pub use method::{METHODS, Method};
pub use report::{FamilyAccuracy, MeasuredMethod, SolverBenchReport, SolverVerdict, Throughput};
pub use width::Precision;

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::Vec3;
use light::Curve;
use rayon::prelude::*;
use relight::{SolverBatch, solve_batch};
use render::Gpu;

use self::family::SolverCase;
use self::found::FoundRoots;
use self::judge::ErrorBounds;
use self::timing::nanoseconds;
use self::width::FloatWidth;
use crate::{BenchError, Progress};

/// Number of cases that a thread judges per task.
const CHUNK: u64 = 4096;
/// Number of cases over which run times are measured.
const TIMED: u64 = 2048;
/// Number of cases that are solved at once.
const SIXTEEN: usize = 16;
/// Maximum cases of a family that are solved sixteen-wide and on the GPU: they fit into its buffers.
const MAX_BULK_CASES: u64 = 60_000;
/// Number of dispatches over which the GPU's run time is measured.
const DISPATCHES: u32 = 8;

/// Judges and times `methods`, and the product's own, over `inputs_per_family` cases of each family. Returns the report
/// and the chart in SVG.
///
/// Cases are generated on demand and every thread keeps only counts, so their number is not limited by memory. If `gpu`
/// is `None`, the GPU is left out.
pub fn run(
    inputs_per_family: u64,
    methods: &[Method],
    gpu: Option<&Gpu>,
    progress: impl Fn(Progress) + Sync,
) -> Result<(SolverBenchReport, String), BenchError> {
    let mut contestants = vec![Method::Ours];
    contestants.extend(methods.iter().filter(|&&m| m != Method::Ours));
    // All methods in f32, followed by all in f64.
    let mut times = times_in::<f32>(&contestants);
    times.extend(times_in::<f64>(&contestants));
    let of = inputs_per_family as usize * FAMILIES.len();
    let done = AtomicUsize::new(0);
    let judged = |count: u64| {
        let done = done.fetch_add(count as usize, Ordering::Relaxed) + count as usize;
        progress(Progress { done, of, what: String::new() });
    };
    let tallies = FAMILIES.map(|family| judge(family, inputs_per_family, &contestants, &judged));

    let measured = times.iter().enumerate().map(|(row, times)| {
        let precision = if row < contestants.len() { Precision::F32 } else { Precision::F64 };
        MeasuredMethod::new(contestants[row % contestants.len()], precision, times, tallies.each_ref().map(|t| &t[row]))
    });
    let mut methods: Vec<_> = measured.collect();
    MeasuredMethod::find_front(&mut methods);
    let ours = tallies.iter().flat_map(|of_family| [&of_family[0], &of_family[contestants.len()]]);
    let in_bulk = inputs_per_family.min(MAX_BULK_CASES);
    let report = SolverBenchReport {
        inputs_per_family,
        ours: SolverVerdict::of(&AnswerTally::sum(ours)),
        methods,
        sixteen_wide: sixteen_wide(in_bulk),
        adapter: gpu.map(|gpu| on_adapter(gpu, in_bulk)).transpose()?,
    };
    let chart = chart::draw(&report)?;
    Ok((report, chart))
}

/// Returns the nanoseconds per solve in `F` of each method, in each family.
fn times_in<F: FloatWidth>(methods: &[Method]) -> Vec<[f64; FAMILIES.len()]> {
    let cases = FAMILIES.map(|family| (0..TIMED).map(|i| family.case(i).rounded::<F>()).collect::<Vec<_>>());
    let of_method = |method: &Method| {
        let solve = method.solver::<F>();
        cases.each_ref().map(|cases| nanoseconds(cases, |case| solve(&case.curve, case.q)))
    };
    methods.iter().map(of_method).collect()
}

/// Judges each method's answers to a family, in f32 and then in f64.
fn judge(family: Family, inputs: u64, methods: &[Method], judged: &(impl Fn(u64) + Sync)) -> Vec<AnswerTally> {
    let none = || vec![AnswerTally::default(); 2 * methods.len()];
    let chunk = |chunk: u64| {
        let indices = chunk * CHUNK..inputs.min((chunk + 1) * CHUNK);
        let mut tallies = none();
        let (single, double) = tallies.split_at_mut(methods.len());
        for index in indices.clone() {
            let exact = family.case(index);
            judge_in::<f32>(family, index, &exact, methods, single);
            judge_in::<f64>(family, index, &exact, methods, double);
        }
        judged(indices.end - indices.start);
        tallies
    };
    let add = |mut tallies: Vec<AnswerTally>, others: Vec<AnswerTally>| {
        tallies.iter_mut().zip(&others).for_each(|(tally, other)| tally.add(other));
        tallies
    };
    (0..inputs.div_ceil(CHUNK)).into_par_iter().map(chunk).reduce(none, add)
}

fn judge_in<F: FloatWidth>(
    family: Family,
    index: u64,
    exact: &SolverCase<f64>,
    methods: &[Method],
    tallies: &mut [AnswerTally],
) {
    let bars = ErrorBounds::<F>::new(family, exact);
    for (method, tally) in methods.iter().zip(tallies) {
        let found = method.solver::<F>()(&bars.case().curve, bars.case().q);
        tally.count(family, index, &bars, &found);
    }
}

/// Measures the native backend's solver, sixteen cases at once, over the first `inputs` cases of each family of inputs.
fn sixteen_wide(inputs: u64) -> Throughput {
    let all = |family: Family, inputs: u64| {
        (0..inputs).step_by(SIXTEEN).map(move |first| (first, SolverBatch::new(&sixteen(family, first))))
    };
    let mut tally = AnswerTally::default();
    for family in FAMILIES {
        for (first, cases) in all(family, inputs) {
            for (index, roots) in (first..inputs).zip(solve_batch(&cases)) {
                count_roots(&mut tally, family, index, roots.found().collect());
            }
        }
    }
    let time = |family| {
        let cases: Vec<_> = all(family, TIMED).collect();
        nanoseconds(&cases, |(_, cases)| solve_batch(cases)) / SIXTEEN as f64
    };
    Throughput {
        on: format!("one core, {SIXTEEN} at once"),
        solves_per_second: FAMILIES.len() as f64 * 1e9 / FAMILIES.map(time).iter().sum::<f64>(),
        verdict: SolverVerdict::of(&tally),
    }
}

/// Judges the roots of one case in f32, and counts them.
fn count_roots(tally: &mut AnswerTally, family: Family, index: u64, found: FoundRoots<f32>) {
    tally.count(family, index, &ErrorBounds::<f32>::new(family, &family.case(index)), &found);
}

/// Returns sixteen cases of a family, from number `first` on.
fn sixteen(family: Family, first: u64) -> [(Curve<f32>, Vec3); SIXTEEN] {
    std::array::from_fn(|lane| {
        let case: SolverCase<f32> = family.case(first + lane as u64).rounded();
        (case.curve, case.q)
    })
}

/// Measures the solver in WGSL on a GPU, over the first `inputs` cases of each family of inputs.
fn on_adapter(gpu: &Gpu, inputs: u64) -> Result<Throughput, BenchError> {
    let mut tally = AnswerTally::default();
    let mut seconds = 0.0;
    for family in FAMILIES {
        let cases: Vec<SolverCase<f32>> = (0..inputs).map(|index| family.case(index).rounded()).collect();
        let questions: Vec<_> = cases.iter().map(|case| (case.curve, case.q)).collect();
        let (answers, each) = render::increasing_roots(gpu, &questions, DISPATCHES)?;
        seconds += each.as_secs_f64();
        for (index, roots) in (0..inputs).zip(answers) {
            count_roots(&mut tally, family, index, roots.found().collect());
        }
    }
    Ok(Throughput {
        on: gpu.adapter_name().to_owned(),
        solves_per_second: tally.inputs as f64 / seconds,
        verdict: SolverVerdict::of(&tally),
    })
}
