//! A scene to drag in, and its camera.

use drag::Viewport;
use glam::{DVec2, DVec3};
use light::{CheckedLight, TubePoint};
use raycast::SeenPoint;
use reference::{Reference, ShadedPoint};
use scene::{Camera, Scene, View, ViewRay, framing_camera};

/// Minimum distance of a caster from the surface, as a share of the surface's distance from the camera.
const CONTACT: f64 = 1e-6;

/// A scene and its picture, with queries that are independent of the drag solver.
#[derive(Debug)]
pub struct TrialScene {
    /// Name of the scene: a file, or `demo:NAME`.
    pub name: String,
    /// Surfaces of the scene.
    pub reference: Reference,
    pub view: Viewport,
}

impl TrialScene {
    /// Makes a stage with the first camera, or with one that frames the scene, which is the default of
    /// `bendylights drag`.
    pub fn new(name: &str, scene: Scene, cameras: &[Camera], size: [u32; 2]) -> Self {
        let reference = Reference::new(scene::pose(scene, 0.0));
        let [width, height] = size.map(f64::from);
        let framing = || framing_camera(&reference.bvh.posed.bounds(), width / height);
        let camera = cameras.first().cloned().unwrap_or_else(framing);
        Self { name: name.into(), view: Viewport { camera, size }, reference }
    }

    /// Returns the origin of scene space, in the world.
    pub fn origin(&self) -> DVec3 {
        self.reference.bvh.posed.origin_in_world
    }

    /// Returns the surface at a pixel.
    pub fn seen(&self, pixel: DVec2) -> Option<SeenPoint> {
        let Viewport { camera, size } = &self.view;
        self.reference.bvh.visible_point(&ViewRay::new(camera, *size, pixel, self.origin()))
    }

    /// Returns the surface at a pixel with its material, by the reference.
    pub fn surface(&self, pixel: DVec2) -> Option<ShadedPoint> {
        let Viewport { camera, size } = &self.view;
        self.reference.surface(&View::beauty(camera.clone(), *size), pixel)
    }

    /// Returns the first point, in scene space, at which the light path to a surface meets a caster that does not touch
    /// the surface. `coords` are the surface's own. `None` if there is none.
    pub fn first_caster(&self, light: &CheckedLight, coords: &TubePoint, surface: &ShadedPoint) -> Option<DVec3> {
        let bvh = &self.reference.bvh;
        let path = bvh.bent_path(light.tube()?, coords.v, coords.w);
        let near = CONTACT * surface.depth;
        let hit = bvh.first_bent_hit(&path, coords.t, |hit| {
            let is_solid = bvh.passes_alpha_test(&bvh.triangle(hit.triangle), hit.barycentrics);
            is_solid && hit.position.distance(surface.position) > near
        })?;
        Some(hit.position)
    }

    /// Returns the tube coordinates of a point in scene space; `None` outside of the tube.
    pub fn locate(&self, light: &CheckedLight, position: DVec3) -> Option<TubePoint> {
        light.tube()?.locate(position + self.origin()).point
    }

    /// Returns the size of the picture in pixels.
    pub fn size(&self) -> DVec2 {
        DVec2::from(self.view.size.map(f64::from))
    }
}
