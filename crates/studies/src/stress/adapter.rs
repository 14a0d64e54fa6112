//! Compares the GPU with the light model in f64: points located in a light, and points mapped for its shadows. Also
//! draws pictures with both backends for other checks.

use std::cell::RefCell;
use std::sync::Arc;

use glam::{DVec3, Vec4};
use light::{DirectionMode, LightInstance, Tube, TubeRoot};
use proptest::prelude::*;
use render::{Aov, Backend, Device, Gpu, Host, Picture, RenderError, Renderer, ShadowSettings, View};
use scene::Scene;

use super::light::{LightLimits, lights, placement};
use super::place::{RootBounds, bounds, eps, places, root_at, split};
use super::runner::{Check, CheckTally};
use super::solver::RootCase;

/// The GPU, with a renderer for each backend. Renderers are reused, because compiling pipelines for a new one takes
/// longer than drawing.
pub struct Adapter {
    pub gpu: Arc<Gpu>,
    /// One per backend.
    renderers: [(Backend, RefCell<Renderer>); 2],
}

/// A picture that a property of the stress study draws.
#[derive(Clone, Copy)]
pub struct StressPicture<'a> {
    pub scene: &'a Scene,
    pub view: &'a View,
    pub lights: &'a [LightInstance],
    pub shadows: ShadowSettings,
}

impl Adapter {
    /// Opens the best device, and a renderer per backend.
    pub fn open() -> Result<Self, RenderError> {
        let gpu = Arc::new(Gpu::open(Host::default())?);
        let renderer = |device: &Device| Renderer::new(device).map(RefCell::new);
        let (on_gpu, on_cpu) = (Device::Wgpu(Arc::clone(&gpu)), Device::open(Host::default(), Some(Backend::Native))?);
        // The CPU comes first, so a deliberate fault is reported for its pictures.
        let renderers = [(Backend::Native, renderer(&on_cpu)?), (Backend::Wgpu, renderer(&on_gpu)?)];
        Ok(Self { gpu, renderers })
    }

    /// Applies `check` to the pictures of the given AOVs from each backend.
    pub fn check_pictures<const N: usize>(
        &self,
        shown: StressPicture,
        aovs: [Aov; N],
        mut check: impl FnMut([Picture; N]) -> Check,
    ) -> Check {
        self.check_backends(shown, |renderer| {
            let draw = |aov| renderer.render(&View { aov, ..shown.view.clone() }, shown.lights);
            let pictures: Result<Vec<_>, _> = aovs.into_iter().map(draw).collect();
            check(pictures.map_err(|error| no_picture(&error))?.try_into().expect("a picture an AOV"))
        })
    }

    /// Applies `check` to the displayed picture of each backend: RGBA of 8 bits per channel.
    pub fn check_display(&self, shown: StressPicture, mut check: impl FnMut(&[[u8; 4]]) -> Check) -> Check {
        self.check_backends(shown, |renderer| {
            let bytes = renderer.render_display(shown.view, shown.lights).map_err(|error| no_picture(&error))?;
            check(bytes.as_chunks().0)
        })
    }

    fn check_backends(&self, shown: StressPicture, mut check: impl FnMut(&mut Renderer) -> Check) -> Check {
        let posed = scene::pose(shown.scene.clone(), 0.0);
        for (backend, renderer) in &self.renderers {
            let mut renderer = renderer.borrow_mut();
            renderer.set_shadow_settings(shown.shadows).map_err(|error| no_picture(&error))?;
            renderer.set_scene(&posed).map_err(|error| no_picture(&error))?;
            check(&mut renderer).map_err(|why| format!("by the backend {}, {why}", backend.name()))?;
        }
        Ok(())
    }
}

fn no_picture(error: &RenderError) -> String {
    format!("no picture can be made: {error}")
}

/// Generates lights at any position and orientation in the world, each with up to 255 points. Those are enough points
/// to use several workgroups of a dispatch.
pub fn cases() -> impl Strategy<Value = RootCase> {
    let lights = lights(LightLimits { segments: 8, fold: 1.0, pinched: true, flipping: true });
    let places = prop::collection::vec(places(), 1..256);
    (lights, placement(), places).prop_map(|(light, transform, places)| RootCase::new(light, transform, &places))
}

/// Root of a point that the GPU found: (V, W, R) in tube units, t, and optionally the direction in the world.
struct AdapterRoot {
    t: f64,
    vwr: [f64; 3],
    direction: Option<DVec3>,
}

/// Checks the roots that the lighting shaders find.
pub fn check_locate(case: &RootCase, adapter: &Adapter, tally: &mut CheckTally) -> Check {
    let tube = Tube::new(&case.light).expect("cases are valid");
    let points: Vec<DVec3> = case.points.iter().map(|&p| p.into()).collect();
    let located = render::locate(&adapter.gpu, &tube, &points).map_err(|error| error.to_string())?;
    for (&point, location) in points.iter().zip(&located) {
        let q = tube.placement.tube_from_world(point);
        let size = tube.placement.world_per_tube;
        let found = location.point.map(|p| {
            let radius = p.radius / size;
            let v = if tally.is_planted { -p.v } else { p.v };
            let direction = (tube.direction == DirectionMode::Tube).then_some(p.direction);
            AdapterRoot { t: p.t, vwr: [v * radius, p.w * radius, radius], direction }
        });
        agrees(&tube, q, 0.0, found.as_ref(), tally)?;
    }
    Ok(())
}

