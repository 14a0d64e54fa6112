//! Random lights over scenes, and random drags of their features.

use std::path::Path;
use std::sync::Arc;

use drag::{Drag, DragPin, DragResult, Feature, NumberedPin, RadiusMode, Viewport, drag};
use glam::{DAffine3, DQuat, DVec2, DVec3, Vec2, Vec3};
use light::parameters::{END_MODE, ROTATION, SHADOW_LINK, TRANSLATION};
use light::{CheckedLight, EndMode, Light, Links};
use raycast::{Bvh, SeenPoint};
use reference::{LinkedNodes, Reference, ShadedPoint};
use scene::{Camera, Material, Mesh, Node, Primitive, Projection, Scene, ViewRay};

const SIZE: [u32; 2] = [686, 382];

/// Scene and view.
pub struct TestScene {
    pub name: String,
    pub bvh: Bvh,
    pub view: Viewport,
}

/// Light, and a drag of one of its features.
#[derive(Clone)]
pub struct Trial {
    pub light: CheckedLight,
    pub drag: Drag,
    pub pins: Vec<DragPin>,
}

impl Trial {
    /// True if the drag is so short that the light need not move.
    pub fn is_there_already(&self) -> bool {
        self.drag.from.distance(self.drag.to) < 2.0
    }
}

impl TestScene {
    fn new(name: &str, loaded: assets::LoadedScene) -> Self {
        let bvh = Bvh::new(scene::pose(loaded.scene, 0.0));
        let framing = || scene::framing_camera(&bvh.posed.bounds(), 1.8);
        let camera = loaded.contents.cameras.first().cloned().unwrap_or_else(framing);
        Self { name: name.into(), view: Viewport { camera, size: SIZE }, bvh }
    }

    /// Finds the surface in a pixel.
    pub fn seen(&self, pixel: DVec2) -> Option<SeenPoint> {
        let origin = self.bvh.posed.origin_in_world;
        self.bvh.visible_point(&ViewRay::new(&self.view.camera, SIZE, pixel, origin))
    }

    /// Finds the surface in a pixel, with its tube coordinates; `None` outside the light.
    pub fn tube_point(&self, light: &CheckedLight, pixel: DVec2) -> Option<(SeenPoint, light::TubePoint)> {
        let seen = self.seen(pixel)?;
        let point = light.tube()?.locate(seen.position + self.bvh.posed.origin_in_world).point?;
        Some((seen, point))
    }

    /// Finds the point that shadows the surface in a pixel, in scene space.
    pub fn caster_of(&self, light: &CheckedLight, pixel: DVec2) -> Option<DVec3> {
        let (seen, point) = self.tube_point(light, pixel)?;
        let path = self.bvh.bent_path(light.tube()?, point.v, point.w);
        let near = 1e-3 * seen.depth;
        let hit = self.bvh.first_bent_hit(&path, point.t, |hit| hit.position.distance(seen.position) > near)?;
        Some(hit.position)
    }

    /// Makes the drag of docs/command-line.md: the shadow of the blue vase's neck moves down the table, by three
    /// control points of the demo's light.
    pub fn trial_of_the_demo(&self, shadow_link: Option<Links>) -> Trial {
        let demo = assets::demo("vases").expect("it is one of the demos");
        let light = demo.contents.lights[0].light().clone().with(SHADOW_LINK, shadow_link);
        let drag = Drag {
            feature: Feature::Shadow,
            points: Some(vec![2, 3, 4]),
            radii: RadiusMode::Keep,
            view: Viewport { size: [640, 360], ..self.view.clone() },
            from: DVec2::new(430.5, 265.5),
            to: DVec2::new(430.5, 310.5),
            pins: None,
            source_outside: false,
            choice: None,
        };
        Trial { light: CheckedLight::new(light).expect("valid"), drag, pins: Vec::new() }
    }

    pub fn run(&self, trial: &Trial) -> DragResult {
        drag(&self.bvh, &trial.light, &trial.drag, &NumberedPin::by_index(trial.pins.clone()))
    }

    pub fn reference(&self) -> Reference {
        Reference::new(Arc::clone(&self.bvh.posed))
    }

    /// Finds a pixel whose surface is outside the light.
    pub fn outside(&self, light: &CheckedLight) -> DVec2 {
        let mut random = Random(3);
        loop {
            let pixel = random.pixel();
            if self.seen(pixel).is_some() && self.tube_point(light, pixel).is_none() {
                return pixel;
            }
        }
    }
}

