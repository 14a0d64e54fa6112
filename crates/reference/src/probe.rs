//! Probes: the reasons that one pixel is lit or not, light by light.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};
use light::parameters::ENABLED;
use light::{LightCoords, LightId, LightInstance, LightRays};
use raycast::LinkedNodes;
use scene::View;

use crate::{LightSample, Reference, ReferenceError, ReferenceLight, ShadedPoint, evaluate_brdf};

/// Maximum number of points of a light path's polyline.
const MAX_PATH_POINTS: usize = 256;

/// Weights of linear RGB for Rec. 709 luminance. Shares of lights are shares of luminance.
const LUMINANCE: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// Result of a probe at one point of a picture.
#[derive(Clone, Debug)]
pub struct Probe {
    /// Visible surface; `None` if there is only background.
    pub seen: Option<ProbedSurface>,
    /// One entry per light, in order. Empty if no surface is visible.
    pub lights: Vec<LightProbe>,
}

/// Surface at the probed point.
#[derive(Clone, Copy, Debug)]
pub struct ProbedSurface {
    /// Index of the node in the scene.
    pub node: usize,
    /// Index of the material in the scene.
    pub material: usize,
    /// World position.
    pub position: DVec3,
    /// Unit shading normal, on the viewer's side.
    pub normal: DVec3,
    /// Distance along the view axis, in world units.
    pub depth: f64,
    /// Radiance of the scene's fill light towards the viewer, linear RGB.
    pub fill: DVec3,
}

/// Contribution of a light at a surface.
#[derive(Clone, Debug)]
pub struct LightProbe {
    pub light: LightInstance,
    pub state: LightState,
    /// Light coordinates of the surface; `None` outside the light.
    pub place: Option<ProbedPlace>,
    /// Unshadowed irradiance on a surface perpendicular to the light, linear RGB. It is 0 if the light does not
    /// shine on the surface at all.
    pub irradiance: DVec3,
    /// Radiance that the light adds towards the viewer, linear RGB.
    pub radiance: DVec3,
    /// Share of `radiance` in the luminance that all lights together add, from 0 to 1. All shares are 0 if that
    /// luminance is 0.
    pub share: f64,
    /// Light path to the surface, as a polyline in world space. It starts at the source, or outside the scene
    /// if the source is infinitely far away. It deviates from the path by less than 1/4096 of its length,
    /// unless it has 256 points. Empty outside the light.
    pub path: Vec<DVec3>,
}

/// State of a light at a surface: `Lit`, or the first reason that it is not, in the order of the variants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightState {
    /// The light arrives.
    Lit,
    /// The light emits nothing.
    Disabled(DisabledBy),
    /// The light's links exclude the node.
    Unlinked,
    /// The surface lies outside the light's tube, cone or window, or beyond its range.
    Outside,
    /// The light has faded to zero: beyond a cutoff, outside its outline, or at the edge of its profile.
    Faded,
    /// The surface faces away from the light.
    FacingAway,
    /// An occluder lies on the light path.
    Shadowed(ProbedCaster),
}

/// Reason that a light emits nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DisabledBy {
    /// The view shows only other lights.
    Muted,
    /// The light is off.
    Off,
    /// The intensity or the color is 0, or the light adds to neither diffuse nor specular reflection.
    Dark,
}

/// First occluder on a light path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbedCaster {
    /// Index of the node in the scene.
    pub node: usize,
    /// World position.
    pub position: DVec3,
}

/// Position of a surface in a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbedPlace {
    /// Coordinates along and across the light, and the direction towards it.
    pub coords: LightCoords,
    /// Radius of the tube or cone at the surface, in world units; `None` for other lights.
    pub radius: Option<f64>,
    /// Length of the light path from the source, in world units; `None` if the source is infinitely far away.
    pub path_length: Option<f64>,
}

impl Reference {
    /// Probes the surface at `pixel` of `view`'s picture, in pixels from the top left corner: (0.5, 0.5) is the
    /// centre of the first pixel. The result has an entry for each of `lights`. The view does not show those in
    /// `muted`.
    ///
    /// The sum over the lights equals [`Reference::radiance`] without fill light, to some ulps. A probe costs
    /// one ray for the viewer, and one or two rays per light, along its path.
    pub fn probe(
        &self,
        view: &View,
        pixel: DVec2,
        lights: &[LightInstance],
        muted: &BTreeSet<LightId>,
    ) -> Result<Probe, ReferenceError> {
        let size = [view.width, view.height];
        if size.contains(&0) {
            return Err(ReferenceError::EmptyView);
        }
        view.camera.check().map_err(ReferenceError::Camera)?;
        let is_within = |at: f64, side: u32| (0.0..f64::from(side)).contains(&at);
        if !(is_within(pixel.x, size[0]) && is_within(pixel.y, size[1])) {
            return Err(ReferenceError::OffPicture { x: pixel.x, y: pixel.y, size });
        }
        let Some(surface) = self.surface(view, pixel) else {
            return Ok(Probe { seen: None, lights: Vec::new() });
        };
        let of = |light: &LightInstance| self.probe_light(light, muted.contains(&light.id), &surface);
        let mut lights: Vec<LightProbe> = lights.iter().map(of).collect();
        share_out(&mut lights);
        let seen = ProbedSurface {
            node: surface.node,
            material: self.bvh.primitive(&self.bvh.triangle(surface.triangle)).material,
            position: self.in_world(surface.position),
            normal: surface.normal,
            depth: surface.depth,
            fill: self.fill(&surface),
        };
        Ok(Probe { seen: Some(seen), lights })
    }

