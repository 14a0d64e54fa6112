//! The WGSL modules, concatenated from the files in `shaders/`.

macro_rules! wgsl {
    ($($name:literal),+ $(,)?) => {
        concat!($(include_str!(concat!("shaders/", $name, ".wgsl")), "\n"),+)
    };
}

/// Lighting pass of a light, whose own files follow those that all lights share.
macro_rules! light_wgsl {
    ($($own:literal),+) => {
        concat!(
            wgsl!("view", "encoding", "surface", "fullscreen", "brdf", "profile", "lighting"),
            wgsl!("alpha_test", "nearby", "shadow_filter", $($own),+)
        )
    };
}

pub(crate) const GBUFFER: &str = concat!("enable primitive_index;\n", wgsl!("view", "encoding", "material", "gbuffer"));
pub(crate) const FILL: &str = wgsl!("view", "encoding", "surface", "fullscreen", "fill");
/// Shows AOVs of the surface.
pub(crate) const INSPECT: &str = wgsl!("view", "encoding", "surface", "fullscreen", "inspect");
pub(crate) const SHADOW: &str = wgsl!("shadow");
/// Draws shadow casters with an alpha test.
pub(crate) const SHADOW_MASKED: &str = wgsl!("shadow", "material", "shadow_masked");
/// Selects triangles for a light with links.
const LINKS: &str = wgsl!("links");
/// Replaces `LINKS` for a light without links.
const NO_LINKS: &str = wgsl!("no_links");
const SUBGROUPS: &str = wgsl!("subgroups");
/// Replaces `SUBGROUPS` on devices without them.
const NO_SUBGROUPS: &str = wgsl!("no_subgroups");
pub(crate) const SPOT: &str = light_wgsl!("cone", "spot_faces", "spot");
pub(crate) const OMNI: &str = light_wgsl!("omni", "omni_lookup");
pub(crate) const DIRECTIONAL: &str = light_wgsl!("parallel", "parallel_lookup");
pub(crate) const BENDY: &str =
    light_wgsl!("curve", "frame", "solve", "arc", "emission", "segment", "tube", "bent_lookup", "bendy");
pub(crate) const LOCATE: &str =
    wgsl!("curve", "frame", "solve", "arc", "emission", "segment", "profile", "tube", "locate");
/// Solves for the nearest points of curves, for measurements.
pub(crate) const INCREASING_ROOTS: &str = wgsl!("curve", "solve", "increasing_roots");
pub(crate) const BENT_MAP_VERTICES: &str = wgsl!("curve", "frame", "solve", "bent_map", "bent_map_vertices");
/// Classifies triangles: drawn as they are, or passed on.
pub(crate) const BENT_MAP_TRIANGLES: &str = wgsl!("curve", "frame", "solve", "bent_map", "bent_map_triangles");
pub(crate) const BENT_MAP_CLIP: &str = wgsl!("curve", "frame", "solve", "bent_map", "bent_map_clip");
/// Splits triangles that are not straight in the map.
pub(crate) const BENT_MAP_SPLIT: &str = wgsl!("curve", "frame", "solve", "bent_map", "bent_map_split");
/// Counts workgroups between those passes.
pub(crate) const BENT_MAP_NEXT: &str = wgsl!("curve", "frame", "solve", "bent_map", "bent_map_next");
/// Draws mapped triangles.
pub(crate) const BENT_SHADOW: &str = wgsl!("bent_shadow");
/// Draws mapped triangles with an alpha test.
pub(crate) const BENT_MASKED: &str = wgsl!("bent_shadow", "alpha_test", "bent_masked");
/// Draws mapped triangles with their edges.
pub(crate) const WIREFRAME: &str = wgsl!("wireframe");
/// Tone-maps for a screen.
pub(crate) const DISPLAY: &str = wgsl!("encoding", "fullscreen", "display");
/// Sums layers and tone-maps the result.
pub(crate) const COMPOSITE: &str = wgsl!("encoding", "fullscreen", "display", "terms", "composite");
pub(crate) const SUM: &str = wgsl!("encoding", "fullscreen", "terms", "sum");

/// Returns the complete module of a lighting pass, for lights with or without links, and for devices with or without
/// subgroups.
pub(crate) fn lighting_pass(wgsl: &str, linked: bool, has_subgroups: bool) -> String {
    let links = if linked { LINKS } else { NO_LINKS };
    let subgroups = if has_subgroups { SUBGROUPS } else { NO_SUBGROUPS };
    format!("{links}{subgroups}{wgsl}")
}

