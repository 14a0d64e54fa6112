//! Generates random cases, simplifies failing ones, and counts comparisons.

use std::cell::RefCell;
use std::fmt::{Arguments, Debug};

use proptest::strategy::Strategy;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestError, TestRng, TestRunner};
use serde::Serialize;

/// Maximum number of simplifications of a failing case.
const SHRINK_STEPS: u32 = 2_000;
/// Maximum time for these simplifications in milliseconds. It is needed because each one may draw a picture.
const SHRINK_MS: u32 = 30_000;

/// Counts comparisons of a check. Also tells the check if it must make a deliberate fault.
#[derive(Debug, Default)]
pub struct CheckTally {
    /// True if the check must corrupt its input. It must then fail, which shows that it detects such a fault.
    pub is_planted: bool,
    /// Number of values compared with a bound.
    pub comparisons: u64,
    /// Largest error as a share of its bound.
    pub worst_share: f64,
}

/// Result of a check. The error describes what is wrong, as a clause.
pub type Check = Result<(), String>;

impl CheckTally {
    /// Compares an error with its bound. NaN exceeds every bound.
    pub fn within(&mut self, what: Arguments, error: f64, bound: f64) -> Check {
        self.comparisons += 1;
        let share = if error == 0.0 { 0.0 } else { error / bound };
        self.worst_share = self.worst_share.max(if share.is_nan() { f64::INFINITY } else { share });
        if share <= 1.0 { Ok(()) } else { Err(format!("{what} is off by {error:e}, over its bound of {bound:e}")) }
    }

    /// Counts a condition as a comparison. If it is false, records an infinite error, because there is no number to
    /// compare with a bound, and returns the description from `otherwise` as an error.
    pub fn holds(&mut self, holds: bool, otherwise: impl FnOnce() -> String) -> Check {
        self.comparisons += 1;
        if holds {
            return Ok(());
        }
        self.worst_share = f64::INFINITY;
        Err(otherwise())
    }
}

/// Case for which a property does not hold, simplified as far as possible.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PropertyFailure {
    /// Seed with which a run of this property alone begins with the failing case.
    pub seed: u64,
    /// Description of what is wrong in the simplest case found.
    pub why: String,
    /// The simplest case. Lights are as in a light file, positions are in the world.
    pub case: serde_json::Value,
}

/// Tries the case of a seed. Returns a [`PropertyFailure`] if the property does not hold for it.
pub type TrySeed<'a> = Box<dyn Fn(u64, &mut CheckTally) -> Option<PropertyFailure> + 'a>;

/// Combines a strategy for cases and a check into a function of the seed.
pub fn property<'a, C: Debug + Serialize>(
    cases: impl Strategy<Value = C> + 'a,
    check: impl Fn(&C, &mut CheckTally) -> Check + 'a,
) -> TrySeed<'a> {
    Box::new(move |seed, tally| {
        let config = Config {
            failure_persistence: None,
            max_shrink_iters: SHRINK_STEPS,
            max_shrink_time: SHRINK_MS,
            ..Config::default()
        };
        let mut runner = TestRunner::new_with_rng(config, rng(seed));
        let tree = match cases.new_tree(&mut runner) {
            Ok(tree) => tree,
            Err(reason) => {
                return Some(PropertyFailure { seed, why: reason.to_string(), case: serde_json::Value::Null });
            }
        };
        let tally = RefCell::new(tally);
        let held = runner.run_one(tree, |case| check(&case, &mut tally.borrow_mut()).map_err(TestCaseError::fail));
        let (why, case) = match held {
            Ok(_) => return None,
            Err(TestError::Abort(reason)) => (reason, serde_json::Value::Null),
            Err(TestError::Fail(reason, case)) => {
                (reason, serde_json::to_value(&case).expect("plain data with string keys"))
            }
        };
        Some(PropertyFailure { seed, why: why.message().to_owned(), case })
    })
}

/// Returns a random number generator that depends on the seed alone.
fn rng(seed: u64) -> TestRng {
    let mut bytes = [0; 32];
    bytes[..8].copy_from_slice(&seed.to_le_bytes());
    TestRng::from_seed(RngAlgorithm::ChaCha, &bytes)
}