    fn probe_light(&self, light: &LightInstance, is_muted: bool, surface: &ShadedPoint) -> LightProbe {
        let (source, linked) = (ReferenceLight::new(&light.light), LinkedNodes::new(&self.bvh.posed, &light.light));
        // The coordinates do not depend on links.
        let sample = self.sample_unshadowed(&source, &LinkedNodes::default(), surface);
        let state = self.state(light, is_muted, &source, &linked, surface, sample.as_ref());
        let (mut irradiance, mut radiance) = (DVec3::ZERO, DVec3::ZERO);
        if let Some(sample) = &sample
            && !matches!(state, LightState::Disabled(_) | LightState::Unlinked)
        {
            let profile = source.light_profile();
            let lobes = [profile.diffuse, profile.specular];
            let visibility = if state == LightState::Lit { 1.0 } else { 0.0 };
            irradiance = sample.irradiance;
            radiance = evaluate_brdf(surface, sample.coords.direction, lobes)
                * sample.irradiance
                * profile.arriving(visibility);
        }
        let (place, path) = sample.map(|sample| self.light_path(light.light.rays(), surface.position, &sample)).unzip();
        let path = path.unwrap_or_default();
        LightProbe { light: light.clone(), state, place, irradiance, radiance, share: 0.0, path }
    }

    fn state(
        &self,
        light: &LightInstance,
        is_muted: bool,
        source: &ReferenceLight,
        linked: &LinkedNodes,
        surface: &ShadedPoint,
        sample: Option<&LightSample>,
    ) -> LightState {
        let profile = source.light_profile();
        if is_muted {
            return LightState::Disabled(DisabledBy::Muted);
        }
        if !light.light.light().get(ENABLED) {
            return LightState::Disabled(DisabledBy::Off);
        }
        if profile.is_dark() {
            return LightState::Disabled(DisabledBy::Dark);
        }
        if !linked.is_lit(surface.node) {
            return LightState::Unlinked;
        }
        let Some(sample) = sample else { return LightState::Outside };
        if sample.irradiance == DVec3::ZERO {
            return LightState::Faded;
        }
        let can_be_shadowed = profile.shadow_enable;
        if surface.normal.dot(sample.coords.direction) <= 0.0
            || can_be_shadowed && self.is_back_facing(linked, surface, sample)
        {
            return LightState::FacingAway;
        }
        if !can_be_shadowed || self.has_line_of_sight(source, linked, surface, sample) {
            return LightState::Lit;
        }
        let found = self.first_occluder(source, linked, surface, sample);
        // An occluder that exists only by rounding lies on the surface itself.
        let (node, position) = found.map_or((surface.node, surface.position), |obstacle| {
            (self.bvh.triangle(obstacle.triangle).node, obstacle.position)
        });
        LightState::Shadowed(ProbedCaster { node, position: self.in_world(position) })
    }

    /// Returns the light coordinates of a point, and the light path to it.
    fn light_path(&self, rays: &LightRays, point: DVec3, sample: &LightSample) -> (ProbedPlace, Vec<DVec3>) {
        let coords = sample.coords;
        let (points, radius, path_length) = match rays {
            LightRays::Bent(tube) => {
                let polyline = self.bvh.bent_path(tube, coords.v, coords.w).polyline(coords.t, MAX_PATH_POINTS);
                let segment = (coords.t as usize).min(tube.segments.len() - 1);
                let radius = tube.segments[segment].curve.radius(coords.t - segment as f64);
                (polyline.points, Some(radius * tube.placement.world_per_tube), Some(polyline.length))
            }
            LightRays::Cone(cone) => {
                let from = self.in_scene(cone.translation);
                let radius = -(cone.rotation.transpose() * (point - from)).z * cone.tan_outer;
                (vec![from, point], Some(radius), Some(coords.s))
            }
            LightRays::Omni(omni) => (vec![self.in_scene(omni.translation), point], None, Some(coords.s)),
            LightRays::Parallel(parallel) => {
                let from = self.bvh.point_outside_scene(point, parallel.direction());
                (vec![from, point], None, None)
            }
        };
        let path = points.into_iter().map(|point| self.in_world(point)).collect();
        (ProbedPlace { coords, radius, path_length }, path)
    }

    pub(crate) fn in_world(&self, position: DVec3) -> DVec3 {
        position + self.bvh.posed.origin_in_world
    }
}

/// Computes the share of each light in the luminance that all lights together add.
fn share_out(lights: &mut [LightProbe]) {
    let luminance = |light: &LightProbe| light.radiance.dot(LUMINANCE).min(f64::MAX);
    let largest = lights.iter().map(luminance).fold(0.0, f64::max);
    if largest == 0.0 {
        return;
    }
    // Divides by the largest luminance, so that the sum cannot overflow.
    let all: f64 = lights.iter().map(|light| luminance(light) / largest).sum();
    for light in lights {
        light.share = luminance(light) / largest / all;
    }
}
