//! Bending and straightening of lights.

use std::sync::Arc;

use document::{Change, Command, DEFAULT_BEND_SEGMENTS, EditError, axis_length, describe_changes, fill_in_from_scene};
use glam::{DAffine3, DQuat, DVec3};
use light::parameters::{COLOR, INTENSITY, RANGE, ROTATION, TRANSLATION};
use light::{Light, LightError, ParameterOwner};
use raycast::Bvh;
use scene::{Material, Mesh, Node, Primitive, Scene};

use crate::support::{BENDY, SPOT, checked, done, light_of, refused, sample};

fn bend(range: Option<f64>) -> Command {
    Command::BendLight {
        light: SPOT,
        segments: DEFAULT_BEND_SEGMENTS,
        range,
        cone_angle: None,
        toward: None,
        ignore_pins: false,
    }
}

/// Rules: CMD-12
#[test]
fn a_light_is_bent_under_its_id_and_straightened_to_what_it_was() {
    let mut document = sample();
    let before = document.clone();
    let spot = light_of(&document, SPOT).clone();
    let changes = done(&mut document, &bend(Some(7.0)));
    assert!(matches!(&changes[..], [Change::Light { light: SPOT, old: Some(_), new: Some(_) }]), "{changes:?}");
    assert_eq!(describe_changes(&changes, &document), "bending “lamp”");
    let bent = light_of(&document, SPOT);
    assert_eq!((bent.owner(), bent.name()), (ParameterOwner::Bendy, "lamp"));
    assert_eq!(bent.points().len(), DEFAULT_BEND_SEGMENTS + 2);
    assert_eq!(bent.points().last().expect("points").position, DVec3::new(0.0, 0.0, -7.0));
    assert_eq!((bent.get(COLOR), bent.get(INTENSITY)), (spot.get(COLOR), spot.get(INTENSITY)));
    // Undone as one step, it is the light before.
    let mut undone = document.clone();
    undone.apply(&[changes[0].inverse()]).expect("it holds");
    assert_eq!((undone.lights(), undone.hash()), (before.lights(), before.hash()));
    let changes = done(&mut document, &Command::StraightenLight { light: SPOT, ignore_pins: false });
    assert_eq!(describe_changes(&changes, &document), "straightening “lamp”");
    assert_eq!(light_of(&document, SPOT), &spot);
    // The numbering is new each time, so a stale command for a control point finds none.
    assert_ne!(document.lights()[&SPOT].layout, before.lights()[&SPOT].layout);
}

/// Rules: CMD-12
#[test]
fn bent_lights_are_not_bent_nor_straight_ones_straightened() {
    let document = sample();
    let bend = Command::BendLight {
        light: BENDY,
        segments: 3,
        range: None,
        cone_angle: None,
        toward: None,
        ignore_pins: false,
    };
    let EditError::InvalidLight { light, reason } = refused(&document, &bend) else { panic!() };
    assert_eq!((light.as_str(), reason), ("“key”", LightError::NotASpot));
    let straighten = Command::StraightenLight { light: SPOT, ignore_pins: false };
    assert!(refused(&document, &straighten).to_string().contains("straight already"));
    for segments in [0, 100_000] {
        let bend = Command::BendLight {
            light: SPOT,
            segments,
            range: None,
            cone_angle: None,
            toward: None,
            ignore_pins: false,
        };
        assert!(refused(&document, &bend).to_string().contains("is bent into 1 to"));
    }
    for range in [-1.0, 0.0, f64::NAN, f64::INFINITY, 1e300] {
        let said = refused(&document, &self::bend(Some(range))).to_string();
        assert!(said.contains("`range`") || range == 1e300, "{said}");
    }
}

/// Returns a wall across the axis at z = -4, 2 units wide and high, and a pane in front of it.
fn room(pane_at: f64) -> Bvh {
    let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let primitive = Primitive {
        positions: corners.map(glam::Vec3::from_array).into(),
        normals: vec![glam::Vec3::Z; 4],
        uvs: vec![glam::Vec2::ZERO; 4],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Primitive::default()
    };
    let node = |z: f64| Node {
        name: "wall".into(),
        parent: None,
        parent_from_local: DAffine3::from_translation(DVec3::new(0.0, 0.0, z)),
        mesh: Some(0),
    };
    let meshes = vec![Mesh { name: "wall".into(), primitives: vec![primitive] }];
    let nodes = vec![node(-4.0), node(pane_at)];
    Bvh::new(scene::pose(Scene { materials: vec![Material::default()], meshes, nodes, ..Scene::default() }, 0.0))
}

