//! Why a pixel is lit or not: what each light does at the surface that is seen through one point of a picture.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};
use light::parameters::ENABLED;
use light::{LightCoords, LightId, LightInstance, LightRays, Tube};
use raycast::LinkedNodes;
use scene::View;

use crate::{LightSample, Reference, ReferenceError, ReferenceLight, ShadedPoint, evaluate_brdf};

/// Most points of a path that is drawn.
const MAX_PATH_POINTS: usize = 256;

/// Rec. 709's luminance of linear RGB: what shares are shares of.
const LUMINANCE: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// What one point of a picture shows.
#[derive(Clone, Debug)]
pub struct Probe {
    /// What is seen there; `None` where there is only background.
    pub seen: Option<ProbedSurface>,
    /// One a light, in their order; none where nothing is seen.
    pub lights: Vec<LightProbe>,
}

/// A surface that is seen.
#[derive(Clone, Copy, Debug)]
pub struct ProbedSurface {
    /// Index of the node in the scene.
    pub node: usize,
    /// Index of the material in the scene.
    pub material: usize,
    /// Position in the world.
    pub position: DVec3,
    /// Unit shading normal, towards the viewer.
    pub normal: DVec3,
    /// Distance along the view axis, in world units.
    pub depth: f64,
    /// Radiance of the scene's fill towards the eye, linear RGB.
    pub fill: DVec3,
}

/// What a light does at a surface.
#[derive(Clone, Debug)]
pub struct LightProbe {
    /// What is asked about.
    pub light: LightInstance,
    /// Whether it lights the surface, or why not.
    pub state: LightState,
    /// Where the surface lies in it; `None` outside.
    pub place: Option<ProbedPlace>,
    /// On a surface square to the light, linear RGB, were nothing in the way; 0 where it does not shine on the surface at all.
    pub irradiance: DVec3,
    /// What it adds to the radiance towards the eye, linear RGB.
    pub radiance: DVec3,
    /// Share of that in the luminance that all lights together give, 0 to 1; all 0 where there is none.
    pub share: f64,
    /// The way of its light to the surface: points in the world, from the source on, and from outside of the scene where the
    /// source is infinitely far away. The pieces between them stray from it by less than 1/4096 of its length, or there are 256
    /// points. Empty outside.
    pub path: Vec<DVec3>,
}

/// Whether a light lights a surface, or the first reason that it does not, in the order below but for `Lit`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightState {
    /// Its light arrives.
    Lit,
    /// It shines nowhere.
    Disabled(DisabledBy),
    /// The node is not among those that it lights.
    Unlinked,
    /// The surface lies outside of its tube, its cone or its sides, or past its range.
    Outside,
    /// Nothing of its light is left there: past a cut, outside its outline, at an edge of its profile.
    Faded,
    /// The surface turns its back to where its light comes from.
    FacingAway,
    /// Something stands in its way.
    Shadowed(ProbedCaster),
}

/// Why a light shines nowhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DisabledBy {
    /// It is not among those that are shown alone.
    Muted,
    /// It is turned off.
    Off,
    /// Its intensity or its colour is 0, or what surfaces scatter and mirror of it.
    Dark,
}

/// The first that light meets on its way to a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbedCaster {
    /// Index of the node in the scene.
    pub node: usize,
    /// Where, in the world.
    pub position: DVec3,
}

/// Where a surface lies in a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbedPlace {
    /// Along the light and across it, and where its light comes from.
    pub coords: LightCoords,
    /// Radius of the tube or the cone there, in world units; `None` of lights that have none.
    pub radius: Option<f64>,
    /// Length of the light's way from its source, in world units; `None` where it comes from infinitely far away.
    pub path_length: Option<f64>,
}

