//! Small scenes with known results, and the device that all tests share.

use std::sync::{Mutex, OnceLock, PoisonError};

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use light::parameters::INTENSITY;
use light::{Light, LightInstance, Transform};
use render::{Aov, Backend, Device, Host, MemoryBudget, PassCounts, Picture, Renderer, ShadowSettings, View};
use scene::{Camera, Material, Mesh, Node, Primitive, Projection, Scene};

/// 2^-24: half an ulp of 1 in f32.
pub const EPS: f64 = f64::EPSILON * 268_435_456.0;

pub const BACKENDS: [Backend; 2] = [Backend::Wgpu, Backend::Native];

/// Returns the shared device, with lights drawn by `backend`.
pub fn device_of(backend: Backend) -> Device {
    static DEVICES: [OnceLock<Device>; 2] = [const { OnceLock::new() }; 2];
    let open = || Device::open(Host::default(), Some(backend)).expect("tests need a graphics driver");
    DEVICES[backend as usize].get_or_init(open).clone()
}

/// Returns the settings that draw straight BendyLights with bent maps: tests compare them with spotlights.
pub fn unstraightened() -> ShadowSettings {
    ShadowSettings { straighten: false, ..ShadowSettings::default() }
}

/// Returns a renderer of `scene`, with those settings.
pub fn renderer(scene: &Scene) -> Renderer {
    renderer_of(Backend::Wgpu, scene)
}

/// Returns a renderer of `scene` with those settings, on `backend`. All share their pipelines: compiling takes longer
/// than drawing.
pub fn renderer_of(backend: Backend, scene: &Scene) -> Renderer {
    static FIRST: [OnceLock<Mutex<Renderer>>; 2] = [const { OnceLock::new() }; 2];
    let first = || Mutex::new(Renderer::new(&device_of(backend)).expect("the device works"));
    let first = FIRST[backend as usize].get_or_init(first).lock().unwrap_or_else(PoisonError::into_inner);
    with_scene(first.with_same_pipelines().expect("the device works"), scene)
}

/// Returns a renderer of `scene` with those settings, on a device of its own, whose data counts against `memory`.
pub fn renderer_within(memory: &MemoryBudget, backend: Backend, scene: &Scene) -> Renderer {
    let device = Device::open(Host::new(memory.clone()), Some(backend)).expect("tests need a graphics driver");
    assert_eq!(device.backend(), backend);
    renderer_on(&device, scene)
}

/// Returns a renderer of `scene` with those settings, on that device.
pub fn renderer_on(device: &Device, scene: &Scene) -> Renderer {
    with_scene(Renderer::new(device).expect("the device works"), scene)
}

fn with_scene(mut renderer: Renderer, scene: &Scene) -> Renderer {
    scene.check().expect("test scenes keep their promises");
    renderer.set_shadow_settings(unstraightened()).expect("sound");
    renderer.set_scene(&scene::pose(scene.clone(), 0.0)).expect("test scenes fit");
    renderer
}

/// Returns a picture of `scene`, from a renderer that all tests share.
pub fn picture(scene: &Scene, view: &View, lights: &[Light]) -> Picture {
    static SHARED: OnceLock<Mutex<Renderer>> = OnceLock::new();
    scene.check().expect("test scenes keep their promises");
    let shared = SHARED.get_or_init(|| Mutex::new(renderer(&Scene::default())));
    // A test that failed with the lock held has left nothing incomplete: drawing restarts with the scene.
    let mut shared = shared.lock().unwrap_or_else(PoisonError::into_inner);
    shared.set_scene(&scene::pose(scene.clone(), 0.0)).expect("test scenes fit");
    let picture = shared.render(view, &instances(lights)).expect("test pictures can be made");
    assert!(picture.pixels.iter().flatten().all(|x| x.is_finite()), "{:?} holds NaN or infinity", view.aov);
    picture
}

/// Returns a square from -1 to 1 in the plane y = 0 that faces up.
pub fn square() -> Primitive {
    Primitive {
        positions: [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, z)| Vec3::new(x, 0.0, z)).into(),
        normals: vec![Vec3::Y; 4],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Primitive::default()
    }
}

/// Returns a scene of meshes, each with its transform; without fill.
pub fn scene_of(parts: impl IntoIterator<Item = (Primitive, DAffine3)>, materials: Vec<Material>) -> Scene {
    let mut scene = Scene { materials, ..Scene::default() };
    scene.fill.sky = DVec3::ZERO;
    scene.fill.ground = DVec3::ZERO;
    for (primitive, world_from_local) in parts {
        let (name, mesh) = (String::new(), Some(scene.meshes.len()));
        scene.meshes.push(Mesh { name: name.clone(), primitives: vec![primitive] });
        scene.nodes.push(Node { name, parent: None, parent_from_local: world_from_local, mesh });
    }
    scene
}

/// Returns a square scaled by `half`, at `height`, in a white and rough material.
pub fn floor(half: f64, height: f64) -> (Primitive, DAffine3) {
    let placement = DAffine3::from_scale_rotation_translation(DVec3::splat(half), DQuat::IDENTITY, DVec3::Y * height);
    (square(), placement)
}