/// The control points reach to the first surface on the axis, or past the scene. A log of that needs no scene.
///
/// Rules: CMD-12
#[test]
fn control_points_reach_to_where_the_axis_meets_the_scene() {
    let spot = |at: DVec3, yaw: f64| Light::spot().with(TRANSLATION, at).with(ROTATION, DQuat::from_rotation_y(yaw));
    let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
    let ahead = spot(DVec3::new(0.3, -0.2, 1.0), 0.0);
    assert!(close(axis_length(&ahead, &room(-4.0)), 5.0));
    // Deliberate fault that the check must detect: a nearer surface.
    assert!(close(axis_length(&ahead, &room(-2.0)), 3.0));
    // The light's own housing does not count.
    assert!(close(axis_length(&ahead, &room(0.99)), 5.0));
    // Beside the wall, and away from it.
    assert!(axis_length(&spot(DVec3::new(3.0, 0.0, 1.0), 0.0), &room(-2.0)) > 5.0);
    assert!(axis_length(&spot(DVec3::new(0.0, 0.0, 1.0), std::f64::consts::PI), &room(-2.0)) > 0.0);
    assert_eq!(axis_length(&spot(DVec3::Z, std::f64::consts::PI), &Bvh::new(Arc::default())), 1.0);

    let mut document = sample();
    let command = fill_in_from_scene(bend(None), &document, &room(-3.0));
    assert_eq!(command, bend(Some(3.0)));
    assert_eq!(fill_in_from_scene(bend(Some(2.0)), &document, &room(-3.0)), bend(Some(2.0)));
    done(&mut document, &command);
    assert_eq!(light_of(&document, SPOT).points()[4].position, DVec3::new(0.0, 0.0, -3.0));
    // A light with a range ends at its range.
    let mut document = sample();
    done(&mut document, &Command::SetLight { light: SPOT, setting: RANGE.to(Some(5.0)), ignore_pins: false });
    done(&mut document, &bend(Some(3.0)));
    assert_eq!(light_of(&document, SPOT).points()[4].position, DVec3::new(0.0, 0.0, -5.0));
}

/// A light without a cone gets one of 45 degrees towards the scene's centre, or the given one.
///
/// Rules: CMD-12
#[test]
fn lights_without_a_cone_are_bent_in_the_one_they_are_given() {
    let room = room(-6.0);
    let middle = room.posed.origin_in_world;
    let at = DVec3::new(0.0, 3.0, 0.0);
    for light in [Light::omni(), Light::directional()] {
        let light = light.with(TRANSLATION, at).with(ROTATION, DQuat::from_rotation_x(-0.5)).with(INTENSITY, 7.0);
        let mut document = sample();
        let [Change::Light { light: id, .. }] = done(&mut document, &Command::AddLight(checked(light.clone())))[..]
        else {
            panic!()
        };
        let before = document.clone();
        let bend = |cone_angle, toward| Command::BendLight {
            light: id,
            segments: 3,
            range: None,
            cone_angle,
            toward,
            ignore_pins: false,
        };
        for (cone_angle, toward) in [(None, None), (Some(20.0), Some(DVec3::new(0.5, -0.5, -4.0)))] {
            let mut document = before.clone();
            let command = fill_in_from_scene(bend(cone_angle, toward), &document, &room);
            let changes = done(&mut document, &command);
            let bent = light_of(&document, id);
            assert_eq!((bent.owner(), bent.get(INTENSITY)), (ParameterOwner::Bendy, 7.0));
            let (cone, aim): (f64, DVec3) = (cone_angle.unwrap_or(45.0), toward.unwrap_or(middle));
            let last = bent.points()[4];
            let slope = last.radius / last.position.length();
            assert!((slope - libm::tan(cone.to_radians())).abs() < 1e-12);
            let transform = bent.transform();
            let axis = (transform.world_from_local(last.position) - transform.translation).normalize();
            let aimed = (aim - transform.translation).normalize();
            assert!((axis - aimed).length() < 1e-12, "{axis} {aimed}");
            let is_sun = light.owner() == ParameterOwner::Directional;
            let came_from = light.get(ROTATION) * DVec3::NEG_Z;
            assert_eq!((axis - came_from).length() < 1e-12, is_sun, "a sun keeps its direction");
            assert_eq!(transform.translation == at, !is_sun, "a lamp keeps its place");
            document.apply(&[changes[0].inverse()]).expect("it holds");
            assert_eq!(document.lights(), before.lights());
        }
    }
}