/// Checks the vertices that the shaders of the shadow map compute.
pub fn check_shadow_map(case: &RootCase, adapter: &Adapter, tally: &mut CheckTally) -> Check {
    let tube = Tube::new(&case.light).expect("cases are valid");
    let points: Vec<DVec3> = case.points.iter().map(|&p| p.into()).collect();
    let mapped = render::map_points(&adapter.gpu, &tube, &points).map_err(|error| error.to_string())?;
    let bound = |pick: fn(DVec3, DVec3) -> DVec3| points.iter().copied().reduce(pick).unwrap_or_default();
    // Positions are rounded relative to their distance from the center of all points, and so is the offset from there
    // to the light.
    let (min, max) = (bound(DVec3::min), bound(DVec3::max));
    let middle = tube.placement.tube_from_world((min + max) / 2.0);
    let reach = (max - min).length() / 2.0 / tube.placement.world_per_tube + middle.length();
    for (&point, mapped) in points.iter().zip(&mapped) {
        // Points whose slabs belong to two parts of the tube are mapped only after clipping.
        let Some(mapped) = mapped.map(Vec4::as_dvec4) else { continue };
        let w = if tally.is_planted { -mapped.y } else { mapped.y };
        let found = AdapterRoot { t: mapped.w, vwr: [mapped.x, w, mapped.z], direction: None };
        if mapped.x.hypot(mapped.y) <= mapped.z {
            agrees(&tube, tube.placement.tube_from_world(point), 4.0 * eps::<f32>() * reach, Some(&found), tally)?;
        }
    }
    Ok(())
}

/// True if rounding can put a root's point on the other side of the rim or of an end.
fn on_edge(tube: &Tube<f64>, root: &TubeRoot<f64>, bound: &RootBounds) -> bool {
    let t = root.segment as f64 + root.u;
    let ends = t < bound.t || (tube.segments.len() == tube.n && tube.n as f64 - t < bound.t);
    root.radius - root.r.length() < 4.0 * (bound.across + bound.radius) || ends
}

/// Compares a result with the root of the f64 model that is nearest in t. `dq` is the rounding error of the point on
/// the GPU.
fn agrees(tube: &Tube<f64>, q: DVec3, dq: f64, found: Option<&AdapterRoot>, tally: &mut CheckTally) -> Check {
    let mut roots = Vec::new();
    tube.for_each_root(q, |root| roots.push(root));
    let eps = eps::<f32>();
    let Some(found) = found else {
        let clear =
            roots.iter().find(|root| bounds(tube, root, q, eps, dq).is_some_and(|bound| !on_edge(tube, root, &bound)));
        return tally.holds(clear.is_none(), || {
            let t = clear.map(|root| root.segment as f64 + root.u);
            format!("the adapter does not find the root t = {t:?} of q = {:?}", q.to_array())
        });
    };
    tally.holds(found.vwr.into_iter().chain([found.t]).all(f64::is_finite), || {
        format!("the adapter finds t = {}, (V, W, R) = {:?} for q = {:?}", found.t, found.vwr, q.to_array())
    })?;
    let off = |root: &TubeRoot<f64>| (root.segment as f64 + root.u - found.t).abs();
    let nearest = roots.into_iter().min_by(|a, b| off(a).total_cmp(&off(b)));
    let known = nearest.map(|root| (root, bounds(tube, &root, q, eps, dq)));
    let (root, bound) = match known {
        Some((_, None)) => return Ok(()),
        Some((root, Some(bound))) if off(&root) <= bound.t => (root, bound),
        _ => return is_rounding_only(tube, q, found.t, dq, tally),
    };
    if on_edge(tube, &root, &bound) {
        return Ok(());
    }
    let place = format!("at q = {:?}, where t = {:?}", q.to_array(), root.segment as f64 + root.u);
    let [v, w, radius] = found.vwr;
    tally.within(format_args!("t {place}"), off(&root), bound.t)?;
    tally.within(format_args!("V {place}"), (v - root.v_len).abs(), bound.across)?;
    tally.within(format_args!("W {place}"), (w - root.w_len).abs(), bound.across)?;
    tally.within(format_args!("R {place}"), (radius - root.radius).abs(), bound.radius)?;
    // The curvature jumps at a joint, and with it the effect of rounding on the direction.
    let same_side = split(tube, found.t).0 == root.segment;
    let Some(direction) = found.direction.filter(|_| same_side) else { return Ok(()) };
    let error = (direction - tube.tube_point(&root).direction).length();
    tally.within(format_args!("the direction {place}"), error, bound.direction)
}

/// Checks that rounding can explain a root that the f64 model does not have: at the rim, an end or a joint.
fn is_rounding_only(tube: &Tube<f64>, q: DVec3, t: f64, dq: f64, tally: &mut CheckTally) -> Check {
    let (segment, u) = split(tube, t);
    let claimed = root_at(tube, segment, u, q);
    let may_be = bounds(tube, &claimed, q, eps::<f32>(), dq)
        .is_none_or(|bound| on_edge(tube, &claimed, &bound) || (t - t.round()).abs() <= bound.t);
    tally.holds(may_be, || format!("the adapter finds t = {t} for q = {:?}, where no root is", q.to_array()))
}
