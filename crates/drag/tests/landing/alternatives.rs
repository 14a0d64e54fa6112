//! Alternatives of drags, judged by pictures of the reference and by the light's own parameters.

use drag::{
    Alternative, Drag, DragChoice, DragPin, DragRefusal, DragResult, DragStatus, Feature, NumberedPin, PinKind,
    PinTarget, RadiusMode, Viewport, WorkBudget, drag_alternatives,
};
use glam::{DAffine3, DQuat, DVec2, DVec3};
use light::CheckedLight;
use light::parameters::LIGHT_LINK;
use raycast::Bvh;
use reference::{LinkedNodes, Reference, ReferenceLight, ShadedPoint};
use scene::{Camera, Material, Mesh, Node, Primitive, Projection, Scene, View};

use crate::support::{TestScene, Trial, demo, scenes, shadowing_node, trials};

const GRID: [u32; 2] = [72, 40];

/// Change of a pixel that counts, as a share of a bright pixel's irradiance: that of `DragOutcome::changed_share`.
const VISIBLE_CHANGE: f64 = 0.02;

struct Picture {
    reference: Reference,
    points: Vec<ShadedPoint>,
}

impl Picture {
    fn new(scene: &TestScene) -> Self {
        let reference = scene.reference();
        let view = View::beauty(scene.view.camera.clone(), scene.view.size);
        let cell = DVec2::from(scene.view.size.map(f64::from)) / DVec2::new(f64::from(GRID[0]), f64::from(GRID[1]));
        let pixels = (0..GRID[0] * GRID[1])
            .map(|k| DVec2::new(f64::from(k % GRID[0]) + 0.5, f64::from(k / GRID[0]) + 0.5) * cell);
        let points = pixels.filter_map(|pixel| reference.surface(&view, pixel)).collect();
        Self { reference, points }
    }

    /// Returns the irradiance of each pixel from some lights together, with their links.
    fn of(&self, lights: &[&light::Light]) -> Vec<f64> {
        let mut all = vec![0.0; self.points.len()];
        for light in lights {
            let checked = CheckedLight::new((*light).clone()).expect("valid");
            let linked = LinkedNodes::new(&self.reference.bvh.posed, &checked);
            let light = ReferenceLight::new(&checked);
            for (sum, surface) in all.iter_mut().zip(&self.points) {
                let lit = linked.is_lit(surface.node).then(|| self.reference.sample(&light, surface)).flatten();
                *sum += lit.filter(|lit| lit.is_visible).map_or(0.0, |lit| {
                    lit.irradiance.max_element() * surface.normal.dot(lit.coords.direction).max(0.0)
                });
            }
        }
        all
    }
}

/// Returns the share of the pixels whose light differs visibly.
fn changed_share(before: &[f64], after: &[f64]) -> f64 {
    let mut lit: Vec<f64> = before.iter().copied().filter(|irradiance| *irradiance > 0.0).collect();
    lit.sort_by(f64::total_cmp);
    let least = VISIBLE_CHANGE * lit.get(lit.len() * 9 / 10).copied().unwrap_or(1.0);
    let changed = before.iter().zip(after).filter(|(before, after)| (**before - **after).abs() > least).count();
    changed as f64 / f64::from(GRID[0] * GRID[1])
}

fn all_of(scene: &TestScene, trial: &Trial) -> Vec<DragResult> {
    let pins = NumberedPin::by_index(trial.pins.clone());
    drag_alternatives(&scene.bvh, &trial.light, &trial.drag, &pins, &WorkBudget::new(&|_| true))
}

fn short(scene: &TestScene, feature: Feature, count: usize) -> Vec<Trial> {
    let short = |mut trial: Trial| {
        let drag = &mut trial.drag;
        let distance = drag.from.distance(drag.to);
        (drag.to, drag.points) = (drag.from.lerp(drag.to, (25.0 / distance).min(1.0)), None);
        scene.tube_point(&trial.light, trial.drag.to)?;
        Some(trial)
    };
    trials(scene, feature, 4 * count).filter_map(short).take(count).collect()
}

fn of(alternatives: &[DragResult], which: Alternative) -> Option<&DragResult> {
    alternatives.iter().find(|result| result.outcome.alternative == Some(which))
}