impl Reference {
    /// What is seen through `pixel` of `view`'s picture, in pixels from its top left corner ((0.5, 0.5) is the centre of the
    /// first pixel), and what each of `lights` does there, of which `muted` are not shown.
    ///
    /// It is what [`Reference::radiance`] is made of: the sum over lights is that with no fill, to some ulps. Takes a ray for
    /// the eye and one or two a light, bent as it is.
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
            material: self.bvh.primitive(&self.bvh.triangles[surface.triangle]).material,
            position: self.in_world(surface.position),
            normal: surface.normal,
            depth: surface.depth,
            fill: self.fill(&surface),
        };
        Ok(Probe { seen: Some(seen), lights })
    }

    fn probe_light(&self, light: &LightInstance, is_muted: bool, surface: &ShadedPoint) -> LightProbe {
        let (source, linked) =
            (ReferenceLight::new(&light.light), LinkedNodes::new(&self.bvh.posed, &light.light));
        // Where it lies, linked or not.
        let sample = self.sample_unshadowed((&source, &LinkedNodes::default()), surface);
        let state = self.state(light, is_muted, (&source, &linked), surface, sample.as_ref());
        let (mut irradiance, mut radiance) = (DVec3::ZERO, DVec3::ZERO);
        if let Some(sample) = &sample
            && !matches!(state, LightState::Disabled(_) | LightState::Unlinked)
        {
            let filter = source.light_profile();
            let lobes = [filter.diffuse, filter.specular];
            let visibility = if state == LightState::Lit { 1.0 } else { 0.0 };
            irradiance = sample.irradiance;
            radiance = evaluate_brdf(surface, sample.coords.direction, lobes)
                * sample.irradiance
                * filter.arriving(visibility);
        }
        let (place, path) = sample.map_or((None, Vec::new()), |sample| {
            let (place, path) = self.light_path(light.light.rays(), surface.position, &sample);
            (Some(place), path)
        });
        LightProbe { light: light.clone(), state, place, irradiance, radiance, share: 0.0, path }
    }

    fn state(
        &self,
        light: &LightInstance,
        is_muted: bool,
        (source, linked): (&ReferenceLight, &LinkedNodes),
        surface: &ShadedPoint,
        sample: Option<&LightSample>,
    ) -> LightState {
        let filter = source.light_profile();
        if is_muted {
            return LightState::Disabled(DisabledBy::Muted);
        }
        if !light.light.light().get(ENABLED) {
            return LightState::Disabled(DisabledBy::Off);
        }
        if filter.is_dark() {
            return LightState::Disabled(DisabledBy::Dark);
        }
        if !linked.is_lit(surface.node) {
            return LightState::Unlinked;
        }
        let Some(sample) = sample else { return LightState::Outside };
        if sample.irradiance == DVec3::ZERO {
            return LightState::Faded;
        }
        let can_be_shadowed = filter.shadow_enable;
        if surface.normal.dot(sample.coords.direction) <= 0.0
            || can_be_shadowed && self.is_back_facing(linked, surface, sample)
        {
            return LightState::FacingAway;
        }
        if !can_be_shadowed || self.has_line_of_sight((source, linked), surface, sample) {
            return LightState::Lit;
        }
        let found = self.first_occluder((source, linked), surface, sample);
        // What only rounding puts into the way lies on the surface itself.
        let (node, position) = found.map_or((surface.node, surface.position), |obstacle| {
            (self.bvh.triangles[obstacle.triangle].node, obstacle.position)
        });
        LightState::Shadowed(ProbedCaster { node, position: self.in_world(position) })
    }

    /// Where a point lies in a light, and the way of its light there.
    fn light_path(&self, rays: &LightRays, point: DVec3, sample: &LightSample) -> (ProbedPlace, Vec<DVec3>) {
        let place = sample.coords;
        let straight = |from: DVec3| vec![self.in_world(from), self.in_world(point)];
        let in_scene = |source: DVec3| source - self.bvh.posed.origin_in_world;
        match rays {
            LightRays::Bent(tube) => self.bent_light_path(tube, place),
            LightRays::Cone(cone) => {
                let from = in_scene(cone.translation);
                let radius = -(cone.rotation.transpose() * (point - from)).z * cone.tan_outer;
                (
                    ProbedPlace { coords: place, radius: Some(radius), path_length: Some(place.s) },
                    straight(from),
                )
            }
            LightRays::Omni(omni) => {
                let path_length = Some(place.s);
                (
                    ProbedPlace { coords: place, radius: None, path_length },
                    straight(in_scene(omni.translation)),
                )
            }
            LightRays::Parallel(parallel) => {
                let from = self.bvh.point_outside_scene(point, parallel.direction());
                (ProbedPlace { coords: place, radius: None, path_length: None }, straight(from))
            }
        }
    }

    fn bent_light_path(&self, tube: &Tube<f64>, place: LightCoords) -> (ProbedPlace, Vec<DVec3>) {
        let polyline = self.bvh.bent_path(tube, place.v, place.w).polyline(place.t, MAX_PATH_POINTS);
        let segment = (place.t as usize).min(tube.segments.len() - 1);
        let radius = tube.segments[segment].curve.radius(place.t - segment as f64);
        let place = ProbedPlace {
            coords: place,
            radius: Some(radius * tube.placement.world_per_tube),
            path_length: Some(polyline.length),
        };
        (place, polyline.points.into_iter().map(|point| self.in_world(point)).collect())
    }

    fn in_world(&self, position: DVec3) -> DVec3 {
        position + self.bvh.posed.origin_in_world
    }
}

/// Gives each light its share.
fn share_out(lights: &mut [LightProbe]) {
    let luminance = |light: &LightProbe| light.radiance.dot(LUMINANCE).min(f64::MAX);
    let largest = lights.iter().map(luminance).fold(0.0, f64::max);
    if largest == 0.0 {
        return;
    }
    // By the largest, so that their sum is a number whatever they are.
    let all: f64 = lights.iter().map(|light| luminance(light) / largest).sum();
    for light in lights {
        light.share = luminance(light) / largest / all;
    }
}
