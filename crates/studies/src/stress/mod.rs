//! Numerical stress: what must hold for every light and scene, tried on random and on unkind ones.
//!
//! Each property is a kind of case, a check, and a bound that follows from conditioning. What fails is made as simple as it can be
//! (by proptest), and named by a seed that makes it again.

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
use thiserror::Error;

use self::adapter::Adapter;
pub use self::runner::PropertyFailure;
use self::runner::{Check, CheckTally, TrySeed, property};
use self::shadow::Fault;
use crate::StudyError;

/// What must hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Property {
    /// No root is wrong, missing or NaN, in f64 and f32, against a search by brute force.
    Solver,
    /// The cross-section's frame is orthonormal and goes on over joints.
    Frame,
    /// From (t, v, w) to a point and back.
    RoundTrip,
    /// (t, v, w), radius and direction agree from both sides of a joint; no point there is lost or counted twice.
    Joints,
    /// A light and its points, moved, turned and scaled together, stay as they were.
    World,
    /// The adapter finds the same (t, v, w), radius and direction as the model in f64.
    Locate,
    /// The adapter draws vertices into shadow maps where the model in f64 puts them.
    Map,
    /// A plane that nothing shadows is lit.
    LonePlane,
    /// Nothing shines through a wall of triangles.
    Wall,
    /// Shadows of triangles of every kind are where a walk along the light's paths says.
    Shadow,
    /// Every AOV of every picture holds numbers, each in its range.
    Finite,
}

impl Property {
    /// All of them, in the order in which they are tried.
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

    /// As it is written in JSON and on the command line.
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

    /// What it does with a seed; `None` where it needs an adapter and there is none.
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
            (Self::Wall, Some(adapter)) => {
                with_adapter(adapter, shadow::walls(), shadow::check(Fault::Holes))
            }
            (Self::Shadow, Some(adapter)) => {
                with_adapter(adapter, shadow::clutter(), shadow::check(Fault::WrongSide))
            }
            (Self::Finite, Some(adapter)) => with_adapter(adapter, finite::cases(), finite::check),
        };
        Some(tries)
    }
}

/// A property of what an adapter does.
fn with_adapter<'a, C: Debug + Serialize>(
    adapter: &'a Adapter,
    cases: impl Strategy<Value = C> + 'a,
    check: impl Fn(&C, &Adapter, &mut CheckTally) -> Check + 'a,
) -> TrySeed<'a> {
    property(cases, move |case, tally| check(case, adapter, tally))
}

/// A name that is no property.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("`{0}` is not a property: choose one of {names}", names = Property::ALL.map(Property::name).join(", "))]
pub struct UnknownProperty(String);

impl FromStr for Property {
    type Err = UnknownProperty;

    fn from_str(name: &str) -> Result<Self, UnknownProperty> {
        Self::ALL
            .into_iter()
            .find(|property| property.name() == name)
            .ok_or_else(|| UnknownProperty(name.into()))
    }
}

/// How much to try.
#[derive(Clone, Copy, Debug)]
pub enum Length {
    /// For as long as this, shared evenly.
    Time(Duration),
    /// So many cases of each property.
    Cases(u64),
}

/// What to try.
#[derive(Clone, Debug)]
pub struct StressOptions {
    /// Which properties.
    pub properties: Vec<Property>,
    /// Case k is the first one of a run with this plus k.
    pub seed: u64,
    /// When to stop.
    pub length: Length,
    /// Spoil what each check looks at, to show that it would see such a fault.
    pub planted: bool,
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct StressReport {
    /// Of the first case of each property.
    pub seed: u64,
    /// One a property.
    pub outcomes: Vec<PropertyOutcome>,
}

/// What was found of one property.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct PropertyOutcome {
    /// What was to hold.
    pub property: Property,
    /// Cases tried; a failure ends it.
    pub cases: u64,
    /// Numbers compared with their bound.
    pub comparisons: u64,
    /// Largest error as a share of its bound; `null` where something failed that has no size.
    pub worst_share: f64,
    /// The case it does not hold for.
    pub failure: Option<PropertyFailure>,
}

impl StressReport {
    /// The properties that do not hold.
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

/// How long one property is tried before the next has its turn.
const TURN_TIME: Duration = Duration::from_millis(200);

impl PropertyRun<'_> {
    /// Tries more cases, up to `most` in all.
    fn try_cases(&mut self, seed: u64, most: u64) {
        let began = Instant::now();
        while self.failure.is_none() && self.cases < most && began.elapsed() < TURN_TIME {
            self.failure = (self.try_seed)(seed.wrapping_add(self.cases), &mut self.tally);
            self.cases += 1;
        }
    }

    fn outcome(self) -> PropertyOutcome {
        let Self { property, tally, cases, failure, .. } = self;
        PropertyOutcome {
            property,
            cases,
            comparisons: tally.comparisons,
            worst_share: tally.worst_share,
            failure,
        }
    }
}

/// Tries the properties in turns; one that fails does not stop the others. `progress` is told the share that is done.
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