pub fn demo() -> TestScene {
    TestScene::new("demo:vases", assets::demo("vases").expect("it is one of the demos"))
}

/// Returns the demo, and other scenes if their files exist.
pub fn scenes() -> Vec<TestScene> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets/scenes");
    let mut scenes = vec![demo()];
    for name in ["vases_bowl", "bedroom", "outdoor"] {
        let file = folder.join(format!("{name}.glb"));
        if file.is_file() {
            scenes.push(TestScene::new(name, assets::load(&file).expect("a sound file")));
        } else {
            eprintln!("skipped {name}: {} is missing", file.display());
        }
    }
    scenes
}

/// Finds the node that shadows a surface point in a bent light without links. `None` outside the light.
pub fn shadowing_node(reference: &Reference, light: &CheckedLight, surface: &ShadedPoint) -> Option<usize> {
    let position = surface.position + reference.bvh.posed.origin_in_world;
    let tube = light.tube()?;
    reference.occluding_node(tube, &LinkedNodes::default(), &tube.locate(position).point?, position)
}

/// Returns scenes that the solver's settings were not chosen by: the second demo, and [`pillars`].
pub fn unseen_scenes() -> [TestScene; 2] {
    [TestScene::new("demo:arbor", assets::demo("arbor").expect("it is one of the demos")), pillars()]
}

/// Makes a square with eight pillars and a low wall.
fn pillars() -> TestScene {
    let square = [GROUND, ("wall", [0.0, 0.4, -5.0], [12.0, 0.8, 0.3])];
    let square = square.map(|(name, at, size)| (name.to_owned(), DVec3::from(at), DVec3::from(size)));
    let pillar = |k: usize| {
        let height = 1.0 + 0.35 * k as f64;
        let at = DVec3::new(2.4 * (k % 4) as f64 - 3.6, 0.5 * height, 3.0 * (k / 4) as f64 - 2.0);
        (format!("pillar {k}"), at, DVec3::new(0.5, height, 0.5))
    };
    boxes("pillars", square.into_iter().chain((0..8).map(pillar)))
}

/// Makes the ground of that square alone.
pub fn ground() -> TestScene {
    let (name, at, size) = GROUND;
    boxes("ground", [(name.to_owned(), at.into(), size.into())])
}

const GROUND: (&str, [f64; 3], [f64; 3]) = ("ground", [0.0, -0.5, 0.0], [16.0, 1.0, 16.0]);

/// Makes a scene of boxes with these names, centers and sizes, seen from above.
fn boxes(name: &str, boxes: impl IntoIterator<Item = (String, DVec3, DVec3)>) -> TestScene {
    let nodes = boxes.into_iter().map(|(name, at, size)| Node {
        name,
        parent: None,
        parent_from_local: DAffine3::from_scale_rotation_translation(size, DQuat::IDENTITY, at),
        mesh: Some(0),
    });
    let meshes = vec![Mesh { name: "box".into(), primitives: vec![unit_box()] }];
    let scene = Scene { materials: vec![Material::default()], meshes, nodes: nodes.collect(), ..Scene::default() };
    let camera = Camera {
        name: "above".into(),
        translation: DVec3::new(2.0, 5.0, 9.0),
        rotation: DQuat::from_rotation_y(0.219) * DQuat::from_rotation_x(-0.454),
        projection: Projection::Perspective { yfov: 0.7, aspect_ratio: None, znear: 0.01, zfar: None },
    };
    TestScene { name: name.into(), bvh: Bvh::new(scene::pose(scene, 0.0)), view: Viewport { camera, size: SIZE } }
}

/// Makes a box of one unit about the origin.
fn unit_box() -> Primitive {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    let sides = (0..6).map(|side| {
        let normal = axes[side % 3] * if side < 3 { 1.0 } else { -1.0 };
        let across = axes[(side + 1) % 3];
        (normal, across, normal.cross(across))
    });
    let mut primitive = Primitive::default();
    for (normal, across, up) in sides {
        let first = primitive.positions.len() as u32;
        for (a, b) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)] {
            primitive.positions.push(normal * 0.5 + across * a + up * b);
            primitive.normals.push(normal);
            primitive.uvs.push(Vec2::ZERO);
        }
        primitive.indices.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
    }
    primitive
}

