//! Whole pictures.

use glam::{DVec2, DVec3};
use light::{LightCoords, LightInstance};
use rayon::prelude::*;
use scene::{Aov, View};

use crate::samples::sample_in_pixel;
use crate::{LinkedReferenceLight, Reference, ReferenceError, ShadedPoint, evaluate_brdf};

/// Picture of linear values, with the meaning that [`Aov`] states.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferencePicture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Pixels in rows from the top, `width * height` of them.
    pub pixels: Vec<[f64; 4]>,
}

impl Reference {
    /// Renders `view` under `lights` on all cores. Calls `row_done` once for each row, from any thread.
    pub fn render(
        &self,
        view: &View,
        lights: &[LightInstance],
        row_done: impl Fn() + Sync,
    ) -> Result<ReferencePicture, ReferenceError> {
        if view.width == 0 || view.height == 0 || view.samples == 0 {
            return Err(ReferenceError::EmptyView);
        }
        view.camera.check().map_err(ReferenceError::Camera)?;
        if !View::FILL_RANGE.contains(&view.fill) {
            return Err(ReferenceError::Fill(view.fill));
        }
        let source = |instance: &LightInstance| LinkedReferenceLight::new(&self.bvh.posed, &instance.light);
        let sources: Vec<_> = required_lights(view, lights)?.iter().map(source).collect();
        let mut pixels = vec![[0.0; 4]; view.width as usize * view.height as usize];
        pixels.par_chunks_exact_mut(view.width as usize).enumerate().for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                *pixel = self.pixel(view, &sources, DVec2::new(x as f64, y as f64));
            }
            row_done();
        });
        Ok(ReferencePicture { width: view.width, height: view.height, pixels })
    }

    fn pixel(&self, view: &View, sources: &[LinkedReferenceLight], corner: DVec2) -> [f64; 4] {
        let samples = if view.aov.can_be_multisampled() { view.samples } else { 1 };
        let mut sum = [0.0; 4];
        for index in 0..samples {
            let at = corner + sample_in_pixel(index, samples);
            let value = self.surface(view, at).and_then(|surface| self.value(view, sources, &surface));
            for (total, channel) in sum.iter_mut().zip(value.unwrap_or_default()) {
                *total += channel / f64::from(samples);
            }
        }
        sum
    }

    /// Returns the AOV's value at a surface. `None` if the AOV belongs to a light and the surface is outside this
    /// light.
    fn value(&self, view: &View, sources: &[LinkedReferenceLight], surface: &ShadedPoint) -> Option<[f64; 4]> {
        let first = || {
            let LinkedReferenceLight { source, linked } = sources.first()?;
            Some(self.sample_unshadowed(source, linked, surface)?.coords)
        };
        let value = match view.aov {
            Aov::Beauty => self.radiance(sources, view.fill, surface),
            Aov::Depth => DVec3::splat(surface.depth),
            Aov::Normal => surface.normal,
            Aov::Position => self.in_world(surface.position),
            Aov::T => DVec3::splat(first()?.t),
            Aov::Vw => {
                let LightCoords { v, w, .. } = first()?;
                DVec3::new(v, w, 0.0)
            }
            Aov::Direction => first()?.direction,
            Aov::Visibility => {
                let LinkedReferenceLight { source, linked } = sources.first()?;
                DVec3::splat(if self.sample_linked(source, linked, surface)?.is_visible { 1.0 } else { 0.0 })
            }
            Aov::Wireframe => return None,
        };
        Some(value.extend(1.0).to_array())
    }

    /// Computes the radiance towards the viewer under `sources`, plus `fill` times the scene's fill light,
    /// linear RGB.
    pub fn radiance(&self, sources: &[LinkedReferenceLight], fill: f64, surface: &ShadedPoint) -> DVec3 {
        let lit: DVec3 = sources
            .iter()
            .map(|LinkedReferenceLight { source, linked }| {
                let Some(light) = self.sample_unshadowed(source, linked, surface) else { return DVec3::ZERO };
                let profile = source.light_profile();
                let lobes = [profile.diffuse, profile.specular];
                let radiance = evaluate_brdf(surface, light.coords.direction, lobes) * light.irradiance;
                // The shadow is traced only if it can have an effect.
                let lit = radiance != DVec3::ZERO && self.is_lit(source, linked, surface, &light);
                radiance * profile.arriving(if lit { 1.0 } else { 0.0 })
            })
            .sum();
        lit + self.fill(surface) * fill
    }

    /// Computes the radiance of the fill light: a hemisphere that changes from `ground` to `sky` with the
    /// height of a direction. Dielectrics reflect the light around the normal, metals that around the reflected
    /// ray.
    pub(crate) fn fill(&self, surface: &ShadedPoint) -> DVec3 {
        let fill = &self.bvh.posed.scene.fill;
        let hemisphere = |toward: DVec3| fill.ground.lerp(fill.sky, toward.y * 0.5 + 0.5);
        let n = surface.normal;
        let mirrored = n * (2.0 * n.dot(surface.to_eye)) - surface.to_eye;
        let specular = hemisphere(mirrored.lerp(n, surface.roughness));
        surface.base_color * hemisphere(n).lerp(specular, surface.metallic)
    }
}

/// Returns the lights that the view needs: all, the AOV's light, or none.
fn required_lights<'a>(view: &View, lights: &'a [LightInstance]) -> Result<&'a [LightInstance], ReferenceError> {
    let (index, count) = (view.light, lights.len());
    match view.aov {
        Aov::Beauty => Ok(lights),
        Aov::Wireframe => Err(ReferenceError::NoShadowMap),
        aov if !aov.is_per_light() => Ok(&[]),
        _ => lights.get(index..=index).ok_or(ReferenceError::NoSuchLight { index, count }),
    }
}
