//! Lights of the native backend, and its map painter.

use std::sync::Arc;

use light::{CheckedLight, LightRays};
use relight::DepthMap;

use crate::backend::Backend;
use crate::bendy_light;
use crate::lights::{LightSlot, MapBuilders, MapPainter};
use crate::linked::CasterSource;
use crate::map_key::MapKey;
use crate::native_slot::{FittedMap, MapFit, NativeMapBuilders, NativeSlot};
use crate::shadow_settings::MapSize;
use crate::straight::StraightLight;
use crate::{Gpu, RenderError, native_straight};

/// Light in the form that `relight` draws, with its shadow map if it casts shadows.
#[derive(Debug)]
pub(crate) struct NativeLight {
    pub light: relight::RelitLight,
    pub map: Option<Arc<DepthMap>>,
}

/// Draws shadow maps of lights in a scene on the CPU.
pub(crate) struct NativeMaps<'a>(pub &'a Gpu);

impl MapPainter for NativeMaps<'_> {
    type Light = NativeLight;
    const BACKEND: Backend = Backend::Native;

    fn slot(&self, _: &CheckedLight, size: MapSize) -> LightSlot {
        LightSlot::Native(Box::new(NativeSlot::new(size)))
    }

    fn prepare(
        &mut self,
        slot: &mut LightSlot,
        key: MapKey,
        light: &CheckedLight,
        source: CasterSource,
        builders: MapBuilders,
    ) -> Result<(NativeLight, bool), RenderError> {
        let LightSlot::Native(slot) = slot else { unreachable!("the slot was made for the processor") };
        let (Self(gpu), CasterSource { scene, shadows, .. }) = (self, source);
        let NativeMapBuilders { bent, straight: straight_builder } = builders.native_builders;
        let is_stale = slot.map_key() != Some(key);
        let is_shadowed = light.light_profile().shadow_enable;
        if is_stale {
            let mut map = slot.map();
            let fitted = match (StraightLight::of(light), light.rays()) {
                (Some(straight), _) => {
                    let fitted = straight.fit_map(scene, shadows);
                    if is_shadowed {
                        let placed = straight.placed(&fitted, scene, shadows);
                        native_straight::draw_map(gpu, straight_builder, straight, &placed, source, &mut map)?;
                    }
                    MapFit::Straight(fitted)
                }
                (None, LightRays::Bent(tube)) if is_shadowed => {
                    let shape = bendy_light::draw_map(gpu, bent, light, tube, source, &mut map)?;
                    MapFit::Bent(Some(Box::new(shape)))
                }
                (None, _) => MapFit::Bent(None),
            };
            slot.shown = Some((key, FittedMap { map: Arc::new(map), fitted }));
        }
        let Some((_, FittedMap { map, fitted })) = &slot.shown else { unreachable!("it was drawn or known") };
        let placed = match (StraightLight::of(light), light.rays(), fitted) {
            (Some(straight), _, MapFit::Straight(fitted)) => {
                native_straight::relit_light(straight.placed(fitted, scene, shadows), shadows.filter)
            }
            (None, LightRays::Bent(tube), MapFit::Bent(fitted)) => {
                let bent = bendy_light::placed(tube, scene, fitted.as_deref(), shadows);
                relight::RelitLight::Bent(Box::new(bent))
            }
            _ => unreachable!("a light keeps its shape while its key stays the same"),
        };
        let map = is_shadowed.then(|| Arc::clone(map));
        Ok((NativeLight { light: placed, map }, is_stale && is_shadowed))
    }
}
