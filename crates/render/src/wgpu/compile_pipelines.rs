//! Draws with the common pipelines once, so that no first picture waits for a compiler.

use glam::{DAffine3, DQuat, DVec3, Vec3};
use light::parameters::{DECAY, RANGE};
use light::{Decay, Light, LightInstance, Transform};
use scene::{Camera, Material, Mesh, Node, Primitive, Projection, Scene};

use crate::frame::{Frame, FrameBackend};
use crate::wgpu::Wgpu;
use crate::{RenderError, ShadowSettings, View};

/// Largest number of segments to compile for: a software driver takes a second per segment.
const SEGMENTS: usize = 4;

/// Does the work of [`crate::Renderer::compile_pipelines`].
pub(crate) fn compile_pipelines(wgpu: &Wgpu, mut keep_going: impl FnMut() -> bool) -> Result<(), RenderError> {
    let mut frame = Frame::new(wgpu.sibling()?)?;
    frame.set_scene(&scene::pose(scene(), 0.0))?;
    // The BendyLights below are straight, but must be drawn as bent ones.
    frame.set_shadow_settings(ShadowSettings { straighten: false, ..ShadowSettings::default() })?;
    let spot = spot();
    let [omni, directional] = [Light::omni(), Light::directional()].map(|light| light.with_transform(spot.transform()));
    let bent = (1..=SEGMENTS).map(|segments| light::bend(&spot, segments));
    for (number, light) in [omni, directional, spot.clone()].map(Ok).into_iter().chain(bent).enumerate() {
        if number > 0 && !keep_going() {
            break;
        }
        let lights = LightInstance::numbered([light?])?;
        // Pictures of an interactive view and others.
        frame.render_display(&view(), &lights)?;
        frame.render(&view(), &lights)?;
    }
    Ok(())
}

/// Returns a scene of three squares: one-sided, double-sided and alpha-tested. Each is drawn by another pipeline.
fn scene() -> Scene {
    let square = |material| Primitive {
        positions: [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, z)| Vec3::new(x, 0.0, z)).into(),
        normals: vec![Vec3::Y; 4],
        indices: vec![0, 1, 2, 0, 2, 3],
        material,
        ..Primitive::default()
    };
    let one_sided = Material::default();
    let double_sided = Material { double_sided: true, ..one_sided.clone() };
    let cut_out = Material { alpha_cutoff: Some(0.5), ..one_sided.clone() };
    let primitives = (0..3).map(square).collect();
    let node = Node { name: String::new(), parent: None, parent_from_local: DAffine3::IDENTITY, mesh: Some(0) };
    Scene {
        materials: vec![one_sided, double_sided, cut_out],
        meshes: vec![Mesh { name: String::new(), primitives }],
        nodes: vec![node],
        ..Scene::default()
    }
}

/// Returns a view from above. Its sides are not powers of two, because drivers may compile those separately.
fn view() -> View {
    let camera = Camera {
        name: String::new(),
        translation: DVec3::Y * 3.0,
        rotation: downwards(),
        projection: Projection::Perspective { yfov: 0.8, aspect_ratio: None, znear: 0.1, zfar: None },
    };
    View::beauty(camera, [42, 22])
}

/// Returns a light over the middle of the squares.
fn spot() -> Light {
    let transform = Transform { translation: DVec3::Y * 2.0, rotation: downwards(), scale: 1.0 };
    Light::spot().with_transform(transform).with(RANGE, Some(4.0)).with(DECAY, Decay::None)
}

/// Returns the rotation from -Z to -Y.
fn downwards() -> DQuat {
    DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2)
}
