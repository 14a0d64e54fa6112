//! Numerical stress: properties that must hold for every light and scene, tested with random and extreme ones.
//!
//! Each property has a strategy for cases, a check, and a bound that follows from conditioning. proptest simplifies a
//! failing case as far as possible, and a seed reproduces it.

mod adapter;
mod finite;
mod frame;
mod joints;
mod light;
mod place;
mod round_trip;
mod runner;
mod scenes;
mod shadow;
mod solver;
mod walk;
mod world;

use std::fmt::Debug;
use std::str::FromStr;
use std::time::{Duration, Instant};

use proptest::strategy::Strategy;
use serde::Serialize;

use self::adapter::Adapter;
pub use self::runner::PropertyFailure;
use self::runner::{Check, CheckTally, TrySeed, property};
use self::shadow::Fault;
use crate::StudyError;

/// Property that must hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Property {
    /// No root is wrong, missing or NaN, in f64 and f32, in comparison with a brute-force search.
    Solver,
    /// The frame of the cross-section is orthonormal and continuous at joints.
    Frame,
    /// Conversion from (t, v, w) to a point and back.
    RoundTrip,
    /// (t, v, w), radius and direction agree from both sides of a joint; no point there is lost or counted twice.
    Joints,
    /// A light and its points keep their coordinates if they are moved, rotated and scaled together.
    World,
    /// The GPU finds the same (t, v, w), radius and direction as the model in f64.
    Locate,
    /// The GPU puts vertices into shadow maps where the model in f64 does.
    Map,
    /// A plane without casters is lit.
    LonePlane,
    /// No light passes through a wall of triangles.
    Wall,
    /// Shadows of triangles of every kind agree with the tracing of light paths as polylines.
    Shadow,
    /// Every AOV of every picture has finite numbers, each in its range.
    Finite,
}

impl Property {
    /// All properties, in the order in which they are tried.
    pub const ALL: [Self; 11] = [
        Self::Solver,
        Self::Frame,
        Self::RoundTrip,
        Self::Joints,
        Self::World,
        Self::Locate,
        Self::Map,
        Self::LonePlane,
        Self::Wall,
        Self::Shadow,
        Self::Finite,
    ];

    /// Returns the name in JSON and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Solver => "solver",
            Self::Frame => "frame",
            Self::RoundTrip => "round-trip",
            Self::Joints => "joints",
            Self::World => "world",
            Self::Locate => "locate",
            Self::Map => "map",
            Self::LonePlane => "lone-plane",
            Self::Wall => "wall",
            Self::Shadow => "shadow",
            Self::Finite => "finite",
        }
    }

    /// Returns the function that tries the case of a seed; `None` if it needs a GPU and there is none.
    fn tries(self, adapter: Option<&Adapter>) -> Option<TrySeed<'_>> {
        let tries = match (self, adapter) {
            (Self::Solver, _) => property(solver::cases(), solver::check),
            (Self::Frame, _) => property(frame::cases(), frame::check),
            (Self::RoundTrip, _) => property(round_trip::cases(), round_trip::check),
            (Self::Joints, _) => property(joints::cases(), joints::check),
            (Self::World, _) => property(world::cases(), world::check),
            (_, None) => return None,
            (Self::Locate, Some(adapter)) => with_adapter(adapter, adapter::cases(), adapter::check_locate),
            (Self::Map, Some(adapter)) => with_adapter(adapter, adapter::cases(), adapter::check_shadow_map),
            (Self::LonePlane, Some(adapter)) => {
                with_adapter(adapter, shadow::lone_planes(), shadow::check(Fault::Ghost))
            }
            (Self::Wall, Some(adapter)) => with_adapter(adapter, shadow::walls(), shadow::check(Fault::Holes)),
            (Self::Shadow, Some(adapter)) => with_adapter(adapter, shadow::clutter(), shadow::check(Fault::WrongSide)),
            (Self::Finite, Some(adapter)) => with_adapter(adapter, finite::cases(), finite::check),
        };
        Some(tries)
    }
}

/// Makes the function that tries a property of the GPU.
fn with_adapter<'a, C: Debug + Serialize>(
    adapter: &'a Adapter,
    cases: impl Strategy<Value = C> + 'a,
    check: impl Fn(&C, &Adapter, &mut CheckTally) -> Check + 'a,
) -> TrySeed<'a> {
    property(cases, move |case, tally| check(case, adapter, tally))
}

