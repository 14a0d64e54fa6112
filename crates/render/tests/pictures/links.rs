//! Tests of links: the nodes that a light lights, and those that cast its shadows. `tests/links.rs` tests the
//! reference.

use glam::{DAffine3, DQuat, DVec3};
use light::parameters::{CONE_ANGLE, DECAY, LIGHT_LINK, RANGE, SHADOW_LINK};
use light::{Decay, Light, Links, ParameterKey};
use render::{Aov, Device, Host, MemoryKind, Picture, View};
use scene::{Material, Mesh, Node, Scene};

use crate::support::{instances, picture, renderer, renderer_on, since, spot, square, view};

/// Returns a floor, and a group of two tables with one mesh and one name, the second above a corner of the first.
fn tables() -> Scene {
    let mut scene = Scene { materials: vec![Material::default()], ..Scene::default() };
    (scene.fill.sky, scene.fill.ground) = (DVec3::splat(0.125), DVec3::splat(0.125));
    scene.meshes = vec![Mesh { name: String::new(), primitives: vec![square()] }];
    let placed = |half: f64, at: [f64; 3]| {
        let at = DVec3::from_array(at);
        DAffine3::from_scale_rotation_translation(DVec3::splat(half), DQuat::IDENTITY, at)
    };
    let node =
        |name: &str, parent, parent_from_local, mesh| Node { name: name.into(), parent, parent_from_local, mesh };
    scene.nodes = vec![
        node("floor", None, placed(3.0, [0.0; 3]), Some(0)),
        node("tables", None, DAffine3::IDENTITY, None),
        node("table", Some(1), placed(0.5, [-0.2, 0.6, 0.0]), Some(0)),
        node("table", Some(1), placed(0.25, [0.4, 1.1, 0.2]), Some(0)),
    ];
    scene
}

const FIRST: &str = "tables/table";
const SECOND: &str = "tables/table#2";

/// Returns the scene without one of its nodes.
fn without(node: usize) -> Scene {
    let mut scene = tables();
    scene.nodes[node].mesh = None;
    scene
}

fn seen(aov: Aov) -> View {
    view(DVec3::new(1.5, 3.5, 3.0), DVec3::new(0.0, 0.3, 0.0), [60, 44], aov)
}

/// Returns, for each pixel, true if it shows the node.
fn shows(node: usize) -> Vec<bool> {
    let depths = [tables(), without(node)].map(|scene| picture(&scene, &seen(Aov::Depth), &[]).pixels);
    let pixels: Vec<bool> = depths[0].iter().zip(&depths[1]).map(|(with, without)| with != without).collect();
    assert!(pixels.iter().filter(|shows| **shows).count() > 20);
    pixels
}

fn drawn(scene: &Scene, lights: &[Light]) -> Picture {
    picture(scene, &seen(Aov::Beauty), lights)
}

fn links(include: &[&str], exclude: &[&str]) -> Option<Links> {
    let list = |paths: &[&str]| paths.iter().map(|path| String::from(*path)).collect();
    Links::new(list(include), list(exclude))
}

/// Returns a spotlight over the tables, straight and bent.
fn keys() -> [Light; 2] {
    let spot = spot(DVec3::new(0.6, 3.0, 0.6), DVec3::ZERO)
        .with(CONE_ANGLE, 40.0)
        .with(RANGE, Some(5.0))
        .with(DECAY, Decay::None);
    let bent = light::bend(&spot, 2).expect("it has a range");
    [spot, bent]
}

fn other() -> Light {
    spot(DVec3::new(-1.5, 2.5, 0.5), DVec3::ZERO)
}

/// Compares pictures: true if they agree on the pixels in `shows`, and true if they agree on the others.
fn same(a: &Picture, b: &Picture, shows: &[bool]) -> [bool; 2] {
    [true, false].map(|there| {
        let mut pixels = a.pixels.iter().zip(&b.pixels).zip(shows).filter(|(_, shows)| **shows == there);
        pixels.all(|((a, b), _)| a == b)
    })
}

/// Rules: LINK-1, LINK-2
#[test]
fn a_node_that_is_left_out_loses_that_light_and_nothing_else() {
    for key in keys() {
        let all = drawn(&tables(), &[key.clone(), other()]);
        let dark = drawn(&tables(), &[other()]);
        for (node, path) in [(0, "floor"), (2, FIRST), (3, SECOND)] {
            let shows = shows(node);
            let linked = drawn(&tables(), &[key.clone().with(LIGHT_LINK, links(&[], &[path])), other()]);
            assert_eq!(same(&linked, &dark, &shows), [true, false], "{path}");
            assert_eq!(same(&linked, &all, &shows), [false, true], "{path}");
            // Only this node, the other way round.
            let alone = drawn(&tables(), &[key.clone().with(LIGHT_LINK, links(&[path], &[])), other()]);
            assert_eq!(same(&alone, &all, &shows), [true, false], "{path}");
            assert_eq!(same(&alone, &dark, &shows), [false, true], "{path}");
        }
        // A path that names no node changes nothing. Deliberate fault that the check must detect: the path of the other
        // table, above.
        let none =
            key.clone().with(LIGHT_LINK, links(&[], &["tables/chair"])).with(SHADOW_LINK, links(&[], &["chair"]));
        assert_eq!(drawn(&tables(), &[none, other()]), all);
    }
}