/// The best lands wherever any that adds no light lands. The choice of the best, and of each alternative, gives what the
/// list gives.
#[test]
fn the_best_is_the_first_of_all() {
    for scene in scenes() {
        for trial in short(&scene, Feature::Shadow, 6) {
            let all = all_of(&scene, &trial);
            let lands = |result: &DragResult| result.outcome.status == DragStatus::Landed;
            let own = |result: &&DragResult| result.outcome.alternative != Some(Alternative::LinkedCopy);
            assert_eq!(all.iter().filter(own).any(lands), lands(&all[0]), "{}", scene.name);
            let chosen = |choice| {
                scene.run(&Trial { drag: Drag { choice: Some(choice), ..trial.drag.clone() }, ..trial.clone() })
            };
            assert_eq!(chosen(DragChoice::Best), all[0], "{}", scene.name);
            for result in &all {
                let alternative = result.outcome.alternative.expect("each is named");
                assert_eq!(&chosen(DragChoice::Only(alternative)), result, "{}", scene.name);
            }
        }
    }
}

/// The changed share is that of 2,880 pixels of the reference, within four standard errors of 256 pixels. The planted
/// fault is the share of another drag.
#[test]
fn the_changed_share_is_that_of_the_picture() {
    let scene = demo();
    let picture = Picture::new(&scene);
    let mut shares = Vec::new();
    for feature in [Feature::Shadow, Feature::Hotspot] {
        for trial in short(&scene, feature, 8) {
            let before = picture.of(&[trial.light.light()]);
            for result in all_of(&scene, &trial) {
                let Some(said) = result.outcome.changed_share else { continue };
                let copy = result.copy.as_ref().map(|copy| &copy.light);
                let after = picture.of(&[Some(&result.light), copy].into_iter().flatten().collect::<Vec<_>>());
                shares.push((said, changed_share(&before, &after)));
            }
        }
    }
    assert!(shares.len() > 30, "{}", shares.len());
    // Both samples have errors; the pixels where they differ from the reference at edges are within the grid's own.
    let is_near = |said: f64, is: f64| (said - is).abs() <= 4.0 * (is * (1.0 - is) / 256.0).sqrt() + 1.0 / 128.0;
    assert!(shares.iter().all(|(said, is)| is_near(*said, *is)), "{shares:?}");
    let (least, most) = shares.iter().fold((1.0, 0.0), |(a, b): (f64, f64), (said, _)| (a.min(*said), b.max(*said)));
    assert!(!is_near(least, most), "{least} {most}");
}

/// Returns the mean relative change of the lit pixels that are not in the dragged shadow.
fn change_of_lit(picture: &Picture, light: &CheckedLight, moved_caster: Option<usize>, before: &[f64]) -> f64 {
    let after = picture.of(&[light.light()]);
    let brightest = before.iter().copied().fold(0.0, f64::max);
    let lit = (0..before.len()).filter(|k| before[*k] > 0.1 * brightest);
    let changes = lit
        .filter(|k| after[*k] > 0.0 || shadowing_node(&picture.reference, light, &picture.points[*k]) != moved_caster);
    let changes: Vec<f64> = changes.map(|k| 1.0 - before[k].min(after[k]) / before[k].max(after[k])).collect();
    changes.iter().sum::<f64>() / changes.len().max(1) as f64
}

/// The best changes what was lit little more than the one that changes it least, of the alternatives that land. The
/// planted fault is the choice of the least changed share of the picture.
#[test]
fn the_best_keeps_what_was_lit() {
    let (mut more, mut more_by_share) = (Vec::new(), Vec::new());
    for scene in scenes() {
        let picture = Picture::new(&scene);
        let view = View::beauty(scene.view.camera.clone(), scene.view.size);
        for trial in short(&scene, Feature::Shadow, 30) {
            let before = picture.of(&[trial.light.light()]);
            let surface = picture.reference.surface(&view, trial.drag.from).expect("it is dragged");
            let caster = shadowing_node(&picture.reference, &trial.light, &surface);
            let all = all_of(&scene, &trial);
            let own = |result: &&DragResult| {
                result.outcome.status == DragStatus::Landed
                    && result.outcome.alternative != Some(Alternative::LinkedCopy)
            };
            let landed: Vec<(f64, f64)> = all
                .iter()
                .filter(own)
                .map(|result| {
                    let light = CheckedLight::new(result.light.clone()).expect("valid");
                    let share = result.outcome.changed_share.expect("it landed");
                    (change_of_lit(&picture, &light, caster, &before), share)
                })
                .collect();
            let Some((best, _)) = landed.first() else { continue };
            let least = landed.iter().map(|one| one.0).fold(f64::INFINITY, f64::min);
            more.push(best - least);
            let by_share = landed.iter().min_by(|a, b| a.1.total_cmp(&b.1)).expect("some landed");
            more_by_share.push(by_share.0 - least);
        }
    }
    // An alternative that changes at most a fifth stays.
    let most = |all: &[f64]| all.iter().copied().fold(0.0, f64::max);
    assert!(more.len() > 60 && most(&more) < 0.2, "{more:?}");
    assert!(most(&more_by_share) > 0.2, "{more_by_share:?}");
}

