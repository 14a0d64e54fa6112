//! Compares bent shadows with the traced paths of `walk.rs`, pixel by pixel, and plants faults.
//!
//! Pictures and counts here hold for both backends; `tests/device.rs` tests features of the wgpu backend alone.

mod culling;
mod device;

use std::sync::{Mutex, OnceLock, PoisonError};

use glam::{DAffine3, DQuat, DVec3, Vec3};
use light::parameters::{CONE_ANGLE, DECAY, DIRECTION, RANGE, ROTATION, TRANSLATION};
use light::{Decay, DirectionMode, Light, LightInstance, Tube};
use scene::{Camera, Material, Mesh, Node, PosedPrimitive, Primitive, Projection, Scene, pose};

use super::walk;
use crate::{Aov, Backend, Culling, Device, FrameStage, Host, Picture, Renderer, ShadowFilter, ShadowSettings, View};

/// Settings without edge splitting.
pub(crate) const UNSPLIT: ShadowSettings = ShadowSettings {
    resolution: 2048,
    edge_error_texels: None,
    filter: ShadowFilter::Bilinear,
    mesh_error: 0.0,
    straighten: false,
    culling: Culling::ALL,
};

/// Returns a light from 4 units up that turns by 70 degrees and slightly back: three strongly bent segments.
pub(crate) fn light() -> Light {
    let points = [(0., 0., 0.), (0.3, 0.1, -1.2), (-0.2, 0.4, -2.6), (1.9, -0.2, -3.3), (3.1, 0.3, -4.6)];
    let points = points.map(|(x, y, z)| DVec3::new(x, y, z)).to_vec();
    Light::bendy(points, vec![0.15, 0.35, 0.45, 0.5, 0.8])
        .with(TRANSLATION, DVec3::new(-1.0, 4.0, 0.0))
        .with(ROTATION, DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2))
}

/// Returns a box from -1 to 1.
pub(crate) fn cube() -> Primitive {
    let corner = |k: u32| Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2 & 1) as f32) * 2.0 - 1.0;
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut primitive = Primitive::default();
    for face in faces {
        let [a, b, c, d] = face.map(corner);
        let first = primitive.positions.len() as u32;
        primitive.positions.extend([a, b, c, d]);
        primitive.normals.extend([(b - a).cross(c - a).normalize(); 4]);
        primitive.indices.extend([0, 1, 2, 0, 2, 3].map(|k| first + k));
    }
    primitive
}

/// Adds a mesh of one primitive, with its transform.
pub(crate) fn add_mesh(scene: &mut Scene, primitive: Primitive, parent_from_local: DAffine3) {
    let (name, mesh) = (String::new(), Some(scene.meshes.len()));
    scene.meshes.push(Mesh { name: name.clone(), primitives: vec![primitive] });
    scene.nodes.push(Node { name, parent: None, parent_from_local, mesh });
}

/// Returns a floor of two large triangles and three long boxes in the light. Every edge is longer than the tube is
/// wide.
fn scene() -> Scene {
    let place = |scale: (f64, f64, f64), turn: f64, at: (f64, f64, f64)| {
        let vector = |(x, y, z)| DVec3::new(x, y, z);
        DAffine3::from_scale_rotation_translation(vector(scale), DQuat::from_rotation_y(turn), vector(at))
    };
    let parts = [
        place((8.0, 0.1, 8.0), 0.0, (0.0, -0.6, 0.0)),
        place((2.0, 0.04, 0.12), 0.5, (-0.8, 2.4, -0.3)),
        place((0.12, 0.05, 2.5), 0.3, (0.1, 1.1, -0.4)),
        place((0.1, 0.7, 0.1), 0.9, (1.0, 0.2, -0.6)),
    ];
    let mut scene = Scene { materials: vec![Material::default()], ..Scene::default() };
    for placement in parts {
        add_mesh(&mut scene, cube(), placement);
    }
    scene.check().expect("sound");
    scene
}

