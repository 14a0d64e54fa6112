//! Lights as the processor draws them, and who draws their maps.

use std::sync::Arc;

use light::{CheckedLight, Rays};
use relight::DepthMap;

use crate::backend::Backend;
use crate::bendy_light;
use crate::gpu_scene::GpuScene;
use crate::lights::{LightSlot, MapPainter, MapWork};
use crate::linked::Linked;
use crate::map_key::MapKey;
use crate::native_slot::{Fit, NativeSlot, Shown};
use crate::shadow_settings::MapSize;
use crate::straight::Straight;
use crate::{Gpu, RenderError, ShadowSettings, native_straight};

/// A light in place, with its map where anything shadows it.
#[derive(Debug)]
pub(crate) struct NativeLight {
    pub light: relight::Light,
    pub map: Option<Arc<DepthMap>>,
}

/// Draws maps of lights over a scene.
pub(crate) struct NativeMaps<'a> {
    pub gpu: &'a Gpu,
    pub scene: &'a GpuScene,
}

impl MapPainter for NativeMaps<'_> {
    type Light = NativeLight;
    const BACKEND: Backend = Backend::Native;

    fn slot(&self, _: &CheckedLight, size: MapSize) -> LightSlot {
        LightSlot::Native(Box::new(NativeSlot::new(size)))
    }

    fn prepare(
        &mut self,
        slot: &mut LightSlot,
        (key, light): (MapKey, &CheckedLight),
        (linked, shadows): (Option<&Linked>, &ShadowSettings),
        MapWork { native_work, coarse, .. }: MapWork,
    ) -> Result<(NativeLight, bool), RenderError> {
        let LightSlot::Native(slot) = slot else { unreachable!("the slot was made for the processor") };
        let Self { gpu, scene } = *self;
        let is_stale = slot.shows() != Some(key);
        let is_shadowed = light.light_filter().shadow_enable;
        let what = (scene, linked, shadows);
        if is_stale {
            let mut map = slot.map();
            let fitted = match (Straight::of(light), light.rays()) {
                (Some(straight), _) => {
                    let fitted = straight.fitted(scene, shadows);
                    if is_shadowed {
                        let placed = straight.placed(&fitted, scene, shadows);
                        let work = &mut native_work.straight;
                        native_straight::draw_map((gpu, work), (straight, &placed), what, &mut map)?;
                    }
                    Fit::Straight(fitted)
                }
                (None, Rays::Bent(tube)) if is_shadowed => {
                    let work = &mut native_work.bent;
                    let drawn = bendy_light::draw_map((gpu, work), (light, tube), what, coarse, &mut map)?;
                    Fit::Bent(Some(Box::new(drawn)))
                }
                (None, _) => Fit::Bent(None),
            };
            slot.shown = Some((key, Shown { map: Arc::new(map), fitted }));
        }
        let Some((_, Shown { map, fitted })) = &slot.shown else { unreachable!("it was drawn or known") };
        let placed = match (Straight::of(light), light.rays(), fitted) {
            (Some(straight), _, Fit::Straight(fitted)) => {
                native_straight::in_lanes(&straight.placed(fitted, scene, shadows), shadows.filter)
            }
            (None, Rays::Bent(tube), Fit::Bent(fitted)) => {
                let shown = (fitted.as_deref(), shadows);
                relight::Light::Bent(Box::new(bendy_light::placed(tube, scene, shown)))
            }
            _ => unreachable!("a light keeps its shape while its key stays the same"),
        };
        let map = is_shadowed.then(|| Arc::clone(map));
        Ok((NativeLight { light: placed, map }, is_stale && is_shadowed))
    }
}