/// A linked copy and the dragged light illuminate together what the light did, where nothing moved: on the caster, to the
/// bit. The planted fault is a copy that illuminates everything.
#[test]
fn a_linked_copy_leaves_the_caster_as_it_was() {
    let (mut checked, mut caught) = (0, 0);
    for scene in scenes() {
        let picture = Picture::new(&scene);
        for trial in short(&scene, Feature::Shadow, 4) {
            let all = all_of(&scene, &trial);
            let Some((result, copy)) = of(&all, Alternative::LinkedCopy).and_then(|it| Some((it, it.copy.as_ref()?)))
            else {
                continue;
            };
            let caster = copy.light.get(LIGHT_LINK).expect("it is linked").include()[0].clone();
            let node = scene.bvh.posed.node_tree().find(&caster).expect("its path");
            let before = picture.of(&[trial.light.light()]);
            let after = picture.of(&[&result.light, &copy.light]);
            let everywhere = picture.of(&[&result.light, &copy.light.clone().with(LIGHT_LINK, None)]);
            let on_caster = |pixels: &[f64]| -> Vec<f64> {
                picture.points.iter().zip(pixels).filter(|(at, _)| at.node == node).map(|(_, light)| *light).collect()
            };
            assert_eq!(on_caster(&after), on_caster(&before), "{}", scene.name);
            let total = |pixels: &[f64]| pixels.iter().sum::<f64>();
            caught += usize::from(total(&everywhere) > total(&after));
            checked += 1;
        }
    }
    assert!(checked >= 3 && caught >= 3, "{checked} {caught}");
}

/// Another feature moves on its surface alone, and the copy keeps all else to the bit.
#[test]
fn a_linked_copy_leaves_all_but_the_surface_of_a_hotspot() {
    let scene = demo();
    let picture = Picture::new(&scene);
    let mut checked = 0;
    for trial in short(&scene, Feature::Hotspot, 6) {
        let all = all_of(&scene, &trial);
        let Some((result, copy)) = of(&all, Alternative::LinkedCopy).and_then(|it| Some((it, it.copy.as_ref()?)))
        else {
            continue;
        };
        let node = scene.seen(trial.drag.from).expect("a surface").node;
        let before = picture.of(&[trial.light.light()]);
        let after = picture.of(&[&result.light, &copy.light]);
        let pixels = picture.points.iter().zip(before.iter().zip(&after));
        let (on, beside): (Vec<_>, Vec<_>) = pixels.partition(|(at, _)| at.node == node);
        assert!(beside.iter().all(|(_, (before, after))| before == after));
        assert!(on.iter().any(|(_, (before, after))| before != after));
        checked += 1;
    }
    assert!(checked >= 3, "{checked}");
}

/// Pins on the caster go with the copy, and those elsewhere stay.
#[test]
fn pins_go_with_what_the_copy_illuminates() {
    let scene = demo();
    let mut trial = scene.trial_of_the_demo(None);
    let pin = |kind, at| DragPin { kind, at, caster: None, is_hard: false };
    let table = scene.seen(DVec2::new(343.0, 330.0)).expect("the table").position + scene.bvh.posed.origin_in_world;
    trial.pins =
        vec![pin(PinKind::Look, PinTarget::Node("blue vase".into())), pin(PinKind::Direction, PinTarget::Point(table))];
    let all = all_of(&scene, &trial);
    let copy = of(&all, Alternative::LinkedCopy).and_then(|it| it.copy.as_ref()).expect("a linked copy");
    assert_eq!(copy.pins, [0]);
}

