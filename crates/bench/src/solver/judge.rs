//! Judges a solver's answers: the error of each root, and missed or spurious roots.

use twofloat::TwoFloat;

use super::family::{Family, SolverCase, kappa_max, slowest};
use super::found::FoundRoots;
use super::histogram::Histogram;
use super::truth::{ExactCubic, TrueRoot};
use super::width::{FloatWidth, Precision};

/// Distance in u above which a reported parameter counts as a different root than the true one.
const SAME_ROOT_DISTANCE: f64 = 1.0 / 64.0;

/// Counts and errors of the answers to some cases.
#[derive(Clone, Debug, Default, serde::Serialize)]
#[serde(rename_all = "camelCase")]
pub struct AnswerTally {
    /// Number of cases.
    pub inputs: u64,
    /// Errors in u of the true roots on the segment that were found.
    pub error_u: Histogram,
    /// Errors of the found roots in units of `eps cond`, for the cases in which the light model bounds the error of u:
    /// see `ErrorBounds::is_well_conditioned`.
    pub error_eps_cond: Histogram,
    /// Number of true roots on the segment that were not found.
    pub missed: u64,
    /// Number of reported parameters that are no root.
    pub spurious: u64,
    /// Number of roots that were found with an error over the bounds of the light model, section 5.
    pub inaccurate: u64,
    /// Number of reported parameters that are NaN.
    pub nan: u64,
    /// First case with a wrong answer, for debugging.
    pub first_wrong: Option<WrongCase>,
}

/// A case with a wrong answer. Its numbers reproduce the case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "camelCase")]
pub struct WrongCase {
    pub family: Family,
    /// Number of the case in its family.
    pub index: u64,
    /// Precision in which the case was solved.
    pub precision: Precision,
}

impl AnswerTally {
    /// Returns the number of wrong roots of all three kinds: missed, spurious and inaccurate.
    pub fn wrong(&self) -> u64 {
        self.missed + self.spurious + self.inaccurate
    }

    /// Returns the sum of several tallies.
    pub fn sum<'a>(tallies: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut sum = Self::default();
        tallies.into_iter().for_each(|tally| sum.add(tally));
        sum
    }

    /// Adds another tally.
    pub fn add(&mut self, other: &Self) {
        self.inputs += other.inputs;
        self.error_u.add(&other.error_u);
        self.error_eps_cond.add(&other.error_eps_cond);
        self.missed += other.missed;
        self.spurious += other.spurious;
        self.inaccurate += other.inaccurate;
        self.nan += other.nan;
        self.first_wrong = self.first_wrong.or(other.first_wrong);
    }

    /// Judges the answer to one case and counts it.
    pub fn count<F: FloatWidth>(&mut self, family: Family, index: u64, bars: &ErrorBounds<F>, found: &FoundRoots<F>) {
        let before = self.wrong() + self.nan;
        self.inputs += 1;
        let reported = found.roots();
        self.nan += reported.iter().filter(|u| u.is_nan()).count() as u64;
        let numbers = || reported.iter().filter(|u| !u.is_nan()).map(|u| u.f64());
        self.spurious += numbers().filter(|&u| !bars.is_root(u)).count() as u64;
        for root in bars.truth.roots.iter().flatten() {
            let nearest = numbers().min_by(|x, y| root.error(*x).total_cmp(&root.error(*y)));
            match nearest.filter(|&u| bars.is_answer(root, u)) {
                Some(u) => self.measure(bars, root, u),
                None => self.missed += u64::from(root.is_wanted() && !bars.may_miss(root)),
            }
        }
        if self.wrong() + self.nan > before && self.first_wrong.is_none() {
            self.first_wrong = Some(WrongCase { family, index, precision: F::PRECISION });
        }
    }

    fn measure<F: FloatWidth>(&mut self, bars: &ErrorBounds<F>, root: &TrueRoot, u: f64) {
        let (error, eps_cond) = (root.error(u), F::PRECISION.eps() * bars.cond(root.u.hi()));
        self.error_u.record(error);
        if bars.is_well_conditioned {
            self.error_eps_cond.record(error / eps_cond);
        }
        let held = bars.is_well_conditioned && error <= 16.0 * eps_cond;
        self.inaccurate += u64::from(!held && !bars.is_within_backward(u));
    }
}

