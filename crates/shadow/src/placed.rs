//! Lights in a scene. This module alone tells the shapes of lights apart; the backends turn a [`PlacedLight`] into what
//! they draw.

use glam::DVec3;
use light::{CheckedLight, LightProfile, LightRays};
use scene::PosedScene;

use crate::bent::{self, MapShape, PlacedBent, part_in};
use crate::casters::Clusters;
use crate::settings::{MapSize, ShadowSettings};
use crate::straight::directional::{self, OrthographicFit};
use crate::straight::perspective::PerspectiveFit;
use crate::straight::{PlacedStraight, omni, spot};

/// Light in a scene: its numbers in scene space, and its shadow map.
///
/// It depends on the light, on the posed scene and on the settings, and not on a view.
#[derive(Clone, Debug)]
pub enum PlacedLight {
    Straight(Box<PlacedStraight>),
    Bent(Box<PlacedBent>),
}

/// Part of a scene that a light's shadow map shows. It stays valid as long as what the map depends on
/// ([`light::Revisions::shadow_map`]), while other parameters of the light change.
#[derive(Clone, Debug)]
pub struct MapFit(Fit);

#[derive(Clone, Debug)]
enum Fit {
    Perspective(PerspectiveFit),
    Orthographic(OrthographicFit),
    Bent(Box<MapShape>),
    /// Fit of a light without shadows.
    None,
}

/// Simplified casters that a coarse map may show in place of the scene's own.
#[derive(Clone, Copy, Debug)]
pub struct CoarseClusters<'a> {
    pub clusters: &'a Clusters,
    /// Largest distance of the casters from the surface, in world units.
    pub mesh_error: f64,
}

/// Largest distance of simplified casters from the surface, in texels of the map where they are widest. It can be two
/// texels because the filter blends two.
const MOST_TEXELS: f64 = 2.0;

/// Returns the size of the map of a light. A light without shadows has the smallest one, because a binding must not be
/// empty.
pub fn map_size(light: &CheckedLight, settings: &ShadowSettings) -> MapSize {
    let size = settings.map_size(match light.rays() {
        LightRays::Cone(_) => spot::face_count(light.light()),
        LightRays::Omni(_) => omni::FACES,
        LightRays::Parallel(_) => 1,
        LightRays::Bent(_) => bent::face_count(light.light()),
    });
    if light.light_profile().shadow_enable { size } else { MapSize { side: 1, ..size } }
}

/// Returns the world positions whose convex hull contains everything that a light can light in a scene; none if it
/// lights nothing.
pub fn lit_hull_in_world(light: &CheckedLight, posed: &PosedScene) -> Vec<DVec3> {
    match light.rays() {
        LightRays::Cone(cone) => spot::corners_in_world(cone, posed).to_vec(),
        LightRays::Omni(omni) => omni::corners_in_world(omni, posed),
        LightRays::Parallel(parallel) => directional::corners_in_world(parallel, posed).to_vec(),
        LightRays::Bent(tube) => bent::corners_in_world(tube, posed),
    }
}

/// Fits the shadow map of a light to the casters of a scene. A bent map may show `coarse` casters instead, if they are
/// accurate enough for its texels. Returns true if it does.
pub fn fit_map(
    light: &CheckedLight,
    posed: &PosedScene,
    clusters: &Clusters,
    coarse: Option<CoarseClusters>,
    settings: &ShadowSettings,
) -> (MapFit, bool) {
    if !light.light_profile().shadow_enable {
        return (MapFit(Fit::None), false);
    }
    let fit = match light.rays() {
        LightRays::Cone(cone) => Fit::Perspective(spot::fit_map(light.light(), cone, posed, clusters, settings)),
        LightRays::Omni(omni) => Fit::Perspective(omni::fit_map(omni, posed, clusters, settings)),
        LightRays::Parallel(parallel) => Fit::Orthographic(directional::fit_map(parallel, posed, clusters, settings)),
        LightRays::Bent(tube) => {
            let tube = &part_in(posed, tube).tube;
            let fitted =
                |clusters, mesh_error| bent::fit_map(light.light(), tube, posed, (clusters, mesh_error), settings);
            let shape = fitted(clusters, settings.mesh_error);
            let most = MOST_TEXELS * shape.last_texel_in_world(tube);
            let accurate = coarse.filter(|coarse| coarse.mesh_error <= most);
            let shape = accurate.map_or(shape, |CoarseClusters { clusters, mesh_error }| fitted(clusters, mesh_error));
            return (MapFit(Fit::Bent(Box::new(shape))), accurate.is_some());
        }
    };
    (MapFit(fit), false)
}

/// Returns a BendyLight with a map of all of it, which contains all casters, for a wireframe. `None` for other lights.
pub fn wireframe_of(
    light: &CheckedLight,
    posed: &PosedScene,
    clusters: &Clusters,
    settings: &ShadowSettings,
) -> Option<PlacedBent> {
    let LightRays::Bent(tube) = light.rays() else { return None };
    let part = part_in(posed, tube);
    let shape = bent::whole_map(light.light(), &part.tube, posed, clusters, settings);
    Some(bent::placed(part, posed, settings, Some(&shape)))
}

impl MapFit {
    /// Returns the shape of a bent map; `None` for other fits.
    pub fn bent_shape(&self) -> Option<&MapShape> {
        if let Fit::Bent(shape) = &self.0 { Some(shape) } else { None }
    }
}

impl PlacedLight {
    /// Returns the profile, with the least distance at which the light lights.
    pub fn light_profile(&self) -> &LightProfile {
        match self {
            Self::Straight(placed) => &placed.light_profile,
            Self::Bent(placed) => &placed.part.tube.light_profile,
        }
    }

    /// Places a light within reach of a scene, with its fitted map. A fit of another light counts as none.
    pub fn new(light: &CheckedLight, posed: &PosedScene, fit: &MapFit, settings: &ShadowSettings) -> Self {
        let none = PerspectiveFit::NONE;
        let perspective = if let Fit::Perspective(fit) = &fit.0 { fit } else { &none };
        match light.rays() {
            LightRays::Cone(cone) => Self::Straight(spot::placed(cone, posed, settings, perspective).into()),
            LightRays::Omni(omni) => Self::Straight(omni::placed(omni, posed, settings, perspective).into()),
            LightRays::Parallel(parallel) => {
                let fit = if let Fit::Orthographic(fit) = &fit.0 { fit } else { &OrthographicFit::NONE };
                Self::Straight(directional::placed(parallel, posed, settings, fit).into())
            }
            LightRays::Bent(tube) => {
                Self::Bent(bent::placed(part_in(posed, tube), posed, settings, fit.bent_shape()).into())
            }
        }
    }
}