/// A wall at z = -8, and a pane of a fifth of a unit at z = -2, before a straight light of 5 segments along -Z.
fn pane_before_a_wall() -> (TestScene, CheckedLight) {
    const SEGMENTS: usize = 5;
    let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let primitive = Primitive {
        positions: corners.map(glam::Vec3::from_array).into(),
        normals: vec![glam::Vec3::Z; 4],
        uvs: vec![glam::Vec2::ZERO; 4],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Primitive::default()
    };
    let node = |name: &str, size: f64, z: f64| Node {
        name: name.into(),
        parent: None,
        parent_from_local: DAffine3::from_scale_rotation_translation(
            DVec3::splat(size),
            DQuat::IDENTITY,
            DVec3::new(0.0, 0.0, z),
        ),
        mesh: Some(0),
    };
    let meshes = vec![Mesh { name: "square".into(), primitives: vec![primitive] }];
    let nodes = vec![node("wall", 3.0, -8.0), node("pane", 0.1, -2.0)];
    let scene = Scene { materials: vec![Material::default()], meshes, nodes, ..Scene::default() };
    let camera = Camera {
        name: "beside".into(),
        translation: DVec3::new(2.0, 0.0, -3.0),
        rotation: DQuat::from_rotation_arc(DVec3::NEG_Z, DVec3::new(-2.0, 0.0, -5.0).normalize()),
        projection: Projection::Perspective { yfov: 0.6, aspect_ratio: None, znear: 0.01, zfar: None },
    };
    let bvh = Bvh::new(scene::pose(scene, 0.0));
    let view = Viewport { camera, size: [686, 382] };
    let shares = light::greville_abscissae(SEGMENTS).into_iter().map(|g| g / SEGMENTS as f64);
    let (points, radii) = shares.map(|share| (DVec3::NEG_Z * 8.5 * share, 0.2 + 0.8 * share)).unzip();
    let light = CheckedLight::new(light::Light::bendy(points, radii)).expect("valid");
    (TestScene { name: "pane".into(), bvh, view }, light)
}

/// Control points past the caster leave every light path to the caster as it was. The planted fault is the drag of all
/// points.
#[test]
fn past_the_caster_nothing_before_its_end_moves() {
    let (scene, light) = pane_before_a_wall();
    let from = DVec2::new(343.0, 191.0);
    let on_pane = |light: &light::Light| {
        let light = CheckedLight::new(light.clone()).expect("valid");
        [[0.0, 0.0], [0.1, 0.1], [-0.1, 0.1], [0.1, -0.1], [-0.1, -0.1]]
            .map(|[x, y]| light.tube().expect("bendy").locate(DVec3::new(x, y, -2.0)).point)
    };
    let before = on_pane(light.light());
    assert!(before.iter().all(Option::is_some));
    for direction in 0..6 {
        let to = from + 30.0 * DVec2::from_angle(f64::from(direction));
        let drag = Drag {
            feature: Feature::Shadow,
            choice: None,
            points: None,
            radii: RadiusMode::Keep,
            view: scene.view.clone(),
            from,
            to,
            pins: None,
            source_outside: true,
        };
        let all = all_of(&scene, &Trial { light: light.clone(), drag, pins: Vec::new() });
        let past = of(&all, Alternative::PastCaster).expect("there is room");
        assert_eq!(past.outcome.status, DragStatus::Landed);
        assert_eq!(on_pane(&past.light), before);
        let all_points = of(&all, Alternative::ControlPoints).expect("another picture");
        assert_ne!(on_pane(&all_points.light), before);
    }
    // Both lie in the first segment of a long light: no control point is past the pane alone.
    let near = |z: f64| light.light().clone().map_points(|_, point| point.position.z *= z);
    let drag = Drag {
        feature: Feature::Shadow,
        choice: Some(DragChoice::Only(Alternative::PastCaster)),
        points: None,
        radii: RadiusMode::Keep,
        view: scene.view.clone(),
        from,
        to: from + DVec2::new(30.0, 0.0),
        pins: None,
        source_outside: true,
    };
    let long = CheckedLight::new(near(40.0)).expect("valid");
    let status = scene.run(&Trial { light: long, drag, pins: Vec::new() }).outcome.status;
    assert_eq!(status, DragStatus::Refused(DragRefusal::TooLittleRoom));
}
