//! Report of `bendylights bench solver`.

use serde::Serialize;

use super::family::{FAMILIES, Family};
use super::judge::{AnswerTally, WrongCase};
use super::method::Method;
use super::width::Precision;

/// Speed, accuracy and failures of solvers for the curve parameter.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SolverBenchReport {
    /// Cases of each family.
    pub inputs_per_family: u64,
    /// Verdict on the product's own solver in both precisions. Nothing may be wrong.
    pub ours: SolverVerdict,
    /// Every method in every precision.
    pub methods: Vec<MeasuredMethod>,
    /// The product's solver in f32, sixteen cases at once: [`relight::solve_batch`].
    pub sixteen_wide: Throughput,
    /// The product's solver in f32 on the GPU; `None` if there is none.
    pub adapter: Option<Throughput>,
}

/// Verdict on a solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SolverVerdict {
    /// Cases solved. A case in f32 and in f64 counts as two.
    pub solves: u64,
    /// Number of roots that were missed, that are no root, or whose error is over the bounds.
    pub wrong: u64,
    /// Number of reported parameters that are NaN.
    pub nan: u64,
    /// First case with a wrong answer.
    pub first_wrong: Option<WrongCase>,
}

/// Run time and error of a method in one precision.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct MeasuredMethod {
    pub method: Method,
    pub precision: Precision,
    /// Nanoseconds per solve on one core, mean over the families.
    pub nanoseconds: f64,
    /// True if no other method of this precision is both faster by the mean time and more accurate by the p99.9 of
    /// `errorEpsCond`.
    pub on_pareto_front: bool,
    /// Errors and failures over all families.
    pub accuracy: AnswerTally,
    /// Run time and errors in each family.
    pub families: Vec<FamilyAccuracy>,
}

/// Run time and error in one family.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct FamilyAccuracy {
    pub family: Family,
    /// Nanoseconds per solve on one core.
    pub nanoseconds: f64,
    pub accuracy: AnswerTally,
}

/// Throughput of many solves at once.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Throughput {
    /// Name of the solver or the GPU.
    pub on: String,
    /// Solves per second, mean over the families.
    pub solves_per_second: f64,
    pub verdict: SolverVerdict,
}

impl SolverVerdict {
    /// Makes the verdict from a tally.
    pub fn of(tally: &AnswerTally) -> Self {
        let AnswerTally { inputs, nan, first_wrong, .. } = *tally;
        Self { solves: inputs, wrong: tally.wrong(), nan, first_wrong }
    }
}

impl MeasuredMethod {
    /// Combines the time and the tally of each family.
    pub fn new(
        method: Method,
        precision: Precision,
        times: &[f64; FAMILIES.len()],
        tallies: [&AnswerTally; FAMILIES.len()],
    ) -> Self {
        let in_family =
            |k: usize| FamilyAccuracy { family: FAMILIES[k], nanoseconds: times[k], accuracy: tallies[k].clone() };
        Self {
            method,
            precision,
            nanoseconds: times.iter().sum::<f64>() / times.len() as f64,
            on_pareto_front: false,
            accuracy: AnswerTally::sum(tallies),
            families: (0..FAMILIES.len()).map(in_family).collect(),
        }
    }

    /// Returns the error that the chart shows: the error in u that one root in a thousand exceeds, for a condition of
    /// 1.
    pub fn error(&self) -> f64 {
        self.accuracy.error_eps_cond.quantile(0.999) * self.precision.eps()
    }

    /// Sets [`Self::on_pareto_front`] of each method.
    pub fn find_front(methods: &mut [Self]) {
        let all: Vec<_> = methods.iter().map(|m| (m.precision, m.nanoseconds, m.error())).collect();
        for one in methods {
            let (precision, time, error) = (one.precision, one.nanoseconds, one.error());
            one.on_pareto_front = !all.iter().any(|&(p, t, e)| p == precision && t < time && e < error);
        }
    }
}
