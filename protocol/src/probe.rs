//! Why a pixel is lit or not, in JSON (SPEC, section 7).

use glam::DVec3;
use reference::{DisabledBy, LightProbe, LightState, Probe};
use scene::PosedScene;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Camera, Problem, Vec3};

/// The body of `POST /sessions/S/probe`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ProbeRequest {
    /// Who looks; by default the document's first camera, or one that sees everything.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<ProbeCamera>,
    /// Width and height of the picture, in pixels.
    pub size: [u32; 2],
    /// In pixels from the picture's top left corner; a pixel's centre is at .5.
    pub pixel: [f64; 2],
    /// Whether it is asked where highlights lie.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub highlights: bool,
}

/// Who looks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum ProbeCamera {
    /// A camera that need not be one of the document's.
    Own(Camera),
    /// One of the document's, by its id.
    Id(u64),
}

/// The answer to `probe`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct ProbeAnswer {
    /// The client's name for it.
    pub probe: String,
    /// The record that the document was after, but for the drags under way.
    pub log_seq: u64,
    /// The session's count of gesture changes then; frames carry it.
    pub live_revision: u32,
    /// What was found; `null` where the probe is refused.
    pub found: Option<Probed>,
    /// Why it is refused; `null` where it is not.
    pub refused: Option<Problem>,
}

/// [`Probe`] in JSON: what a point of a picture shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct Probed {
    /// The nearest surface that is drawn there; `null` where there is only background.
    pub seen: Option<ProbedSurface>,
    /// Every light, in the order of ids; none where nothing is seen.
    pub lights: Vec<ProbedLight>,
}

/// A surface that is seen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct ProbedSurface {
    /// Path of the node (LINK-1).
    pub node: String,
    /// Name of the material; `null` where it has none.
    pub material: Option<String>,
    /// In the world.
    pub position: Vec3,
    /// Unit shading normal in the world, towards the viewer.
    pub normal: Vec3,
    /// Distance along the view axis, in world units.
    pub depth: f64,
    /// Radiance that the scene's fill gives it, linear RGB.
    pub fill: Vec3,
}

/// What a light does there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct ProbedLight {
    /// The light's id.
    pub light: u64,
    /// What people call it.
    pub name: String,
    /// Whether it lights the surface, or why not.
    pub state: ProbeState,
    /// Why it shines nowhere, where it is `disabled`; else `null`.
    pub disabled_by: Option<ProbeDisabledBy>,
    /// What is in its way, where it is `shadowed`; else `null`.
    pub shadowed_by: Option<ProbedCaster>,
    /// Where the surface lies in it; `null` outside.
    pub place: Option<ProbedPlace>,
    /// On a surface square to the light, linear RGB, were nothing in the way; 0 where it is `disabled`, `unlinked` or `outside`.
    pub irradiance: Vec3,
    /// What it adds to the radiance towards the eye, linear RGB.
    pub radiance: Vec3,
    /// Share of that in the luminance that all lights together give, 0 to 1.
    pub share: f64,
    /// The way of its light to the surface as a polyline: points in the world, from the source on; of a directional light from
    /// outside of the scene. Empty outside.
    pub path: Vec<Vec3>,
    /// The centre of its highlight near the pixel, in pixels; left out where it is not asked for or there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub highlight: Option<[f64; 2]>,
}

/// Whether a light lights a surface, or the first reason of these that it does not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum ProbeState {
    /// Its light arrives.
    Lit,
    /// It shines nowhere.
    Disabled,
    /// The node is not among those that it lights.
    Unlinked,
    /// The surface lies outside of its tube, its cone or its sides, or past its range.
    Outside,
    /// Nothing of its light is left there: past a cut, outside its outline, at an edge of its profile.
    Faded,
    /// The surface turns its back to where its light comes from.
    FacingAway,
    /// Something stands in its way.
    Shadowed,
}

/// [`DisabledBy`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum ProbeDisabledBy {
    /// The view shows others alone.
    Muted,
    /// It is turned off.
    Off,
    /// Its intensity or its colour is 0, or what surfaces scatter and mirror of it.
    Dark,
}

/// The first that light meets on its way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct ProbedCaster {
    /// Path of the node (LINK-1).
    pub node: String,
    /// Where, in the world.
    pub position: Vec3,
}

/// Where a surface lies in a light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct ProbedPlace {
    /// Along the light: 0 to the number of segments of a BendyLight, or the share of a light's range (0 without).
    pub t: f64,
    /// Across the light: in radii where it has a cone or a tube, in halves of a directional light's width (0 without), and on
    /// the face of a cube about an omni light, from -1 to 1.
    pub v: f64,
    /// The same, upwards.
    pub w: f64,
    /// Radius of the tube or the cone there, in world units; `null` of lights that have none.
    pub radius: Option<f64>,
    /// Length of the light's way from its source, bent as it is, in world units; `null` where it comes from infinitely far away.
    pub path_length: Option<f64>,
    /// Unit vector in the world from the surface to where its light comes from.
    pub direction: Vec3,
}

impl Probed {
    /// What was found in a scene.
    ///
    /// `highlight` says where the highlight of a light lies that is asked for.
    pub fn new(
        probe: &Probe,
        posed: &PosedScene,
        highlight: impl Fn(&LightProbe) -> Option<[f64; 2]>,
    ) -> Self {
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
            lights: probe
                .lights
                .iter()
                .map(|light| ProbedLight::new(light, posed, highlight(light)))
                .collect(),
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

/// JSON has no infinity, which is what a light gives at its very source.
fn finite(color: DVec3) -> Vec3 {
    color.min(DVec3::MAX).to_array()
}

impl From<LightState> for ProbeState {
    fn from(state: LightState) -> Self {
        match state {
            LightState::Lit => Self::Lit,
            LightState::Disabled(_) => Self::Disabled,
            LightState::Unlinked => Self::Unlinked,
            LightState::Outside => Self::Outside,
            LightState::Faded => Self::Faded,
            LightState::FacingAway => Self::FacingAway,
            LightState::Shadowed(_) => Self::Shadowed,
        }
    }
}

impl From<DisabledBy> for ProbeDisabledBy {
    fn from(by: DisabledBy) -> Self {
        match by {
            DisabledBy::Muted => Self::Muted,
            DisabledBy::Off => Self::Off,
            DisabledBy::Dark => Self::Dark,
        }
    }
}