/// A group's entry holds for its descendants, except for those with an entry of their own.
///
/// Rules: LINK-2
#[test]
fn the_deepest_entry_decides() {
    for key in keys() {
        let under = |links: Option<Links>| drawn(&tables(), &[key.clone().with(LIGHT_LINK, links)]);
        let group = under(links(&["tables"], &[SECOND]));
        assert_eq!(group, under(links(&[FIRST], &[])));
        assert_eq!(group, under(links(&[], &["floor", SECOND])));
        assert_eq!(under(links(&[SECOND], &["tables"])), under(links(&[SECOND], &[])));
        // Deliberate fault that the check must detect: the group alone.
        assert_ne!(group, under(links(&["tables"], &[])));
    }
}

/// Rules: LINK-1, LINK-2
#[test]
fn nodes_that_cast_no_shadow_receive_some() {
    for key in keys() {
        let all = drawn(&tables(), std::slice::from_ref(&key));
        let linked = |path: &str| drawn(&tables(), &[key.clone().with(SHADOW_LINK, links(&[], &[path]))]);
        // The lower table is in the shadow of the upper one, as before; the floor no longer has its shadow.
        let lower = shows(2);
        assert_eq!(same(&linked(FIRST), &all, &lower), [true, false]);
        // The upper one has its light as before. Without it, the scene is lit as if it were absent. Each map is fitted
        // to all of the scene, so remaining edges may move by a part of a texel: it stays alone.
        let upper = shows(3);
        let nothing = drawn(&tables(), &[key.clone().with(SHADOW_LINK, links(&["floor"], &[]))]);
        assert_eq!(same(&nothing, &all, &upper), [true, false]);
        let visible = |links| picture(&tables(), &seen(Aov::Visibility), &[key.clone().with(SHADOW_LINK, links)]);
        let is_lit = |picture: &Picture| picture.pixels.iter().filter(|p| p[3] == 1.0).all(|p| p[0] == 1.0);
        assert!(is_lit(&visible(links(&["floor"], &[]))));
        assert!(is_lit(&visible(links(&[], &["tables"]))));
        // Deliberate faults that the check must detect: one table still casts its shadow.
        assert!(!is_lit(&visible(links(&[], &[FIRST]))) && !is_lit(&visible(links(&[], &[SECOND]))));
        assert_ne!(linked(FIRST), linked(SECOND));
    }
}

/// Rules: LINK-3
#[test]
fn another_scene_may_have_the_node() {
    for key in keys() {
        let linked = key.clone().with(LIGHT_LINK, links(&[], &["chair"]));
        let mut renamed = tables();
        renamed.nodes[2].name = "chair".into();
        renamed.nodes[2].parent = None;
        let mut renderer = renderer(&tables());
        let lights = instances(&[linked]);
        let mut draw = |scene: &Scene| {
            renderer.set_scene(&scene::pose(scene.clone(), 0.0)).expect("it fits");
            renderer.render(&seen(Aov::Beauty), &lights).expect("drawn")
        };
        assert_eq!(draw(&tables()), drawn(&tables(), std::slice::from_ref(&key)));
        let of_renamed = draw(&renamed);
        assert_ne!(of_renamed, drawn(&tables(), std::slice::from_ref(&key)));
        assert_eq!(draw(&tables()), drawn(&tables(), std::slice::from_ref(&key)));
    }
}

/// Lights without links store nothing for them, lights with the same links share it, and unused data is freed.
#[test]
fn only_lights_with_links_take_room() {
    let device = Device::open(Host::default(), None).expect("a device");
    let mut renderer = renderer_on(&device, &tables());
    let [key, bent] = keys();
    let mut taken = |lights: &[Light]| {
        renderer.render(&seen(Aov::Beauty), &instances(lights)).expect("drawn");
        device.memory().bytes(MemoryKind::Scenes)
    };
    let linked =
        |light: &Light| light.clone().with(LIGHT_LINK, links(&["floor"], &[])).with(SHADOW_LINK, links(&[], &[FIRST]));
    let unlinked = taken(&[key.clone(), bent.clone()]);
    let one = taken(&[linked(&key), bent.clone()]);
    assert!(one > unlinked);
    assert_eq!(taken(&[linked(&key), linked(&bent)]), one);
    let two = taken(&[linked(&key), bent.clone().with(LIGHT_LINK, links(&[], &["floor"]))]);
    assert!(two > one);
    assert_eq!(taken(&[key, bent]), unlinked);
}

/// A change of lit nodes draws no map, and a change of shadow casters draws that light's map.
#[test]
fn links_draw_what_depends_on_them() {
    for key in keys() {
        let mut renderer = renderer(&tables());
        let mut draw = |key: &Light| {
            let before = renderer.counts();
            renderer.render(&seen(Aov::Beauty), &instances(&[key.clone(), other()])).expect("drawn");
            let drawn = since(before, renderer.counts());
            [drawn.gbuffer, drawn.shadow, drawn.lighting]
        };
        let set = |row: ParameterKey<Option<Links>>, path| key.clone().with(row, links(&[], &[path]));
        assert_eq!(draw(&key), [1, 2, 1]);
        assert_eq!(draw(&set(LIGHT_LINK, FIRST)), [0, 0, 1]);
        assert_eq!(draw(&set(LIGHT_LINK, SECOND)), [0, 0, 1]);
        assert_eq!(draw(&set(SHADOW_LINK, FIRST)), [0, 1, 1]);
        assert_eq!(draw(&set(SHADOW_LINK, FIRST).with(LIGHT_LINK, links(&["floor"], &[]))), [0, 0, 1]);
        assert_eq!(draw(&key), [0, 1, 1]);
    }
}