pub(crate) fn view(aov: Aov) -> View {
    let eye = DVec3::new(-1.5, 4.5, 6.0);
    let back = (eye - DVec3::new(0.5, 0.0, 0.0)).normalize();
    let right = DVec3::Y.cross(back).normalize();
    let matrix3 = glam::DMat3::from_cols(right, back.cross(right), back);
    let camera = Camera {
        name: String::new(),
        translation: eye,
        rotation: glam::DQuat::from_mat3(&matrix3),
        projection: Projection::Perspective { yfov: 0.7, aspect_ratio: None, znear: 0.1, zfar: None },
    };
    View { aov, ..View::beauty(camera, [240, 160]) }
}

/// Returns the world position of a pixel, from its depth AOV.
pub(crate) fn position(view: &View, depth: &Picture, pixel: usize) -> DVec3 {
    let (x, y) = ((pixel % 240) as f64, (pixel / 240) as f64);
    let half = 0.35_f64.tan();
    let ndc = ((x + 0.5) / 120.0 - 1.0, 1.0 - (y + 0.5) / 80.0);
    let ray = DVec3::new(ndc.0 * half * 1.5, ndc.1 * half, -1.0);
    view.camera.world_from_camera().transform_point3(ray * f64::from(depth.pixels[pixel][0]))
}

pub(crate) const BACKENDS: [Backend; 2] = [Backend::Wgpu, Backend::Native];

/// Returns a wgpu-backend renderer on the device that all tests of this binary share.
///
/// It draws straight BendyLights with bent maps, too.
pub(crate) fn renderer(scene: &Scene) -> Renderer {
    renderer_of(Backend::Wgpu, scene)
}

/// Returns a renderer with shadows and lights drawn by `backend`. All share their pipelines: compiling takes longer than
/// drawing.
pub(crate) fn renderer_of(backend: Backend, scene: &Scene) -> Renderer {
    static FIRST: [OnceLock<Mutex<Renderer>>; 2] = [const { OnceLock::new() }; 2];
    let first = FIRST[backend as usize].get_or_init(|| {
        let device = Device::open(Host::default(), Some(backend)).expect("tests need a graphics driver");
        Mutex::new(Renderer::new(&device).expect("the device works"))
    });
    let first = first.lock().unwrap_or_else(PoisonError::into_inner);
    let mut renderer = first.with_same_pipelines().expect("the device works");
    renderer.set_shadow_settings(ShadowSettings { straighten: false, ..ShadowSettings::default() }).expect("sound");
    renderer.set_scene(&scene::pose(scene.clone(), 0.0)).expect("fits");
    renderer
}

/// Returns `light` as the only one of a picture.
pub(crate) fn alone(light: &Light) -> Vec<LightInstance> {
    LightInstance::numbered([light.clone()]).expect("a light")
}

/// Floor and boxes under the light.
pub(crate) struct Setup {
    pub tube: Tube<f64>,
    /// Positions in tube space.
    pub triangles: Vec<[DVec3; 3]>,
    pub lights: Vec<LightInstance>,
    pub renderer: Renderer,
}

impl Setup {
    pub fn new(backend: Backend) -> Self {
        let (scene, light) = (scene(), light());
        let tube = Tube::new(&light).expect("valid");
        let renderer = renderer_of(backend, &scene);
        let posed = pose(scene, 0.0);
        let corners = |primitive: &PosedPrimitive| {
            let first = primitive.first_vertex;
            let corner = |k: u32| {
                let in_world = posed.origin_in_world + posed.positions[first + k as usize];
                tube.placement.tube_from_world(in_world)
            };
            posed.triangles(primitive).map(|triangle| triangle.map(corner)).collect::<Vec<_>>()
        };
        let triangles = posed.primitives.iter().flat_map(corners).collect();
        Self { tube, triangles, lights: alone(&light), renderer }
    }

    pub fn picture(&mut self, aov: Aov) -> Picture {
        self.renderer.render(&view(aov), &self.lights).expect("drawn")
    }