/// Returns a large table, and a smaller one above it.
pub fn tables() -> Scene {
    scene_of([floor(3.0, 0.0), floor(0.5, 1.0)], vec![Material::default()])
}

/// Returns a white floor from -1 to 1 that returns the fill, which is `color` from everywhere.
pub fn filled(color: DVec3) -> Scene {
    let mut scene = scene_of([floor(1.0, 0.0)], vec![Material::default()]);
    (scene.fill.sky, scene.fill.ground) = (color, color);
    scene
}

/// Returns a ball of radius 1 with its own normals, `n` facets from pole to pole and twice as many around.
pub fn ball(n: u32) -> Primitive {
    let around = 2 * n;
    let at = |k: u32| {
        let theta = std::f64::consts::PI * f64::from(k / (around + 1)) / f64::from(n);
        let phi = std::f64::consts::TAU * f64::from(k % (around + 1)) / f64::from(around);
        DVec3::new(theta.sin() * phi.cos(), theta.cos(), -theta.sin() * phi.sin()).as_vec3()
    };
    let positions: Vec<Vec3> = (0..(n + 1) * (around + 1)).map(at).collect();
    let quads = (0..n * around).map(|k| k / around * (around + 1) + k % around);
    let indices = quads.flat_map(|k| [k, k + around + 1, k + 1, k + 1, k + around + 1, k + around + 2]).collect();
    Primitive { normals: positions.clone(), positions, indices, ..Primitive::default() }
}

/// Axes that look from `eye` to `target`, with -z forward.
pub fn looking(eye: DVec3, target: DVec3) -> DMat3 {
    let back = (eye - target).normalize();
    let right = if back.cross(DVec3::Y).length() < 1e-9 { DVec3::X } else { DVec3::Y.cross(back).normalize() };
    DMat3::from_cols(right, back.cross(right), back)
}

/// Returns a view of `size` pixels from `eye` to `target`, 0.8 rad high.
pub fn view(eye: DVec3, target: DVec3, size: [u32; 2], aov: Aov) -> View {
    let camera = Camera {
        name: String::new(),
        translation: eye,
        rotation: DQuat::from_mat3(&looking(eye, target)),
        projection: Projection::Perspective { yfov: 0.8, aspect_ratio: None, znear: 0.05, zfar: None },
    };
    View { aov, ..View::beauty(camera, size) }
}

/// Returns a view of `size` pixels from beside and above the middle of the scene.
pub fn oblique(size: [u32; 2], aov: Aov) -> View {
    view(DVec3::new(2.0, 3.0, 4.0), DVec3::ZERO, size, aov)
}

/// Returns a spotlight of 10 cd and 25 degrees from `source` to `target`.
pub fn spot(source: DVec3, target: DVec3) -> Light {
    let rotation = DQuat::from_mat3(&looking(source, target));
    Light::spot().with_transform(Transform { translation: source, rotation, scale: 1.0 }).with(INTENSITY, 10.0)
}

/// Returns the lights as a renderer takes them: checked, and numbered from 0.
pub fn instances(lights: &[Light]) -> Vec<LightInstance> {
    LightInstance::numbered(lights.to_vec()).expect("lights")
}

/// Returns the origin and direction of the ray through the center of a pixel; the direction is 1 long along the view
/// axis.
pub fn ray_in_world(view: &View, x: usize, y: usize) -> (DVec3, DVec3) {
    let ndc_x = (2 * x + 1) as f64 / f64::from(view.width) - 1.0;
    let ndc_y = 1.0 - (2 * y + 1) as f64 / f64::from(view.height);
    let aspect = f64::from(view.width) / f64::from(view.height);
    let DAffine3 { matrix3: axes, translation: eye } = view.camera.world_from_camera();
    match view.camera.projection {
        Projection::Perspective { yfov, .. } => {
            let half = (yfov / 2.0).tan();
            (eye, axes * DVec3::new(ndc_x * half * aspect, ndc_y * half, -1.0))
        }
        Projection::Orthographic { ymag, .. } => {
            (eye + axes * DVec3::new(ndc_x * ymag * aspect, ndc_y * ymag, 0.0), -axes.z_axis)
        }
    }
}

/// Returns each pixel with the point of the plane `normal . p = offset` that its ray meets in front of the camera.
pub fn on_plane<'a>(
    picture: &'a Picture,
    view: &'a View,
    normal: DVec3,
    offset: f64,
) -> impl Iterator<Item = (DVec3, [f64; 4])> + 'a {
    let width = picture.width as usize;
    picture.pixels.iter().enumerate().filter_map(move |(i, pixel)| {
        let (origin, direction) = ray_in_world(view, i % width, i / width);
        let depth = (offset - normal.dot(origin)) / normal.dot(direction);
        (depth > 0.0 && depth.is_finite()).then(|| (origin + direction * depth, pixel.map(f64::from)))
    })
}

pub fn since(before: PassCounts, after: PassCounts) -> PassCounts {
    PassCounts {
        gbuffer: after.gbuffer - before.gbuffer,
        shadow: after.shadow - before.shadow,
        lighting: after.lighting - before.lighting,
        layers: after.layers - before.layers,
        display: after.display - before.display,
    }
}
