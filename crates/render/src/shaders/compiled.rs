//! Every compiled module, for tests.

use super::{
    BENDY, BENT_MAP_CLIP, BENT_MAP_NEXT, BENT_MAP_SPLIT, BENT_MAP_TRIANGLES, BENT_MAP_VERTICES, BENT_MASKED,
    BENT_SHADOW, COMPOSITE, DISPLAY, FILL, GBUFFER, INCREASING_ROOTS, INSPECT, LOCATE, SHADOW, SHADOW_MASKED,
    SUM, WIREFRAME, lighting_pass,
};
use crate::bendy_light::Baked;
use crate::composite::TermKind;
use crate::straight::BakedStraight;

/// Returns every module by name; those of lights with several sets of constants.
pub(super) fn all() -> Vec<(&'static str, String)> {
    let fixed = [
        ("gbuffer", GBUFFER),
        ("fill", FILL),
        ("inspect", INSPECT),
        ("shadow", SHADOW),
        ("shadow_masked", SHADOW_MASKED),
        ("increasing_roots", INCREASING_ROOTS),
        ("bent_map_vertices", BENT_MAP_VERTICES),
        ("bent_map_triangles", BENT_MAP_TRIANGLES),
        ("bent_map_clip", BENT_MAP_CLIP),
        ("bent_map_split", BENT_MAP_SPLIT),
        ("bent_map_next", BENT_MAP_NEXT),
        ("bent_shadow", BENT_SHADOW),
        ("bent_masked", BENT_MASKED),
        ("wireframe", WIREFRAME),
        ("display", DISPLAY),
    ];
    let baked = Baked::samples().into_iter();
    let each = |wgsl: String| {
        [(false, false), (false, true), (true, false), (true, true)]
            .map(|(linked, has_subgroups)| lighting_pass(&wgsl, linked, has_subgroups))
    };
    let baked = baked.flat_map(|b| {
        let bendy = each(b.into_wgsl(BENDY)).map(|wgsl| ("bendy", wgsl));
        bendy.into_iter().chain([("locate", b.into_wgsl(LOCATE))])
    });
    let summed = [("composite", COMPOSITE), ("sum", SUM)];
    let summed =
        summed.into_iter().flat_map(|(name, wgsl)| TermKind::ALL.map(|of| (name, of.into_wgsl(wgsl))));
    let straight = BakedStraight::all().map(BakedStraight::wgsl);
    let straight = straight.flat_map(|(name, wgsl)| each(wgsl).map(|wgsl| (name, wgsl)));
    fixed
        .map(|(name, wgsl)| (name, wgsl.to_owned()))
        .into_iter()
        .chain(summed)
        .chain(straight)
        .chain(baked)
        .collect()
}