    /// Returns the surface points that pixels see in the light, with pixel and (t, v, w). w is multiplied by `w_sign`.
    /// Triangles in the receiver's own plane are left out, since they do not shadow it.
    pub fn pixels_in_light(&mut self, w_sign: f64) -> Vec<PixelInLight> {
        let depth = self.picture(Aov::Depth);
        let see = |pixel: usize| {
            let q = self.tube.placement.tube_from_world(position(&view(Aov::Depth), &depth, pixel));
            let root = self.tube.nearest_root(q).filter(|_| depth.pixels[pixel][3] > 0.0)?;
            let plane_distance = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).normalize().dot(q - a).abs();
            let others = self.triangles.iter().copied().filter(|&t| plane_distance(t) > 1e-5).collect();
            let (v, w) = (root.v_len / root.radius, w_sign * root.w_len / root.radius);
            Some(PixelInLight { pixel, path: [root.segment as f64 + root.u, v, w], others })
        };
        (0..depth.pixels.len()).filter_map(see).collect()
    }

    /// Returns the pixels at least two texels from any shadow edge on a map of `resolution`, each with true if the
    /// traced path is lit. `w_sign` is 1, or -1 for a deliberate fault.
    pub fn traced_pixels(&mut self, w_sign: f64, resolution: u32) -> Vec<(usize, bool)> {
        let texels = 2.0 * 2.0 / f64::from(resolution);
        let seen = self.pixels_in_light(w_sign);
        let judged = |seen: &PixelInLight| {
            let at = |v: f64, w: f64| seen.is_lit(&self.tube, [v * texels, w * texels]);
            let lit = at(0.0, 0.0);
            let around =
                [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.0, -1.0)];
            around.iter().all(|&(v, w)| at(v, w) == lit).then_some((seen.pixel, lit))
        };
        seen.iter().filter_map(judged).collect()
    }
}

/// A surface point in the light that a pixel sees.
pub(crate) struct PixelInLight {
    pub pixel: usize,
    path: [f64; 3],
    /// Triangles that may shadow it.
    others: Vec<[DVec3; 3]>,
}

impl PixelInLight {
    /// True if the traced path offset by `[dv, dw]` reaches the point.
    pub fn is_lit(&self, tube: &Tube<f64>, [dv, dw]: [f64; 2]) -> bool {
        let [t, v, w] = self.path;
        walk::reaches(tube, &self.others, t, v + dv, w + dw)
    }
}

/// Returns the number of pixels on which a visibility AOV differs from the traced paths.
pub(crate) fn differing(walked: &[(usize, bool)], visibility: &Picture) -> usize {
    walked.iter().filter(|(pixel, lit)| visibility.pixels[*pixel][0] != f32::from(u8::from(*lit))).count()
}

/// Every pixel agrees. A frame with the wrong sign of w, or a map without edge splitting, does not.
#[test]
fn bent_shadows_are_where_the_paths_say() {
    // The GPU draws depths with either backend.
    let [walked, mirrored] =
        [1.0, -1.0].map(|w_sign| Setup::new(Backend::Wgpu).traced_pixels(w_sign, ShadowSettings::default().resolution));
    let lit = walked.iter().filter(|(_, lit)| *lit).count();
    assert!(walked.len() >= 500 && lit > 100 && walked.len() - lit > 100, "{lit} of {} lit", walked.len());
    for backend in BACKENDS {
        let mut setup = Setup::new(backend);
        let visibility = setup.picture(Aov::Visibility);
        let wrong: Vec<_> = walked.iter().filter(|w| differing(&[**w], &visibility) > 0).collect();
        assert!(wrong.is_empty(), "{backend:?}: {} of {} differ: {wrong:?}", wrong.len(), walked.len());

        // Deliberate fault that the check must detect: a sign error in w.
        let fault = differing(&mirrored, &visibility);
        assert!(fault > walked.len() / 50, "{backend:?}: a sign error in w changes only {fault} pixels");

        // Deliberate fault that the check must detect: edges that are never split.
        setup.renderer.set_shadow_settings(UNSPLIT).expect("sound");
        let fault = differing(&walked, &setup.picture(Aov::Visibility));
        assert!(fault > 0, "{backend:?}: unsplit edges went unseen");
    }
}

