//! Commands on control points.

use document::{Change, Command, EditError, PointParameter};
use glam::DVec3;

use crate::support::{BENDY, SPOT, bendy_of, done, edited, refused};

fn set(point: usize, parameter: PointParameter) -> Command {
    Command::SetPoint { light: BENDY, point, parameter }
}

fn insert(point: usize) -> Command {
    Command::InsertPoint { light: BENDY, point, position: None, radius: None, color: None, intensity: None }
}

/// Rules: REC-2, DOC-2
#[test]
fn a_control_point_takes_values_one_by_one() {
    let mut document = edited();
    let before = bendy_of(&document, BENDY).clone();
    let (position, color) = (DVec3::new(0.1, 0.2, -2.1), DVec3::new(0.3, 0.2, 0.1));
    for parameter in [
        PointParameter::Position(position),
        PointParameter::Radius(0.3),
        PointParameter::Color(color),
        PointParameter::Intensity(3.0),
    ] {
        let layout = document.lights()[&BENDY].layout;
        let changes = done(&mut document, &set(2, parameter));
        let [Change::Point { layout: counted_in, point: 2, new, .. }] = changes[..] else {
            panic!("{changes:?}")
        };
        assert_eq!((counted_in, new), (layout, parameter));
    }
    let after = bendy_of(&document, BENDY);
    assert_eq!(
        (after.points[2], after.radii[2], after.colors[2], after.intensities[2]),
        (position, 0.3, color, 3.0)
    );
    for other in [0, 1, 3, 4] {
        assert_eq!((after.points[other], after.radii[other]), (before.points[other], before.radii[other]));
    }
}

/// Rules: CMD-5
#[test]
fn the_source_keeps_its_place_but_not_its_radius() {
    let mut document = edited();
    let position = PointParameter::Position(DVec3::new(0.1, 0.0, 0.0));
    assert_eq!(refused(&document, &set(0, position)), EditError::Source);
    assert_eq!(refused(&document, &insert(0)), EditError::Source);
    assert_eq!(refused(&document, &Command::RemovePoint { light: BENDY, point: 0 }), EditError::Source);
    done(&mut document, &set(0, PointParameter::Radius(0.2)));
    assert_eq!(bendy_of(&document, BENDY).radii[0], 0.2);
}

/// Rules: CMD-3
#[test]
fn points_that_are_not_there_are_refused() {
    let document = edited();
    let none = |point| EditError::NoPoint { light: "“key”".into(), point, count: 5 };
    assert_eq!(refused(&document, &set(5, PointParameter::Radius(0.1))), none(5));
    assert_eq!(refused(&document, &insert(6)), none(6));
    assert_eq!(refused(&document, &Command::RemovePoint { light: BENDY, point: 5 }), none(5));
    let of_spot = Command::RemovePoint { light: SPOT, point: 1 };
    assert!(matches!(refused(&document, &of_spot), EditError::WrongKind { kind: "spotlight", .. }));
}

/// Rules: DOC-2
#[test]
fn a_point_without_a_position_cuts_the_corner() {
    for (point, corner) in [(1, 1), (2, 2), (3, 3), (4, 3)] {
        let mut document = edited();
        let before = bendy_of(&document, BENDY).clone();
        let changes = done(&mut document, &insert(point));
        assert!(matches!(changes[..], [Change::ControlPoints { .. }]));
        let after = bendy_of(&document, BENDY);
        assert_eq!(after.points.len(), 6);
        for (index, neighbour) in [(corner, corner - 1), (corner + 1, corner + 1)] {
            let quarter = |old: &[f64]| (3.0 * old[corner] + old[neighbour]) / 4.0;
            assert_eq!(after.points[index], (3.0 * before.points[corner] + before.points[neighbour]) / 4.0);
            assert_eq!(after.radii[index], quarter(&before.radii));
            assert_eq!(after.intensities[index], quarter(&before.intensities));
        }
        assert_eq!(
            (&after.points[..corner], &after.points[corner + 2..]),
            (&before.points[..corner], &before.points[corner + 1..])
        );
    }
}

