//! What stands in a light's way.

use glam::DVec3;
use light::parameters::SHADOW_ENABLE;
use light::{CheckedLight, Rays};
use raycast::{Bvh, Linked, Seen};

use crate::place::{Place, Placed};

/// Distance from a surface within which nothing shadows it, as a share of the light's size or of the way to the source.
const CONTACT: f64 = 1e-9;

/// A scene as one light sees it.
pub(crate) struct Occlusion<'a> {
    bvh: &'a Bvh,
    linked: Linked,
    /// Whether anything shadows it.
    shadow_enable: bool,
}

/// The first that light meets on its way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Caster {
    /// In scene space.
    pub position: DVec3,
    /// How far along the light's way, as [`Place::t`].
    pub t: f64,
    pub node: usize,
}

impl<'a> Occlusion<'a> {
    pub fn new(bvh: &'a Bvh, light: &CheckedLight) -> Self {
        let shadow_enable = light.light().get(SHADOW_ENABLE);
        Self { bvh, linked: Linked::new(&bvh.posed, light), shadow_enable }
    }

    /// Whether the light shows on a node.
    pub fn lights(&self, node: usize) -> bool {
        self.linked.lights(node)
    }

    /// The first that light meets on its way to a surface that lies at `place`.
    pub fn first(&self, placed: &Placed, place: &Place, surface: &Seen) -> Option<Caster> {
        if !self.shadow_enable {
            return None;
        }
        let point = surface.position;
        let rounding = 64.0 * f64::EPSILON * point.abs().max_element();
        match placed.rays {
            Rays::Bent(tube) => {
                let contact = CONTACT * tube.placement.world_per_tube + rounding;
                let path = self.bvh.path(tube, place.across.x, place.across.y);
                let hit = self.bvh.first_bent_hit(&path, place.t, |hit| {
                    hit.position.distance(point) > contact && self.stops(hit.triangle, hit.weights)
                })?;
                let node = self.bvh.triangles[hit.triangle].node;
                Some(Caster { position: hit.position, t: hit.t, node })
            }
            Rays::Cone(_) | Rays::Omni(_) => {
                let (from, way) = (placed.source(), point - placed.source());
                let far = 1.0 - CONTACT - rounding / way.length();
                let (distance, node) = self.first_along(from, way, far, surface)?;
                Some(Caster { position: from + way * distance, t: way.length() * distance, node })
            }
            Rays::Parallel(_) => {
                // From outside of the scene.
                let size = 2.0 * self.bvh.posed.half_extent.length();
                let way = place.to_light * -size;
                let far = 1.0 - CONTACT - rounding / size;
                let (distance, node) = self.first_along(point - way, way, far, surface)?;
                let position = point - way * (1.0 - distance);
                Some(Caster { position, t: place.t - size * (1.0 - distance), node })
            }
        }
    }

    fn first_along(&self, from: DVec3, way: DVec3, far: f64, surface: &Seen) -> Option<(f64, usize)> {
        let hit = self.bvh.first_hit(from, way, [0.0, far], |hit| {
            hit.triangle != surface.triangle && self.stops(hit.triangle, hit.weights)
        })?;
        Some((hit.distance, self.bvh.triangles[hit.triangle].node))
    }

    /// Whether a place of a triangle throws a shadow.
    fn stops(&self, triangle: usize, weights: DVec3) -> bool {
        let triangle = &self.bvh.triangles[triangle];
        self.linked.stops_at(triangle.node) && self.bvh.is_solid(triangle, weights)
    }
}
