//! Hash of the document and the table of parameters: every row counts, and defaults do not.

use std::collections::BTreeMap;

use document::{Document, NumberedLight, PointNumbering};
use glam::{DQuat, DVec3};
use light::parameters::{NAME, POSITION};
use light::{
    CheckedLight, ControlPoint, Light, Links, Parameter, ParameterKind, ParameterOf, ParameterOwner, PeriodicCurve,
    Setting, Value, ValueType, parameters, parameters_of,
};
use sha2::{Digest, Sha256};

use crate::hash::{HASHES, all_differ};
use crate::support::{BENDY, checked};

/// Returns a light of each shape with all defaults.
fn plain_lights() -> [Light; 4] {
    let points = vec![DVec3::ZERO, DVec3::new(0.0, 0.0, -1.0), DVec3::new(0.25, 0.0, -2.0)];
    [Light::spot(), Light::bendy(points, vec![0.125, 0.25, 0.375]), Light::directional(), Light::omni()]
}

fn document_with(light: Light) -> Document {
    let placed = NumberedLight { layout: PointNumbering(1), light: checked(light) };
    Document::restore(None, BTreeMap::from([(BENDY, placed)]), BTreeMap::new(), BTreeMap::new(), 0)
}

/// Returns a value that `parameter` may have, different from `now` and close to it.
fn other_value(parameter: &Parameter, now: &Value) -> Value {
    let candidates: Vec<Value> = match now {
        Value::Number(number) => [number * 0.5, number + 0.5, number + 1.0, number - 1.0].map(Value::Number).into(),
        Value::Absent => {
            let links = Links::new(Vec::new(), vec!["table".into()]).map(Value::Links);
            let curve = PeriodicCurve::new(vec![[30.0, 0.5]]).map(Value::PeriodicCurve);
            [0.5, 1.0, -1.0].map(Value::Number).into_iter().chain(links).chain(curve).collect()
        }
        Value::Flag(flag) => vec![Value::Flag(!flag)],
        Value::Choice(_) => match parameter.kind {
            ParameterKind::Choice(choices) => choices.iter().map(|choice| Value::Choice(choice.name)).collect(),
            other => panic!("a choice of {other}"),
        },
        Value::Vector(vector) => vec![Value::Vector(*vector + DVec3::new(0.125, 0.0625, 0.03125))],
        Value::Rotation(rotation) => vec![Value::Rotation(*rotation * DQuat::from_rotation_y(0.5))],
        Value::Text(text) => vec![Value::Text(format!("{text}e"))],
        Value::PeriodicCurve(curve) => {
            let turned = curve.knots().iter().map(|[degrees, value]| [degrees + 0.5, *value]);
            vec![PeriodicCurve::new(turned.collect()).into_value()]
        }
        Value::Links(links) => vec![Links::new(links.exclude().into(), links.include().into()).into_value()],
    };
    let mut others = candidates.into_iter().filter(|value| value != now && parameter.check(value).is_ok());
    others.next().expect("it may have another value")
}

/// Copies of `light`, each with one of `rows` at another value: of the light, and of each control point that may move.
fn each_set(light: &Light, rows: &[&'static Parameter]) -> Vec<(String, Light)> {
    let mut set = Vec::new();
    for parameter in rows {
        if let (Some(_), Some(now)) = (parameter.for_owner(light.owner()), light.value(parameter)) {
            let mut other = light.clone();
            other.set(Setting { parameter, value: other_value(parameter, now) });
            set.push((format!("the light's {}", parameter.name), other));
        }
        let first = usize::from(**parameter == *POSITION);
        for (index, point) in light.points().iter().enumerate().skip(first) {
            let Some(now) = parameter.for_owner(ParameterOwner::Point).and_then(|_| point.value(parameter)) else {
                continue;
            };
            let setting = Setting { parameter, value: other_value(parameter, &now) };
            let change = |i: usize, point: &mut ControlPoint| {
                if i == index {
                    point.set(&setting);
                }
            };
            set.push((format!("point {index}'s {}", parameter.name), light.clone().map_points(change)));
        }
    }
    set
}

/// A new parameter counts without a change here, in the hash of old logs too, so that it cannot hide in them.
///
/// Rules: DOC-4
#[test]
fn every_row_of_the_table_counts() {
    let rows = parameters();
    for hash in HASHES {
        let mut are_set = 0;
        for light in plain_lights() {
            let set = each_set(&light, rows);
            are_set += set.len();
            let documents: Vec<_> = set.into_iter().map(|(what, light)| (what, document_with(light))).collect();
            all_differ(hash, &document_with(light), &documents);
        }
        // Each row of a light once for each shape, each row of a control point for all three points. The source stays.
        let of_a_point = |of: &ParameterOf| if of.owner == ParameterOwner::Point { 3 } else { 1 };
        let expected: usize = rows.iter().flat_map(|row| row.owners).map(of_a_point).sum();
        assert_eq!(are_set, expected - 1);
    }
}

/// Rules: DOC-4
#[test]
fn a_default_leaves_no_trace() {
    for light in plain_lights() {
        let plain = document_with(light.clone()).hash();
        for parameter in parameters_of(light.owner()) {
            let default = parameter.default(light.owner()).expect("parameters of lights have defaults");
            let mut set = light.clone();
            set.set(Setting { parameter, value: other_value(parameter, &default) });
            assert_ne!(document_with(set.clone()).hash(), plain, "{}", parameter.name);
            set.set(Setting { parameter, value: default });
            assert_eq!(document_with(set).hash(), plain, "{}", parameter.name);
        }
    }
}

/// The hash of a light with all defaults covers its shape and the values without defaults, so that a new row changes no
/// earlier hash.
///
/// Rules: DOC-4
#[test]
fn defaults_are_not_hashed() {
    let [spot, bendy, directional, omni] = plain_lights();
    let text = |text: &str| [&(text.len() as u64).to_le_bytes(), text.as_bytes()].concat();
    let reals = |reals: &[f64]| reals.iter().flat_map(|real| real.to_le_bytes()).collect::<Vec<_>>();
    let positions: Vec<_> = bendy.points().iter().flat_map(|point| point.position.to_array()).collect();
    let radii: Vec<_> = bendy.points().iter().map(|point| point.radius).collect();
    let count = |points: u64| points.to_le_bytes().to_vec();
    let walked_spot = [vec![0], count(0)].concat();
    let walked_bendy = [vec![1], count(3), text("position"), reals(&positions), text("radius"), reals(&radii)].concat();
    let [walked_directional, walked_omni] = [4, 5].map(|number| [vec![number], count(0)].concat());
    for (light, walked) in
        [(spot, walked_spot), (bendy, walked_bendy), (directional, walked_directional), (omni, walked_omni)]
    {
        let digest = |light| CheckedLight::new(light).expect("a valid light").digest().0;
        assert_eq!(digest(light.clone())[..], Sha256::digest(&walked)[..]);
        assert_ne!(digest(light.with(NAME, "other".into()))[..], Sha256::digest(&walked)[..]);
    }
}