/// Rules: DOC-2
#[test]
fn a_point_with_a_position_takes_the_rest_from_its_neighbours() {
    let mut document = edited();
    let before = bendy_of(&document, BENDY).clone();
    let position = Some(DVec3::new(0.375, 0.0625, -2.5));
    let command =
        Command::InsertPoint { light: BENDY, point: 3, position, radius: None, color: None, intensity: None };
    done(&mut document, &command);
    let after = bendy_of(&document, BENDY);
    assert_eq!((after.radii[3], after.intensities[3]), (0.4375, 6.0));
    assert_eq!(after.colors[3], (before.colors[2] + before.colors[3]) / 2.0);
    assert_eq!((&after.points[..3], &after.points[4..]), (&before.points[..3], &before.points[3..]));
}

/// Rules: DOC-2
#[test]
fn a_point_past_the_last_goes_as_far_again() {
    let mut document = edited();
    done(&mut document, &insert(5));
    let after = bendy_of(&document, BENDY);
    // Twice (1, 1/4, -4) less (1/2, 1/8, -3); twice 5/8 less 1/2.
    assert_eq!((after.points[5], after.radii[5]), (DVec3::new(1.5, 0.375, -5.0), 0.75));
    assert_eq!(
        (after.colors[5], after.intensities[5]),
        (after.colors[4], after.intensities[4]),
        "as the last"
    );
}

/// A radius that shrinks to the end would be negative past it.
///
/// Rules: CMD-2
#[test]
fn a_radius_past_the_last_stops_at_nothing() {
    let mut document = edited();
    done(&mut document, &set(4, PointParameter::Radius(0.125)));
    done(&mut document, &insert(5));
    assert_eq!(bendy_of(&document, BENDY).radii[5], 0.0);
}

/// Rules: DOC-2
#[test]
fn a_point_takes_what_it_is_given() {
    let mut document = edited();
    let (position, color) = (DVec3::new(0.2, 0.0, -1.5), DVec3::new(0.1, 0.2, 0.3));
    done(
        &mut document,
        &Command::InsertPoint {
            light: BENDY,
            point: 2,
            position: Some(position),
            radius: Some(0.3),
            color: Some(color),
            intensity: Some(5.0),
        },
    );
    let after = bendy_of(&document, BENDY);
    assert_eq!((after.points[2], after.radii[2]), (position, 0.3));
    assert_eq!((after.colors[2], after.intensities[2]), (color, 5.0));
}

/// Rules: DOC-2, CMD-2
#[test]
fn points_can_be_removed_down_to_three() {
    let mut document = edited();
    done(&mut document, &Command::RemovePoint { light: BENDY, point: 2 });
    let after = bendy_of(&document, BENDY);
    assert_eq!(after.points[2], DVec3::new(0.5, 0.125, -3.0));
    assert_eq!(
        (&after.radii, &after.intensities),
        (&vec![0.125, 0.25, 0.5, 0.625], &vec![1.0, 2.0, 8.0, 16.0])
    );
    assert_eq!(after.colors.len(), 4);
    done(&mut document, &Command::RemovePoint { light: BENDY, point: 3 });
    let error = refused(&document, &Command::RemovePoint { light: BENDY, point: 1 });
    assert!(matches!(error, EditError::InvalidLight { .. }), "a curve has three: {error}");
}

/// Rules: CMD-2, CMD-1
#[test]
fn a_tube_that_folds_is_refused() {
    let mut document = edited();
    let fold = refused(&document, &set(2, PointParameter::Radius(20.0)));
    assert!(matches!(fold, EditError::InvalidLight { reason: light::LightError::Fold { .. }, .. }), "{fold}");
    let sharp = set(3, PointParameter::Position(DVec3::new(-3.0, 0.0, -1.0)));
    assert!(matches!(refused(&document, &sharp), EditError::InvalidLight { .. }));
    assert!(matches!(
        refused(&document, &set(2, PointParameter::Radius(-1.0))),
        EditError::InvalidLight { .. }
    ));
    done(&mut document, &set(2, PointParameter::Radius(0.4)));
}