impl FromStr for Property {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let names = || Self::ALL.map(Self::name).join(", ");
        let named = Self::ALL.into_iter().find(|property| property.name() == name);
        named.ok_or_else(|| format!("`{name}` is not a property: choose one of {}", names()))
    }
}

/// Amount of testing.
#[derive(Clone, Copy, Debug)]
pub enum Length {
    /// Total time, shared evenly by the properties.
    Time(Duration),
    /// Number of cases of each property.
    Cases(u64),
}

/// Options of a run.
#[derive(Clone, Debug)]
pub struct StressOptions {
    pub properties: Vec<Property>,
    /// Seed of the run. Case k is the first case of a run with the seed plus k.
    pub seed: u64,
    pub length: Length,
    /// True if each check must corrupt its input. Each property must then fail, which shows that it detects such a
    /// fault.
    pub planted: bool,
}

/// Results of a run.
#[derive(Clone, Debug, Serialize)]
pub struct StressReport {
    /// Seed of the first case of each property.
    pub seed: u64,
    /// One per property.
    pub outcomes: Vec<PropertyOutcome>,
}

/// Result for one property.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct PropertyOutcome {
    pub property: Property,
    /// Number of cases tried; the first failure ends the property.
    pub cases: u64,
    /// Number of values compared with their bounds.
    pub comparisons: u64,
    /// Largest error as a share of its bound; `null` after the failure of a condition without a number.
    pub worst_share: f64,
    /// Case for which the property does not hold.
    pub failure: Option<PropertyFailure>,
}

impl StressReport {
    /// Returns the properties that do not hold, with their failures.
    pub fn failed(&self) -> impl Iterator<Item = (Property, &PropertyFailure)> {
        self.outcomes.iter().filter_map(|outcome| Some((outcome.property, outcome.failure.as_ref()?)))
    }
}

/// A property under test.
struct PropertyRun<'a> {
    property: Property,
    try_seed: TrySeed<'a>,
    tally: CheckTally,
    cases: u64,
    failure: Option<PropertyFailure>,
}

/// Time for which the cases of a property are tried before those of the next property.
const TURN_TIME: Duration = Duration::from_millis(200);

impl PropertyRun<'_> {
    /// Tries more cases, up to `most` in total.
    fn try_cases(&mut self, seed: u64, most: u64) {
        let began = Instant::now();
        while self.failure.is_none() && self.cases < most && began.elapsed() < TURN_TIME {
            self.failure = (self.try_seed)(seed.wrapping_add(self.cases), &mut self.tally);
            self.cases += 1;
        }
    }

    fn outcome(self) -> PropertyOutcome {
        let Self { property, tally, cases, failure, .. } = self;
        PropertyOutcome { property, cases, comparisons: tally.comparisons, worst_share: tally.worst_share, failure }
    }
}

/// Tries the properties in rotation. A property that fails does not stop the others. `progress` gets the finished
/// share.
pub fn run(options: &StressOptions, progress: impl Fn(f64)) -> Result<StressReport, StudyError> {
    let needs_adapter = options.properties.iter().any(|property| property.tries(None).is_none());
    let adapter = needs_adapter.then(Adapter::open).transpose()?;
    let course = |&property: &Property| PropertyRun {
        property,
        try_seed: property.tries(adapter.as_ref()).expect("an adapter is open where one is needed"),
        tally: CheckTally { is_planted: options.planted, ..CheckTally::default() },
        cases: 0,
        failure: None,
    };
    let mut courses: Vec<PropertyRun> = options.properties.iter().map(course).collect();
    let began = Instant::now();
    let most = match options.length {
        Length::Time(_) => u64::MAX,
        Length::Cases(cases) => cases,
    };
    let done = |courses: &[PropertyRun]| match options.length {
        Length::Time(time) => began.elapsed().as_secs_f64() / time.as_secs_f64(),
        Length::Cases(cases) => {
            let tried: u64 = courses.iter().map(|c| if c.failure.is_some() { cases } else { c.cases }).sum();
            tried as f64 / (cases * courses.len() as u64) as f64
        }
    };
    while done(&courses) < 1.0 && courses.iter().any(|course| course.failure.is_none()) {
        for course in &mut courses {
            course.try_cases(options.seed, most);
        }
        progress(done(&courses));
    }
    Ok(StressReport { seed: options.seed, outcomes: courses.into_iter().map(PropertyRun::outcome).collect() })
}
