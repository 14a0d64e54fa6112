//! Runs the properties of `bendylights-studies stress` for a short time: some fixed cases, some new ones, and planted
//! faults.

use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher, Hasher};

use studies::stress::{Length, Property, PropertyOutcome, StressOptions, run};

/// These need no GPU and are quick.
const OF_THE_MODEL: [Property; 5] =
    [Property::Solver, Property::Frame, Property::RoundTrip, Property::Joints, Property::World];
const OF_THE_ADAPTER: [Property; 2] = [Property::Locate, Property::Map];
const OF_PICTURES: [Property; 4] = [Property::LonePlane, Property::Wall, Property::Shadow, Property::Finite];

fn tried(properties: &[Property], seed: u64, cases: u64, planted: bool) -> Vec<PropertyOutcome> {
    let options = StressOptions { properties: properties.to_vec(), seed, length: Length::Cases(cases), planted };
    run(&options, |_| ()).expect("tests need a graphics driver").outcomes
}

/// Tests that properties hold for `cases` cases from a seed on. Returns the number of comparisons of each.
fn assert_properties_hold(properties: &[Property], seed: u64, cases: u64) -> Vec<(&'static str, u64)> {
    let comparisons = |outcome: PropertyOutcome| {
        let name = outcome.property.name();
        assert!(outcome.failure.is_none(), "{name}: {:#?}", outcome.failure);
        assert_eq!(outcome.cases, cases);
        (name, outcome.comparisons)
    };
    tried(properties, seed, cases, false).into_iter().map(comparisons).collect()
}

/// Tests properties in fixed cases, which must make comparisons, and in a few new ones. The new ones need not make any:
/// all points of three random lights may be outside of them.
fn hold_anywhere(properties: &[Property], cases: u64) {
    for (name, comparisons) in assert_properties_hold(properties, 1, cases) {
        assert!(comparisons >= cases, "{name}: {comparisons} comparisons");
    }
    assert_properties_hold(properties, random_seed(), cases / 2);
}

/// Tests that each property fails within some cases with a planted fault, and that its simplest case is small.
fn assert_planted_faults_fail(properties: &[Property], cases: u64) {
    for outcome in tried(properties, 1, cases, true) {
        let failure = outcome.failure.unwrap_or_else(|| panic!("{}: went unseen", outcome.property.name()));
        println!("{}: {}\n{}", outcome.property.name(), failure.why, failure.case);
        let light = failure.case.get("light").expect("the case holds a light");
        let points = light["points"].as_array().expect("control points").len();
        assert!(points <= 4, "{points} control points: {}", failure.case);
    }
}

/// A seed that differs from run to run, printed so that a failure can be reproduced.
fn random_seed() -> u64 {
    let seed = RandomState::new().build_hasher().finish() % 1_000_000_000;
    println!("seed {seed}");
    seed
}

#[test]
fn the_model_holds() {
    hold_anywhere(&OF_THE_MODEL, 200);
}

#[test]
fn the_adapter_agrees_with_the_model() {
    hold_anywhere(&OF_THE_ADAPTER, 6);
}

#[test]
fn pictures_hold() {
    hold_anywhere(&OF_PICTURES, 8);
}

#[test]
fn planted_faults_are_caught_and_made_simple() {
    assert_planted_faults_fail(&OF_THE_MODEL, 5);
    assert_planted_faults_fail(&OF_THE_ADAPTER, 3);
    assert_planted_faults_fail(&OF_PICTURES, 12);
}

/// The seed that a failure prints reproduces its case alone.
#[test]
fn a_seed_makes_its_case_again() {
    let first = &tried(&[Property::Joints], 1, 20, true)[0];
    let failure = first.failure.as_ref().expect("the planted fault is seen");
    let again = &tried(&[Property::Joints], failure.seed, 1, true)[0];
    assert_eq!(again.failure.as_ref(), Some(failure));
}
