//! Commands on control points.

use document::{Change, Command, EditError};
use glam::DVec3;
use light::parameters::{POINT_COLOR, POINT_INTENSITY, POSITION, RADIUS};
use light::{ControlPoint, LightError};

use crate::support::{BENDY, SPOT, done, insert, light_of, refused, sample, set_point};

fn remove(point: usize) -> Command {
    Command::RemovePoint { light: BENDY, point, ignore_pins: false }
}

/// Rules: REC-2, DOC-2
#[test]
fn a_control_point_takes_values_one_by_one() {
    let mut document = sample();
    let before = light_of(&document, BENDY).points().to_vec();
    let (position, color) = (DVec3::new(0.1, 0.2, -2.1), DVec3::new(0.3, 0.2, 0.1));
    for setting in [POSITION.to(position), RADIUS.to(0.3), POINT_COLOR.to(color), POINT_INTENSITY.to(3.0)] {
        let layout = document.lights()[&BENDY].layout;
        let changes = done(&mut document, &set_point(2, setting.clone()));
        let [Change::Point { layout: counted_in, point: 2, parameter, new, .. }] = &changes[..] else {
            panic!("{changes:?}")
        };
        assert_eq!((*counted_in, *parameter, new), (layout, setting.parameter, &setting.value));
    }
    let after = light_of(&document, BENDY).points();
    assert_eq!(after[2], ControlPoint { position, radius: 0.3, color, intensity: 3.0 });
    for other in [0, 1, 3, 4] {
        assert_eq!(after[other], before[other]);
    }
}

/// Rules: CMD-5
#[test]
fn the_source_keeps_its_place_but_not_its_radius() {
    let mut document = sample();
    let position = POSITION.to(DVec3::new(0.1, 0.0, 0.0));
    for command in [set_point(0, position), insert(0), remove(0)] {
        assert_eq!(refused(&document, &command), EditError::Source, "{command:?}");
    }
    done(&mut document, &set_point(0, RADIUS.to(0.2)));
    assert_eq!(light_of(&document, BENDY).points()[0].radius, 0.2);
}

/// Rules: CMD-3
#[test]
fn points_that_are_not_there_are_refused() {
    let document = sample();
    let none = |point| EditError::NoPoint { light: "“key”".into(), point, count: 5 };
    assert_eq!(refused(&document, &set_point(5, RADIUS.to(0.1))), none(5));
    assert_eq!(refused(&document, &insert(6)), none(6));
    assert_eq!(refused(&document, &remove(5)), none(5));
    let of_spot = Command::RemovePoint { light: SPOT, point: 1, ignore_pins: false };
    assert!(matches!(refused(&document, &of_spot), EditError::WrongKind { kind: "spotlight", .. }));
}

/// Rules: DOC-2
#[test]
fn a_point_without_a_position_cuts_the_corner() {
    for (point, corner) in [(1, 1), (2, 2), (3, 3), (4, 3)] {
        let mut document = sample();
        let before = light_of(&document, BENDY).points().to_vec();
        let changes = done(&mut document, &insert(point));
        assert!(matches!(changes[..], [Change::ControlPoints { .. }]));
        let after = light_of(&document, BENDY).points();
        assert_eq!(after.len(), 6);
        for (index, neighbour) in [(corner, corner - 1), (corner + 1, corner + 1)] {
            let (corner, neighbour, new) = (before[corner], before[neighbour], after[index]);
            assert_eq!(new.position, (3.0 * corner.position + neighbour.position) / 4.0);
            assert_eq!(new.radius, (3.0 * corner.radius + neighbour.radius) / 4.0);
            assert_eq!(new.intensity, (3.0 * corner.intensity + neighbour.intensity) / 4.0);
        }
        assert_eq!((&after[..corner], &after[corner + 2..]), (&before[..corner], &before[corner + 1..]));
    }
}

/// Rules: DOC-2
#[test]
fn a_point_with_a_position_takes_the_rest_from_its_neighbours() {
    let mut document = sample();
    let before = light_of(&document, BENDY).points().to_vec();
    let position = Some(DVec3::new(0.375, 0.0625, -2.5));
    let command = Command::InsertPoint {
        light: BENDY,
        point: 3,
        position,
        radius: None,
        color: None,
        intensity: None,
        ignore_pins: false,
    };
    done(&mut document, &command);
    let after = light_of(&document, BENDY).points();
    assert_eq!((after[3].radius, after[3].intensity), (0.4375, 6.0));
    assert_eq!(after[3].color, (before[2].color + before[3].color) / 2.0);
    assert_eq!((&after[..3], &after[4..]), (&before[..3], &before[3..]));
}

/// Rules: DOC-2
#[test]
fn a_point_past_the_last_goes_as_far_again() {
    let mut document = sample();
    done(&mut document, &insert(5));
    let after = light_of(&document, BENDY).points();
    // Twice (1, 1/4, -4) less (1/2, 1/8, -3); twice 5/8 less 1/2.
    assert_eq!((after[5].position, after[5].radius), (DVec3::new(1.5, 0.375, -5.0), 0.75));
    assert_eq!((after[5].color, after[5].intensity), (after[4].color, after[4].intensity), "as the last");
}

/// A radius that shrinks towards the end would be negative past it.
///
/// Rules: CMD-2
#[test]
fn a_radius_past_the_last_stops_at_nothing() {
    let mut document = sample();
    done(&mut document, &set_point(4, RADIUS.to(0.125)));
    done(&mut document, &insert(5));
    assert_eq!(light_of(&document, BENDY).points()[5].radius, 0.0);
}

/// Rules: DOC-2
#[test]
fn a_point_takes_what_it_is_given() {
    let mut document = sample();
    let (position, color) = (DVec3::new(0.2, 0.0, -1.5), DVec3::new(0.1, 0.2, 0.3));
    let given = ControlPoint { position, radius: 0.3, color, intensity: 5.0 };
    let (position, radius, color, intensity) = (Some(position), Some(0.3), Some(color), Some(5.0));
    done(
        &mut document,
        &Command::InsertPoint { light: BENDY, point: 2, position, radius, color, intensity, ignore_pins: false },
    );
    assert_eq!(light_of(&document, BENDY).points()[2], given);
}

/// Rules: DOC-2, CMD-2
#[test]
fn points_can_be_removed_down_to_three() {
    let mut document = sample();
    let before = light_of(&document, BENDY).points().to_vec();
    done(&mut document, &remove(2));
    assert_eq!(light_of(&document, BENDY).points(), [before[0], before[1], before[3], before[4]]);
    done(&mut document, &remove(3));
    let error = refused(&document, &remove(1));
    assert!(matches!(error, EditError::InvalidLight { .. }), "a curve has three: {error}");
}

/// Rules: CMD-2, CMD-1
#[test]
fn a_tube_that_folds_is_refused() {
    let mut document = sample();
    let fold = refused(&document, &set_point(2, RADIUS.to(20.0)));
    assert!(matches!(fold, EditError::InvalidLight { reason: LightError::Fold { .. }, .. }), "{fold}");
    let sharp = set_point(3, POSITION.to(DVec3::new(-3.0, 0.0, -1.0)));
    assert!(matches!(refused(&document, &sharp), EditError::InvalidLight { .. }));
    assert!(matches!(refused(&document, &set_point(2, RADIUS.to(-1.0))), EditError::InvalidLight { .. }));
    done(&mut document, &set_point(2, RADIUS.to(0.4)));
}