/// Returns spotlights bent into 1 to 8 segments, increasingly; lights that would fold are left out.
fn bent_spots() -> Vec<Light> {
    let spot = Light::spot().with(CONE_ANGLE, 22.0).with(RANGE, Some(11.0)).with(DECAY, Decay::None);
    let mut lights = Vec::new();
    for (segments, amount) in [1, 2, 3, 5, 8].into_iter().flat_map(|n| [0.5, 1.0, 2.0, 3.0].map(|a| (n, a))) {
        let back = (DVec3::new(-3.0, 7.0, 2.0) - DVec3::X).normalize();
        let right = DVec3::Y.cross(back).normalize();
        let rotation = DQuat::from_mat3(&glam::DMat3::from_cols(right, back.cross(right), back));
        let light = light::bend(&spot, segments)
            .expect("valid")
            .with(TRANSLATION, DVec3::new(-3.0, 7.0, 2.0))
            .with(ROTATION, rotation);
        let last = (light.points().len() - 1) as f64;
        let light = light.map_points(|i, point| point.position.x += amount * (i as f64 / last).powi(2));
        let uneven = light.clone().map_points(|_, point| point.radius = 1.5 + (2.0 * point.position.z).sin());
        lights.extend([uneven, light]);
    }
    lights.retain(|light| Tube::new(light).is_ok());
    lights
}

/// Returns the number of shadowed pixels of a single plane, among those that light reaches at more than 6 degrees.
fn self_shadowed(renderer: &mut Renderer, light: &Light) -> usize {
    let lights = alone(light);
    let mut picture = |aov| {
        let mut view = view(aov);
        view.camera.translation *= 2.0;
        renderer.render(&view, &lights).expect("drawn")
    };
    let (visibility, direction) = (picture(Aov::Visibility), picture(Aov::Direction));
    let pixels = visibility.pixels.iter().zip(&direction.pixels);
    pixels.filter(|(v, d)| v[3] == 1.0 && v[0] < 1.0 && d[1] > 0.1).count()
}

/// A plane without anything above it is lit wherever the light reaches, at joints and slabs, with every taper. Without
/// edge splitting it is not.
#[test]
fn a_lone_plane_never_shadows_itself() {
    let mut scene = scene();
    scene.nodes.truncate(1);
    // Only its top.
    let floor = &mut scene.meshes[0].primitives[0];
    let tops = floor.indices.chunks(3).filter(|t| floor.normals[t[0] as usize].y > 0.5).flatten();
    floor.indices = tops.copied().collect();
    assert_eq!(floor.indices.len(), 6);

    let modes = [DirectionMode::Tube, DirectionMode::Path];
    let lights = bent_spots().into_iter().flat_map(|light| modes.map(|mode| light.clone().with(DIRECTION, mode)));
    let lights: Vec<_> = lights.collect();
    assert!(lights.len() >= 30, "{}", lights.len());
    for backend in BACKENDS {
        let mut renderer = renderer_of(backend, &scene);
        for light in &lights {
            let shadowed = self_shadowed(&mut renderer, light);
            assert_eq!(shadowed, 0, "{backend:?}: {:?}", light.points());
        }
        renderer.set_shadow_settings(UNSPLIT).expect("sound");
        let fault = self_shadowed(&mut renderer, &lights[lights.len() - 1]);
        assert!(fault > 0, "{backend:?}: unsplit edges went unseen");
    }
}

/// With any resolution and filter, a single plane stays lit. Settings that allow no map are refused.
#[test]
fn every_setting_leaves_a_lone_plane_lit() {
    let mut scene = scene();
    scene.nodes.truncate(1);
    let light = &bent_spots()[1];
    let maps = [(256, Some(0.4)), (2048, Some(0.1)), (2048, Some(2.0))];
    for backend in BACKENDS {
        let mut renderer = renderer_of(backend, &scene);
        for (filter, (resolution, edge_error_texels)) in
            ShadowFilter::ALL.into_iter().flat_map(|filter| maps.map(|map| (filter, map)))
        {
            let settings = ShadowSettings { resolution, edge_error_texels, filter, ..ShadowSettings::default() };
            renderer.set_shadow_settings(settings).expect("sound");
            assert_eq!(self_shadowed(&mut renderer, light), 0, "{backend:?}: {settings:?}");
        }
    }
    let mut renderer = renderer(&scene);
    let default = ShadowSettings::default();
    for refused in [
        ShadowSettings { resolution: 4, ..default },
        ShadowSettings { resolution: 1 << 20, ..default },
        ShadowSettings { edge_error_texels: Some(f32::NAN), ..default },
        ShadowSettings { mesh_error: f64::NAN, ..default },
        ShadowSettings { mesh_error: f64::INFINITY, ..default },
        ShadowSettings { mesh_error: -1e-9, ..default },
    ] {
        renderer.set_shadow_settings(refused).expect_err("no map can be made of it");
    }
}

