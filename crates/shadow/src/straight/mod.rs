//! Shadow maps of lights with straight rays: one or several faces, each an ordinary picture from the light, fitted to
//! its casters.

mod cover;
pub(crate) mod directional;
pub(crate) mod omni;
pub(crate) mod perspective;
pub(crate) mod spot;

use glam::{DMat4, DVec3, Mat4};
use light::LightProfile;
use relight::{DirectionalMapParams, OmniMapParams, SpotMapParams};

/// Light with straight rays in a scene, with the projections of its shadow map.
#[derive(Clone, Debug)]
pub struct PlacedStraight {
    /// Transform from scene space to the light's axes, with the source, or the middle of parallel rays, at the origin.
    pub light_from_scene: DMat4,
    /// Point in scene space where light begins; `None` for parallel rays, which come from outside every scene.
    pub source_in_scene: Option<DVec3>,
    /// Profile of the light. It lights nothing nearer than the map's least distance.
    pub light_profile: LightProfile,
    /// Coordinates of surfaces in the light and in its map, by its shape.
    pub coords: StraightCoords,
    /// Distance of the near plane in world units; `None` for parallel rays.
    pub near: Option<f64>,
    /// Projections of the map, one per face; `None` for a face without casters.
    pub clip_from_light: Vec<Option<DMat4>>,
}

/// Numbers by which surfaces find their coordinates in a light and in its map.
#[derive(Clone, Copy, Debug)]
pub enum StraightCoords {
    Spot {
        /// Tangent of half the opening angle.
        tan_outer: f32,
        /// Distance along the axis at which the light ends, in world units; `None` for a light without end.
        range: Option<f32>,
        map: SpotMapParams,
    },
    Omni {
        /// Distance from the source at which the light ends, in world units; `None` for a light without end.
        range: Option<f32>,
        map: OmniMapParams,
    },
    Directional {
        /// Coordinates in the window are (-x, y) times the first two numbers plus the others; 0 for a window without
        /// end.
        window: [f32; 4],
        map: DirectionalMapParams,
    },
}

impl PlacedStraight {
    /// Returns the projections from scene space, one per face of the map; `None` for a face without casters.
    pub fn clips_from_scene(&self) -> Vec<Option<Mat4>> {
        let from_scene = |clip_from_light: &DMat4| (*clip_from_light * self.light_from_scene).as_mat4();
        self.clip_from_light.iter().map(|face| face.as_ref().map(from_scene)).collect()
    }
}
