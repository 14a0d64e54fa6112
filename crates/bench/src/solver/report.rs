//! What `bendylights bench solver` answers.

use serde::Serialize;

use super::family::{FAMILIES, Family};
use super::judge::{AnswerTally, WrongCase};
use super::method::Method;
use super::width::Precision;
use crate::Quantiles;

/// The whole answer.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SolverBenchReport {
    /// Cases of each family.
    pub inputs_per_family: u64,
    /// The product's solver in both widths: nothing may be wrong.
    pub ours: SolverVerdict,
    /// Every method in every width.
    pub methods: Vec<MeasuredMethod>,
    /// The product's solver in f32, sixteen at once: [`relight::solve_batch`].
    pub sixteen_wide: Throughput,
    /// The product's solver in f32 on the adapter; nothing where there is none.
    pub adapter: Option<Throughput>,
}

/// Whether a solver holds what is asked of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SolverVerdict {
    /// Cases solved, one in f32 and one in f64 counting as two.
    pub solves: u64,
    /// Roots missed, reported where there is none, or over the bars.
    pub wrong: u64,
    /// Roots that are no number.
    pub nan: u64,
    /// The first case with anything wrong.
    pub first_wrong: Option<WrongCase>,
}

/// Run time and error of a method in one width.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct MeasuredMethod {
    /// The method.
    pub method: Method,
    /// The width.
    pub precision: Precision,
    /// Nanoseconds a solve on one core, the mean over the families.
    pub nanoseconds: f64,
    /// Whether no other method of this width is both faster and more accurate: by the mean time, and by the p99.9 of
    /// `errorEpsCond`.
    pub on_pareto_front: bool,
    /// Over all families.
    pub accuracy: Accuracy,
    /// Family by family.
    pub families: Vec<FamilyAccuracy>,
}

/// The same of one family.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct FamilyAccuracy {
    /// The family.
    pub family: Family,
    /// Nanoseconds a solve on one core.
    pub nanoseconds: f64,
    /// How good the answers are.
    pub accuracy: Accuracy,
}

/// How good answers are.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Accuracy {
    /// Cases.
    pub inputs: u64,
    /// Errors in u of all roots that were found.
    pub error_u: Quantiles,
    /// Errors in units of `eps cond`, of the inputs that the light model bounds in u (section 5): 16 at most.
    pub error_eps_cond: Quantiles,
    /// Wanted roots that were not found.
    pub missed: u64,
    /// Reported roots that are none.
    pub spurious: u64,
    /// Roots over the bars.
    pub inaccurate: u64,
    /// Reported roots that are no number.
    pub nan: u64,
    /// The first case with anything wrong.
    pub first_wrong: Option<WrongCase>,
}

/// Many solves at once.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Throughput {
    /// What solves.
    pub on: String,
    /// Solves a second, the mean over the families.
    pub solves_per_second: f64,
    /// What they are worth.
    pub verdict: SolverVerdict,
}

impl SolverVerdict {
    /// Of what was counted.
    pub fn of(tally: &AnswerTally) -> Self {
        let AnswerTally { inputs, nan, first_wrong, .. } = *tally;
        Self { solves: inputs, wrong: tally.wrong(), nan, first_wrong }
    }
}

impl Accuracy {
    /// Of what was counted.
    pub fn of(tally: &AnswerTally) -> Self {
        let AnswerTally { inputs, missed, spurious, inaccurate, nan, first_wrong, .. } = *tally;
        Self {
            inputs,
            error_u: tally.error.quantiles(),
            error_eps_cond: tally.error_eps_cond.quantiles(),
            missed,
            spurious,
            inaccurate,
            nan,
            first_wrong,
        }
    }
}

impl MeasuredMethod {
    /// From the time and the count of each family.
    pub fn new(
        method: Method,
        precision: Precision,
        times: &[f64; FAMILIES.len()],
        tallies: [&AnswerTally; FAMILIES.len()],
    ) -> Self {
        let in_family = |k: usize| FamilyAccuracy {
            family: FAMILIES[k],
            nanoseconds: times[k],
            accuracy: Accuracy::of(tallies[k]),
        };
        Self {
            method,
            precision,
            nanoseconds: times.iter().sum::<f64>() / times.len() as f64,
            on_pareto_front: false,
            accuracy: Accuracy::of(&AnswerTally::sum(tallies)),
            families: (0..FAMILIES.len()).map(in_family).collect(),
        }
    }

    /// What the chart compares: the error in u that one in a thousand exceeds, for a condition of 1.
    pub fn error(&self) -> f64 {
        self.accuracy.error_eps_cond.p999 * self.precision.eps()
    }

    /// Sets [`Self::on_pareto_front`] of each.
    pub fn find_front(methods: &mut [Self]) {
        let all: Vec<_> = methods.iter().map(|m| (m.precision, m.nanoseconds, m.error())).collect();
        for one in methods {
            let (precision, time, error) = (one.precision, one.nanoseconds, one.error());
            one.on_pareto_front = !all.iter().any(|&(p, t, e)| p == precision && t < time && e < error);
        }
    }
}
