//! Probes in JSON: reasons that a pixel is lit or not, light by light (SPEC, section 7).

use glam::DVec3;
use reference::{DisabledBy, LightProbe, LightState, Probe};
use scene::PosedScene;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::conversion::same_variants;
use crate::{Camera, Problem, Vec3};

/// Body of `POST /sessions/S/probe`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ProbeRequest {
    /// Camera of the picture. Default: the document's first camera, or one that sees the whole scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<ProbeCamera>,
    /// Width and height of the picture, in pixels.
    pub size: [u32; 2],
    /// Position in pixels from the picture's top left corner. The centre of a pixel is at .5.
    pub pixel: [f64; 2],
    /// True if the answer also has the positions of highlights.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub highlights: bool,
}

/// Camera of a probe.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum ProbeCamera {
    /// Camera given in the request. It need not belong to the document.
    Own(Camera),
    /// Camera of the document, by its id.
    Id(u64),
}

/// Answer to `probe`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct ProbeAnswer {
    /// Name of the probe, chosen by the client.
    pub probe: String,
    /// Sequence number of the latest record in the probed document. Drags in progress are applied on top.
    pub log_seq: u64,
    /// Number of gesture changes in the session at that time. Frames carry it.
    pub live_revision: u32,
    /// Result; `null` if the probe is refused.
    pub found: Option<Probed>,
    /// Reason of the refusal; `null` if the probe has a result.
    pub refused: Option<Problem>,
}

/// [`Probe`] in JSON: surface and lights at a point of a picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct Probed {
    /// Nearest visible surface; `null` if there is only background.
    pub seen: Option<ProbedSurface>,
    /// All lights, sorted by id. Empty if no surface is visible.
    pub lights: Vec<ProbedLight>,
}

/// Surface at the probed pixel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct ProbedSurface {
    /// Path of the node (LINK-1).
    pub node: String,
    /// Name of the material; `null` if it has none.
    pub material: Option<String>,
    /// World position.
    pub position: Vec3,
    /// Unit shading normal in world space, on the viewer's side.
    pub normal: Vec3,
    /// Distance along the view axis, in world units.
    pub depth: f64,
    /// Radiance from the scene's fill light, linear RGB.
    pub fill: Vec3,
}

/// Light at the probed surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct ProbedLight {
    /// Id of the light.
    pub light: u64,
    /// Name for people.
    pub name: String,
    pub state: ProbeState,
    /// Reason that the light emits nothing, if it is `disabled`; else `null`.
    pub disabled_by: Option<ProbeDisabledBy>,
    /// First occluder, if the light is `shadowed`; else `null`.
    pub shadowed_by: Option<ProbedCaster>,
    /// Light coordinates of the surface; `null` outside the light.
    pub place: Option<ProbedPlace>,
    /// Unshadowed irradiance on a surface perpendicular to the light, linear RGB. It is 0 if the light is
    /// `disabled`, `unlinked` or `outside`.
    pub irradiance: Vec3,
    /// Radiance that the light adds towards the viewer, linear RGB.
    pub radiance: Vec3,
    /// Share of `radiance` in the radiance that all lights together add, measured by luminance, 0 to 1.
    pub share: f64,
    /// Light path to the surface, as a polyline in world space. It starts at the source, or outside the scene
    /// for a directional light. Empty outside the light.
    pub path: Vec<Vec3>,
    /// Centre of the light's highlight near the pixel, in pixels. Left out if not requested or not found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub highlight: Option<[f64; 2]>,
}

/// State of a light at a surface: `lit`, or the first of these reasons that it is not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum ProbeState {
    /// The light arrives.
    Lit,
    /// The light emits nothing.
    Disabled,
    /// The light's `lightLink` excludes the node.
    Unlinked,
    /// The surface lies outside the light's tube, cone or rectangle, or beyond its range.
    Outside,
    /// The light has faded to zero: beyond a cutoff, outside its outline, or at the edge of its profile.
    Faded,
    /// The surface faces away from the light.
    FacingAway,
    /// An occluder lies on the light path.
    Shadowed,
}

/// [`DisabledBy`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum ProbeDisabledBy {
    /// The view shows only other lights.
    Muted,
    /// The light is off.
    Off,
    /// The intensity or the color is 0, or the light adds to neither diffuse nor specular reflection.
    Dark,
}

/// First occluder on a light path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct ProbedCaster {
    /// Path of the node (LINK-1).
    pub node: String,
    /// World position.
    pub position: Vec3,
}

/// Light coordinates of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct ProbedPlace {
    /// Coordinate along the light: 0 to the number of segments of a BendyLight, else the share of the light's
    /// range (0 without a range).
    pub t: f64,
    /// Coordinate across the light: in radii of a cone or tube, in half widths of a directional light (0
    /// without a width), and from -1 to 1 on the face of a cube around an omni light.
    pub v: f64,
    /// Coordinate across the light and perpendicular to `v`, upwards, in the same units.
    pub w: f64,
    /// Radius of the tube or cone there, in world units; `null` for other lights.
    pub radius: Option<f64>,
    /// Length of the curved light path from the source, in world units; `null` if the source is infinitely far
    /// away.
    pub path_length: Option<f64>,
    /// Unit vector in world space from the surface towards the light.
    pub direction: Vec3,
}

impl Probed {
    /// Converts the result of a probe in a scene. `highlight` returns the centre of a light's highlight in
    /// pixels.
    pub fn new(probe: &Probe, posed: &PosedScene, highlight: impl Fn(&LightProbe) -> Option<[f64; 2]>) -> Self {
        let seen = probe.seen.map(|seen| ProbedSurface {
            node: posed.node_tree().path(seen.node),
            material: Some(posed.scene.materials[seen.material].name.clone()).filter(|name| !name.is_empty()),
            position: seen.position.to_array(),
            normal: seen.normal.to_array(),
            depth: seen.depth,
            fill: finite(seen.fill),
        });
        Self {
            seen,
            lights: probe.lights.iter().map(|light| ProbedLight::new(light, posed, highlight(light))).collect(),
        }
    }
}

impl ProbedLight {
    fn new(probe: &LightProbe, posed: &PosedScene, highlight: Option<[f64; 2]>) -> Self {
        let (disabled_by, shadowed_by) = match probe.state {
            LightState::Disabled(by) => (Some(by.into()), None),
            LightState::Shadowed(caster) => {
                let (node, position) = (posed.node_tree().path(caster.node), caster.position.to_array());
                (None, Some(ProbedCaster { node, position }))
            }
            _ => (None, None),
        };
        let place = probe.place.map(|probed| ProbedPlace {
            t: probed.coords.t,
            v: probed.coords.v,
            w: probed.coords.w,
            radius: probed.radius,
            path_length: probed.path_length,
            direction: probed.coords.direction.to_array(),
        });
        Self {
            light: probe.light.id.0,
            name: probe.light.light.light().name().to_owned(),
            state: probe.state.into(),
            disabled_by,
            shadowed_by,
            place,
            irradiance: finite(probe.irradiance),
            radiance: finite(probe.radiance),
            share: probe.share,
            path: probe.path.iter().map(DVec3::to_array).collect(),
            highlight,
        }
    }
}

/// Limits an infinite value, because JSON has none. The irradiance at the source itself is infinite.
fn finite(color: DVec3) -> Vec3 {
    color.min(DVec3::MAX).to_array()
}

same_variants!(LightState => ProbeState { Lit, Unlinked, Outside, Faded, FacingAway; Disabled, Shadowed });
same_variants!(DisabledBy => ProbeDisabledBy { Muted, Off, Dark });
