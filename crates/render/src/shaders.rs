//! The WGSL modules, put together from `shaders/`.

macro_rules! wgsl {
    ($($name:literal),+ $(,)?) => {
        concat!($(include_str!(concat!("shaders/", $name, ".wgsl")), "\n"),+)
    };
}

/// Fills the G-buffer.
pub(crate) const GBUFFER: &str =
    concat!("enable primitive_index;\n", wgsl!("view", "encoding", "material", "gbuffer"));
/// Adds the fill light.
pub(crate) const FILL: &str = wgsl!("view", "encoding", "surface", "fullscreen", "fill");
/// Shows quantities of the surface.
pub(crate) const INSPECT: &str = wgsl!("view", "encoding", "surface", "fullscreen", "inspect");
/// Draws opaque shadow casters.
pub(crate) const SHADOW: &str = wgsl!("shadow");
/// Draws shadow casters with an alpha test.
pub(crate) const SHADOW_MASKED: &str = wgsl!("shadow", "material", "shadow_masked");
/// Adds a spotlight.
pub(crate) const SPOT: &str = wgsl!("view", "encoding", "surface", "fullscreen", "brdf", "lighting", "spot");
/// Adds a BendyLight.
pub(crate) const BENDY: &str =
    wgsl!("view", "encoding", "surface", "fullscreen", "brdf", "lighting", "curve", "tube", "bendy");
/// Locates points in a BendyLight.
pub(crate) const LOCATE: &str = wgsl!("curve", "tube", "locate");
/// Maps vertices into a bent shadow map.
pub(crate) const BENT_MAP_VERTICES: &str = wgsl!("curve", "bent_map", "bent_map_vertices");
/// Sorts out which triangles need more.
pub(crate) const BENT_MAP_TRIANGLES: &str = wgsl!("curve", "bent_map", "bent_map_triangles");
/// Clips those to slabs.
pub(crate) const BENT_MAP_CLIP: &str = wgsl!("curve", "bent_map", "bent_map_clip");
/// Splits what is not straight in the map.
pub(crate) const BENT_MAP_SPLIT: &str = wgsl!("curve", "bent_map", "bent_map_split");
/// Counts workgroups between those.
pub(crate) const BENT_MAP_NEXT: &str = wgsl!("curve", "bent_map", "bent_map_next");
/// Draws mapped triangles.
pub(crate) const BENT_SHADOW: &str = wgsl!("bent_shadow");
/// Tone-maps for a screen.
pub(crate) const DISPLAY: &str = wgsl!("encoding", "fullscreen", "display");

/// Every module; the shader tests walk it.
#[cfg(test)]
const ALL: &[(&str, &str)] = &[
    ("gbuffer", GBUFFER),
    ("fill", FILL),
    ("inspect", INSPECT),
    ("shadow", SHADOW),
    ("shadow_masked", SHADOW_MASKED),
    ("spot", SPOT),
    ("bendy", BENDY),
    ("locate", LOCATE),
    ("bent_map_vertices", BENT_MAP_VERTICES),
    ("bent_map_triangles", BENT_MAP_TRIANGLES),
    ("bent_map_clip", BENT_MAP_CLIP),
    ("bent_map_split", BENT_MAP_SPLIT),
    ("bent_map_next", BENT_MAP_NEXT),
    ("bent_shadow", BENT_SHADOW),
    ("display", DISPLAY),
];
