//! Every compiled module, for tests.

use wgpu::naga::{Block, Statement};

use super::*;
use crate::wgpu::bendy_light::Baked;
use crate::wgpu::composite::TermKind;
use crate::wgpu::lighting::LightConstants;
use crate::wgpu::straight::BakedStraight;

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
    let summed = summed.into_iter().flat_map(|(name, wgsl)| TermKind::ALL.map(|of| (name, of.into_wgsl(wgsl))));
    let straight = BakedStraight::all().map(LightConstants::wgsl);
    let straight = straight.flat_map(|(name, wgsl)| each(wgsl).map(|wgsl| (name, wgsl)));
    fixed.map(|(name, wgsl)| (name, wgsl.to_owned())).into_iter().chain(summed).chain(straight).chain(baked).collect()
}

/// Returns the statements of a block, each followed by those of the blocks in it.
pub(super) fn statements<'a>(block: &'a Block) -> Vec<&'a Statement> {
    let with_inner = |statement: &'a Statement| {
        let inner: Vec<&Block> = match statement {
            Statement::Block(inner) => vec![inner],
            Statement::If { accept, reject, .. } => vec![accept, reject],
            Statement::Loop { body, continuing, .. } => vec![body, continuing],
            Statement::Switch { cases, .. } => cases.iter().map(|case| &case.body).collect(),
            _ => Vec::new(),
        };
        std::iter::once(statement).chain(inner.into_iter().flat_map(statements))
    };
    block.iter().flat_map(with_inner).collect()
}
