//! Generates cases, shrinks what fails, and counts.

use std::cell::RefCell;
use std::fmt::{Arguments, Debug};

use proptest::strategy::Strategy;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestError, TestRng, TestRunner};
use serde::Serialize;

/// Simplifications tried on a case that fails.
const SHRINK_STEPS: u32 = 2_000;
/// How long that may take: a picture a step is slow.
const SHRINK_MS: u32 = 30_000;

/// What has been compared so far, and whether what is compared carries a planted fault.
#[derive(Debug, Default)]
pub struct CheckTally {
    /// Whether the check is to spoil what it looks at, to show that it would see such a fault.
    pub is_planted: bool,
    /// Numbers compared with a bound.
    pub comparisons: u64,
    /// Largest error as a share of its bound.
    pub worst_share: f64,
}

/// Why a property does not hold, as a clause.
pub type Check = Result<(), String>;

impl CheckTally {
    /// Compares an error with its bound. NaN is past every bound.
    pub fn within(&mut self, what: Arguments, error: f64, bound: f64) -> Check {
        self.comparisons += 1;
        let share = if error == 0.0 { 0.0 } else { error / bound };
        self.worst_share = self.worst_share.max(if share.is_nan() { f64::INFINITY } else { share });
        if share <= 1.0 {
            Ok(())
        } else {
            Err(format!("{what} is off by {error:e}, over its bound of {bound:e}"))
        }
    }

    /// Notes that something either holds or does not.
    pub fn holds(&mut self, holds: bool, otherwise: impl FnOnce() -> String) -> Check {
        self.comparisons += 1;
        if holds {
            return Ok(());
        }
        self.worst_share = f64::INFINITY;
        Err(otherwise())
    }
}

/// A case that a property does not hold for, as simple as it could be made.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PropertyFailure {
    /// The first case of a run with this seed, and this property alone, is the one that failed.
    pub seed: u64,
    /// What is wrong in the simplest case found.
    pub why: String,
    /// That case. Lights are as in a light file, positions in the world.
    pub case: serde_json::Value,
}

/// Tries the case that a seed stands for: a [`Failure`] where the property does not hold for it.
pub type TrySeed<'a> = Box<dyn Fn(u64, &mut CheckTally) -> Option<PropertyFailure> + 'a>;

/// Cases of one kind and what must hold for each.
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
                return Some(PropertyFailure {
                    seed,
                    why: reason.to_string(),
                    case: serde_json::Value::Null,
                });
            }
        };
        let tally = RefCell::new(tally);
        let held =
            runner.run_one(tree, |case| check(&case, &mut tally.borrow_mut()).map_err(TestCaseError::fail));
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

/// Random bits that are a function of the seed alone.
fn rng(seed: u64) -> TestRng {
    let mut bytes = [0; 32];
    bytes[..8].copy_from_slice(&seed.to_le_bytes());
    TestRng::from_seed(RngAlgorithm::ChaCha, &bytes)
}