#[cfg(test)]
mod branches;
#[cfg(test)]
mod compiled;
#[cfg(test)]
mod twins;

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};
    use std::mem::offset_of;

    use hierarchy::HierarchyNode;
    use wgpu::naga::valid::{Capabilities, ValidationFlags, Validator};
    use wgpu::naga::{AddressSpace, Function, Handle, Module, Statement, TypeInner, front::wgsl};

    use super::compiled::{all, statements};
    use crate::wgpu::bendy_light;
    use crate::wgpu::gpu_structs::{self, StructLayout};

    fn parse(name: &str, source: &str) -> Module {
        wgsl::parse_str(source).unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(source)))
    }

    fn modules() -> Vec<(&'static str, Module)> {
        all().iter().map(|(name, source)| (*name, parse(name, source))).collect()
    }

    #[test]
    fn every_module_is_valid() {
        let modules = modules();
        assert!(modules.len() >= 7);
        let capabilities = Capabilities::PRIMITIVE_INDEX | Capabilities::SUBGROUP;
        for (name, module) in &modules {
            assert!(!module.entry_points.is_empty(), "{name} has no entry point");
            Validator::new(ValidationFlags::all(), capabilities)
                .validate(module)
                .unwrap_or_else(|e| panic!("{name}: {e:?}"));
        }
    }

    /// Returns the names of the functions of `module`, and of those that an entry point calls.
    fn functions(module: &Module) -> (BTreeSet<&str>, BTreeSet<&str>) {
        let calls = |block| {
            let called = |statement: &Statement| match statement {
                Statement::Call { function, .. } => Some(*function),
                _ => None,
            };
            statements(block).into_iter().filter_map(called)
        };
        let mut open: Vec<_> = module.entry_points.iter().flat_map(|entry| calls(&entry.function.body)).collect();
        let mut reached = BTreeSet::new();
        while let Some(handle) = open.pop() {
            if reached.insert(handle) {
                open.extend(calls(&module.functions[handle].body));
            }
        }
        let name = |handle: Handle<Function>| module.functions[handle].name.as_deref().unwrap_or_default();
        (module.functions.iter().map(|(h, _)| name(h)).collect(), reached.into_iter().map(name).collect())
    }

    #[test]
    fn no_function_is_unreachable() {
        let modules = modules();
        let (mut all, mut reached) = (BTreeSet::new(), BTreeSet::new());
        for (_, module) in &modules {
            let (here, reached_here) = functions(module);
            all.extend(here);
            reached.extend(reached_here);
        }
        assert!(all.len() >= 10);
        assert_eq!(all.difference(&reached).collect::<Vec<_>>(), Vec::<&&str>::new());
        // Deliberate fault that the check must detect: a function that no entry point calls.
        let module = parse("fault", "fn lost() {} fn used() {} @compute @workgroup_size(1) fn main() { used(); }");
        assert_eq!(functions(&module), (["lost", "used"].into(), ["used"].into()));
    }

    /// Layout of the node that the crate `hierarchy` shares with `nearby.wgsl`.
    const HIERARCHY_NODE: StructLayout = (
        "HierarchyNode",
        size_of::<HierarchyNode>(),
        &[
            ("min", offset_of!(HierarchyNode, min)),
            ("count", offset_of!(HierarchyNode, count)),
            ("max", offset_of!(HierarchyNode, max)),
            ("next", offset_of!(HierarchyNode, next)),
        ],
    );

    fn rust_structs() -> impl Iterator<Item = &'static StructLayout> {
        gpu_structs::LAYOUTS.iter().chain(bendy_light::gpu_structs::LAYOUTS).chain([&HIERARCHY_NODE])
    }

    /// Size, and the name and offset of each field.
    type WgslLayout = (usize, Vec<(String, usize)>);

    fn structs(module: &Module) -> BTreeMap<String, WgslLayout> {
        let of_type = |inner: &TypeInner| match inner {
            TypeInner::Struct { members, span } => {
                let member = |m: &wgpu::naga::StructMember| (m.name.clone().unwrap_or_default(), m.offset as usize);
                Some((*span as usize, members.iter().map(member).collect()))
            }
            _ => None,
        };
        module.types.iter().filter_map(|(_, t)| Some((t.name.clone()?, of_type(&t.inner)?))).collect()
    }

    /// Returns the difference between a struct in Rust and in WGSL; `None` if they agree.
    fn difference(rust: &StructLayout, wgsl: &BTreeMap<String, WgslLayout>) -> Option<String> {
        let (name, size, fields) = rust;
        let Some((wgsl_size, wgsl_fields)) = wgsl.get(*name) else {
            return Some(format!("{name} is in no module"));
        };
        let fields: Vec<_> = fields.iter().filter(|f| !f.0.starts_with("pad")).map(|f| (f.0.to_owned(), f.1)).collect();
        (wgsl_size != size || *wgsl_fields != fields)
            .then(|| format!("{name}: Rust has {size} {fields:?}, WGSL has {wgsl_size} {wgsl_fields:?}"))
    }

    #[test]
    fn rust_and_wgsl_agree_on_layouts() {
        let modules = modules();
        let wgsl: BTreeMap<_, _> = modules.iter().flat_map(|(_, m)| structs(m)).collect();
        for rust in rust_structs() {
            assert_eq!(difference(rust, &wgsl), None);
        }
        // Deliberate faults that the check must detect: a field that moved, and one with another name.
        assert!(difference(&("Fill", 32, &[("sky", 0), ("ground", 12)]), &wgsl).is_some());
        assert!(difference(&("Fill", 32, &[("sky", 0), ("earth", 16)]), &wgsl).is_some());
    }

    #[test]
    fn every_shared_struct_has_its_twin() {
        for (name, module) in modules() {
            for (_, variable) in module.global_variables.iter() {
                let shared = matches!(variable.space, AddressSpace::Uniform | AddressSpace::Storage { .. });
                let ty = &module.types[variable.ty];
                if shared && matches!(ty.inner, TypeInner::Struct { .. }) {
                    let struct_name = ty.name.as_deref().unwrap_or_default();
                    assert!(rust_structs().any(|s| s.0 == struct_name), "{name}: {struct_name}");
                }
            }
        }
    }
}