/// Yields `count` drags of a feature, each with its own light. Every other one moves the light as a whole, the rest
/// bend it. Half of them cover a few pixels, half of them any distance.
pub fn trials(scene: &TestScene, feature: Feature, count: usize) -> impl Iterator<Item = Trial> + '_ {
    let mut random = Random(11 + feature as u64);
    let mut found = 0;
    std::iter::from_fn(move || {
        while found < count {
            let (deforms, is_large) = (found % 2 == 1, found % 4 >= 2);
            if let Some(trial) = trial(scene, &mut random, feature, deforms, is_large) {
                found += 1;
                return Some(trial);
            }
        }
        None
    })
}

fn trial(scene: &TestScene, random: &mut Random, feature: Feature, deforms: bool, is_large: bool) -> Option<Trial> {
    let aim = scene.seen(random.pixel())?;
    let extent = scene.bvh.posed.half_extent.length().min(1.5 * aim.depth);
    let light = random.light(aim.position + scene.bvh.posed.origin_in_world, extent)?;
    let from = begin(scene, random, &light, feature)?;
    let to = if is_large { random.pixel() } else { from + random.vector().truncate() * 38.0 };
    scene.tube_point(&light, to)?;
    let last = light.light().points().len();
    let points =
        deforms.then(|| if random.between(0.0, 1.0) < 0.5 { vec![last - 2, last - 1] } else { (1..last).collect() });
    let (view, radii) = (scene.view.clone(), RadiusMode::Keep);
    let drag = Drag { feature, points, radii, view, from, to, pins: None, source_outside: false, choice: None };
    Some(Trial { light, drag, pins: Vec::new() })
}

/// Finds a pixel that has the feature, nearly enough.
fn begin(scene: &TestScene, random: &mut Random, light: &CheckedLight, feature: Feature) -> Option<DVec2> {
    let off = |pixel: DVec2| {
        let (seen, point) = scene.tube_point(light, pixel)?;
        let target = match feature {
            Feature::Shadow => {
                let path = scene.bvh.bent_path(light.tube()?, point.v, point.w);
                let near = 1e-6 * seen.depth;
                let is_shadowed =
                    scene.bvh.has_bent_hit(&path, point.t, |hit| hit.position.distance(seen.position) > near);
                return is_shadowed.then_some(0.0);
            }
            Feature::Hotspot => return Some(0.0),
            Feature::Highlight => seen.normal * (2.0 * seen.normal.dot(seen.to_eye)) - seen.to_eye,
            Feature::Diffuse => seen.normal,
        };
        Some(point.direction.distance(target))
    };
    let pixels = (0..200).map(|_| random.pixel()).collect::<Vec<_>>();
    let offs = pixels.into_iter().filter_map(|pixel| Some((off(pixel)?, pixel)));
    let (off, pixel) = offs.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (off < 0.06).then_some(pixel)
}

/// Linear congruential generator (Knuth's MMIX), random enough for trials.
pub struct Random(pub u64);

impl Random {
    pub fn between(&mut self, a: f64, b: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        a + (b - a) * (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn pixel(&mut self) -> DVec2 {
        let [width, height] = SIZE.map(f64::from);
        DVec2::new(self.between(0.0, width), self.between(0.0, height))
    }

    fn vector(&mut self) -> DVec3 {
        let vector = DVec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0));
        if vector.length_squared() <= 1.0 { vector } else { self.vector() }
    }

    /// Makes a light from above on `aim`, at a distance of about `size`, with one to four segments and a random bend.
    fn light(&mut self, aim: DVec3, size: f64) -> Option<CheckedLight> {
        let vector = self.vector();
        let back = DVec3::new(vector.x, vector.y.abs().max(0.3), vector.z).normalize();
        let source = aim + back * size * self.between(0.6, 1.2);
        let length = 1.3 * source.distance(aim);
        let segments = 1 + self.between(0.0, 4.0) as usize;
        let bend = self.between(0.0, 0.35) * length;
        let wide = self.between(0.08, 0.3) * length;
        let along = light::greville_abscissae(segments).into_iter().map(|g| g / segments as f64);
        let (points, radii) = along
            .map(|g| {
                let aside = if g > 0.0 { self.vector() * (bend * g) } else { DVec3::ZERO };
                (DVec3::new(0.0, 0.0, -g * length) + aside, wide * (0.1 + 0.9 * g))
            })
            .unzip();
        let light = Light::bendy(points, radii).with(TRANSLATION, source).with(END_MODE, EndMode::Extend);
        CheckedLight::new(light.with(ROTATION, DQuat::from_rotation_arc(DVec3::NEG_Z, -back))).ok()
    }
}
