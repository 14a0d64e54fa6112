//! A scene to drag in, and who looks at it.

use drag::Viewport;
use glam::{DVec2, DVec3};
use light::{CheckedLight, TubePoint};
use raycast::SeenPoint;
use reference::{Reference, ShadedPoint};
use scene::{Camera, Scene, View, ViewRay, framing_camera};

/// A scene, its picture, and what is known of both by other ways than a drag's own.
#[derive(Debug)]
pub struct TrialScene {
    /// What the scene is called: a file, or `demo:NAME`.
    pub name: String,
    /// Its surfaces.
    pub reference: Reference,
    /// The picture.
    pub view: Viewport,
}

impl TrialScene {
    /// Through the first camera, or one that frames the scene, as `bendylights drag` looks by default.
    pub fn new(name: &str, scene: Scene, cameras: &[Camera], size: [u32; 2]) -> Self {
        let reference = Reference::new(scene::pose(scene));
        let [width, height] = size.map(f64::from);
        let framing = || framing_camera(&reference.bvh.posed.bounds(), width / height);
        let camera = cameras.first().cloned().unwrap_or_else(framing);
        Self { name: name.into(), view: Viewport { camera, size }, reference }
    }

    /// Where scene space begins, in the world.
    pub fn origin(&self) -> DVec3 {
        self.reference.bvh.posed.origin_in_world
    }

    /// The surface in a pixel.
    pub fn seen(&self, pixel: DVec2) -> Option<SeenPoint> {
        let Viewport { camera, size } = &self.view;
        self.reference.bvh.visible_point(&ViewRay::new(camera, *size, pixel, self.origin()))
    }

    /// The same with its material, by the reference.
    pub fn surface(&self, pixel: DVec2) -> Option<ShadedPoint> {
        let Viewport { camera, size } = &self.view;
        self.reference.surface(&View::beauty(camera.clone(), *size), pixel)
    }

    /// Where a point in scene space lies in a light; `None` outside of its tube.
    pub fn locate(&self, light: &CheckedLight, position: DVec3) -> Option<TubePoint> {
        light.tube()?.locate(position + self.origin()).point
    }

    /// Pixels.
    pub(crate) fn size(&self) -> DVec2 {
        DVec2::from(self.view.size.map(f64::from))
    }
}
