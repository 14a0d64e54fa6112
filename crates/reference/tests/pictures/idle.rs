//! Tests that parameters have no effect if the table says so.

use glam::DVec3;
use light::parameters::{CUT_OFF, CUT_ON, NAME, parameters_of};
use light::{Light, Links, Parameter, ParameterKind, Setting, Value};
use scene::Aov;

use crate::support::{ball_over_floor, render, spot, view};

/// Returns a light of each shape. All shine on the ball.
fn lights() -> [Light; 4] {
    let (source, target) = (DVec3::new(1.0, 3.0, 0.5), DVec3::Y);
    let spot = spot(source, target);
    let bent = light::bend(&spot, 3).expect("bent");
    let placed = |light: Light| light.with_transform(spot.transform());
    [placed(Light::omni()), placed(Light::directional()), spot.clone(), bent]
}

/// Returns a value other than the row's default.
fn another(row: &Parameter) -> Value {
    match row.kind {
        ParameterKind::Number(number) => Value::Number(match number.unit {
            "K" => 2000.0,
            "world units" => 2.5,
            _ => 0.6,
        }),
        ParameterKind::Color => Value::Vector(DVec3::splat(0.5)),
        ParameterKind::Links => Value::Links(Links::new(Vec::new(), vec!["ball".into()]).expect("few")),
        _ => panic!("{row:?}: say what else it can be"),
    }
}

/// Returns values of a parameter that another one depends on.
fn all_of(row: &Parameter) -> Vec<Value> {
    match row.kind {
        ParameterKind::Flag => vec![Value::Flag(false), Value::Flag(true)],
        ParameterKind::Choice(choices) => choices.iter().map(|choice| Value::Choice(choice.name)).collect(),
        // Within the light path to the floor.
        ParameterKind::Number(_) if row.name == CUT_ON.name => vec![Value::Absent, Value::Number(3.2)],
        ParameterKind::Number(_) if row.name == CUT_OFF.name => vec![Value::Absent, Value::Number(1.8)],
        _ => panic!("{row:?}: say what it can be"),
    }
}

fn set(light: &Light, parameter: &'static Parameter, value: Value) -> Light {
    let mut light = light.clone();
    light.set(Setting { parameter, value });
    light
}

/// Returns true if the picture of a light changes with the parameter.
fn has_effect(light: &Light, row: &'static Parameter) -> bool {
    let (scene, view) = (ball_over_floor(), view(DVec3::new(0.5, 4.0, 3.0), DVec3::ZERO, Aov::Beauty));
    let picture = |light: Light| render(&scene, &view, &[light]).pixels;
    picture(light.clone()) != picture(set(light, row, another(row)))
}

#[test]
fn a_parameter_that_needs_another_has_an_effect_with_it_alone() {
    for light in lights() {
        let rows = parameters_of(light.owner());
        for row in rows.iter().copied() {
            let Some(needs) = row.needs else { continue };
            let other = rows.iter().copied().find(|other| other.name == needs.parameter);
            let other = other.unwrap_or_else(|| panic!("{:?} lacks {}", light.owner(), needs.parameter));
            for value in all_of(other) {
                let with = set(&light, other, value.clone());
                let expected = needs.value.is_met_by(&value);
                assert_eq!(has_effect(&with, row), expected, "{row:?} of {:?}, {value:?}", light.owner());
            }
        }
    }
}

/// A spotlight keeps its scale only for bending it later.
#[test]
fn idle_parameters_have_no_effect_on_their_owner() {
    for light in lights() {
        for row in parameters_of(light.owner()).iter().copied().filter(|row| row.has_no_effect_on(light.owner())) {
            assert!(!has_effect(&light, row), "{row:?} of {:?}", light.owner());
        }
        assert!(!NAME.has_no_effect_on(light.owner()), "no picture shows a name of anything");
    }
}