/// True roots of a case, and bounds on the error of an answer in `F` (light model, section 5).
pub struct ErrorBounds<F: FloatWidth> {
    truth: ExactCubic,
    case: SolverCase<F>,
    /// The bound `K` on the backward error.
    backward: f64,
    /// `|d0| + |d1|`.
    length: f64,
    /// True if the bound on u applies: the tube whose radius is the distance from the point to the curve has
    /// `R kappa <= 0.9`, and `|P'| >= 0.1 L`. Otherwise only the backward error is bounded.
    is_well_conditioned: bool,
}

impl<F: FloatWidth> ErrorBounds<F> {
    /// Computes the bounds for a case rounded to `F`.
    pub fn new(family: Family, exact: &SolverCase<f64>) -> Self {
        let case = exact.rounded::<F>();
        let truth = ExactCubic::of(&case.curve, case.q);
        let s = &exact.curve;
        let length = s.d0.length() + s.d1.length();
        let widest = truth.roots.iter().flatten().map(|root| (exact.q - s.position(root.u.hi())).length());
        let radius = widest.fold(0.0, f64::max);
        let is_well_conditioned = radius * kappa_max(s) <= 0.9 && 2.0 * slowest(s) >= 0.1 * length;
        Self {
            truth,
            case,
            backward: F::BACKWARD_ERROR_BOUNDS[usize::from(family.has_vanishing_derivative())],
            length,
            is_well_conditioned,
        }
    }

    /// Returns the case, rounded to `F`.
    pub fn case(&self) -> &SolverCase<F> {
        &self.case
    }

    /// Returns `(|r| + L) / (|P'| (1 - kappa r.N))` at `u`, with `|P'| (1 - kappa r.N) = 2 f' / |P'|`, times `1 +
    /// |world offset| / size` for a segment away from the origin.
    fn cond(&self, u: f64) -> f64 {
        let (r, d) = self.at(u);
        let offset = 1.0 + F::vec_f64(self.case.curve.b0).length() / self.length;
        offset * (r + self.length) * d / self.truth.slope(u).abs()
    }

    /// Returns `|r|` and `|d|` at `u`.
    fn at(&self, u: f64) -> (f64, f64) {
        let s = &self.case.curve;
        let [b0, d0, a, q] = [s.b0, s.d0, s.a, self.case.q].map(F::vec_f64);
        (((q - b0) - (d0 * 2.0 + a * u) * u).length(), (d0 + a * u).length())
    }

    /// Returns `K eps ((|r| + |q| + L) |d| + |r| L)`.
    fn backward_bar(&self, u: f64) -> f64 {
        let (r, d) = self.at(u);
        let q = F::vec_f64(self.case.q).length();
        self.backward * F::PRECISION.eps() * ((r + q + self.length) * d + r * self.length)
    }

    /// True if `u` is an acceptable answer for the true root `root`.
    fn is_answer(&self, root: &TrueRoot, u: f64) -> bool {
        let [low, high] = root.piece;
        root.error(u) <= SAME_ROOT_DISTANCE
            || (root.is_wanted() && (low..=high).contains(&u) && self.is_within_backward(u))
    }

    fn is_within_backward(&self, u: f64) -> bool {
        self.truth.value(TwoFloat::from(u)).abs() <= self.backward_bar(u)
    }

    /// True if `f` is within the bound of zero at its extremum `u` on the segment: there two roots merge or separate by
    /// rounding.
    fn is_double(&self, u: f64) -> bool {
        let rounding = 16.0 * F::PRECISION.eps();
        (-rounding..=1.0 + rounding).contains(&u)
            && self.truth.value(TwoFloat::from(u)).abs() <= 2.0 * self.backward_bar(u)
    }

    /// True if a true root of the segment lies at `u`, up to rounding.
    fn is_root(&self, u: f64) -> bool {
        let near = self.truth.roots.iter().flatten().any(|root| root.error(u) <= SAME_ROOT_DISTANCE);
        let rising = || self.truth.slope(u) >= 0.0 || self.truth.extrema.iter().any(|&turn| self.is_double(turn));
        near || (self.is_within_backward(u) && rising())
    }

    /// True if rounding can make a true root disappear, because it lies at an end of the segment or almost coincides
    /// with another root.
    fn may_miss(&self, root: &TrueRoot) -> bool {
        root.piece.iter().any(|&end| self.is_double(end))
    }
}