/// Other settings draw the view again; the same settings draw nothing.
#[test]
fn settings_draw_anew() {
    for mut setup in BACKENDS.map(Setup::new) {
        let fine = setup.picture(Aov::Visibility);
        let coarse = ShadowSettings { resolution: 64, ..ShadowSettings::default() };
        setup.renderer.set_shadow_settings(coarse).expect("sound");
        assert_ne!(setup.picture(Aov::Visibility), fine);
        let drawn = setup.renderer.counts().shadow;
        setup.renderer.set_shadow_settings(coarse).expect("sound");
        setup.picture(Aov::Visibility);
        assert_eq!(setup.renderer.counts().shadow, drawn);
        setup.renderer.set_shadow_settings(ShadowSettings::default()).expect("sound");
        assert_eq!(setup.picture(Aov::Visibility), fine);
    }
}

/// A frame recorded stage by stage equals the frame without recording. Each stage runs once, and cached results record
/// no stage.
#[test]
fn a_frame_by_stages_is_the_frame() {
    use FrameStage::{Clip, Counts, Display, Fill, Readback, Sum, Surfaces};
    // Few lights need no sums. The GPU lights the pixels that it draws. The CPU clips and draws in one stage, adds the
    // fill on display, and needs no readback.
    let cases: [(_, &[_], &[_]); 2] = [
        (Backend::Wgpu, &[Sum, Surfaces], &[Display, Readback]),
        (Backend::Native, &[Sum, Clip, Counts, Fill, Readback], &[Display]),
    ];
    for (backend, not_run, ever_again) in cases {
        let mut setup = Setup::new(backend);
        let view = view(Aov::Beauty);
        let whole = setup.renderer.render_display(&view, &setup.lights).expect("drawn");
        setup.renderer.invalidate();
        let (by_stages, recording) = setup.renderer.record_display(&view, &setup.lights).expect("drawn");
        assert!(by_stages == whole, "{backend:?}");
        let expected = FrameStage::ALL.map(|stage| u64::from(!not_run.contains(&stage)));
        assert_eq!(FrameStage::ALL.map(|stage| recording.runs(stage)), expected, "{backend:?}");
        let is_timed = |stage: &FrameStage| (recording.cost(*stage).wall_ms > 0.0) != not_run.contains(stage);
        assert!(FrameStage::ALL.iter().all(is_timed), "{backend:?}: {recording:?}");
        let (_, kept) = setup.renderer.record_display(&view, &setup.lights).expect("drawn");
        let ran: Vec<_> = FrameStage::ALL.into_iter().filter(|stage| kept.runs(*stage) > 0).collect();
        assert_eq!(ran, ever_again, "{backend:?}");
    }
}

/// Texels of a map are small where the tube is thin. A wall along the tube is split finely only where it is on the map.
#[test]
fn edges_on_no_texel_are_not_split() {
    let mut scene = scene();
    // A wall beside the light's axis, twice as high as the light is long.
    let across = DAffine3::from_scale_rotation_translation(
        DVec3::new(3.0, 4.0, 0.001),
        DQuat::from_rotation_y(0.3),
        DVec3::new(-1.0, 2.0, 0.02),
    );
    scene.nodes.truncate(1);
    scene.nodes[0].parent_from_local = across;
    let thin = light().map_points(|i, point| point.radius = [0.0, 0.0, 0.1, 0.2, 0.3][i]);
    let mut device = renderer(&scene);
    let before = device.wgpu().backend.bent_buffers.capacity;
    device.render(&view(Aov::Visibility), &alone(&thin)).expect("drawn");
    assert_eq!(device.wgpu().backend.bent_buffers.capacity, before);
    // The native backend has no capacity. It must not split more than the wgpu backend's capacity.
    let mut processor = renderer_of(Backend::Native, &scene);
    let (_, recording) = processor.record_display(&view(Aov::Beauty), &alone(&thin)).expect("drawn");
    let drawn = recording.counters.triangles_drawn;
    assert!((1..=u64::from(before.split_vertices / 3)).contains(&drawn), "{drawn} triangles");
}
