//! What a person or a program can ask of a document: the closed set of commands.

use std::sync::Arc;

use glam::{DQuat, DVec3};
use light::{CheckedLight, LightId, Setting};

use crate::{AssetHash, CameraId, FeatureDrag, LightPin, PinId};
use scene::{Camera, Projection};

/// One request. [`crate::execute_command`] turns it into changes, or says why not.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Replaces geometry, cameras and lights by those of a scene.
    LoadScene {
        /// Its bytes.
        asset: AssetHash,
        /// What people call it.
        name: String,
    },
    /// Adds a light.
    AddLight(Arc<CheckedLight>),
    /// Removes it.
    RemoveLight(LightId),
    /// Places the whole light; what is `None` stays.
    PlaceLight {
        /// Which.
        light: LightId,
        /// World position of its source.
        translation: Option<DVec3>,
        /// Rotation from light-local to world axes.
        rotation: Option<DQuat>,
        /// World units per light-local unit.
        scale: Option<f64>,
    },
    /// Sets one parameter.
    SetLight {
        /// Of which.
        light: LightId,
        /// The parameter and its value.
        setting: Setting,
    },
    /// Sets one parameter of a control point.
    SetPoint {
        /// Of which light.
        light: LightId,
        /// Its index.
        point: usize,
        /// The parameter and its value.
        setting: Setting,
    },
    /// Drags a control point: it goes as near to `position` as it can without the tube folding, worked out from the light as
    /// the document has it.
    DragPoint {
        /// The light that it bends.
        light: LightId,
        /// Its index, 1 or more.
        point: usize,
        /// Where it is to go, in light-local space.
        position: DVec3,
        /// Whether radii that would make the tube fold shrink, so that nothing is in the way.
        radii_follow: bool,
    },
    /// Drags a shadow, a hotspot, a highlight or the brightest side of a surface to another place of a picture. The light goes as
    /// near as it can; [`crate::solve_drag`] says how, in [`crate::CommandContext::solved`].
    DragFeature {
        /// The light that it moves or bends.
        light: LightId,
        /// What goes where.
        drag: Box<FeatureDrag>,
    },
    /// Adds a pin: what it names stays as it is where its light is dragged.
    AddPin(LightPin),
    /// Removes it.
    RemovePin(PinId),
    /// Says whether a pin holds whatever is asked, or as far as that lets it.
    SetPin {
        /// One of the document's.
        pin: PinId,
        /// Whatever is asked.
        is_hard: bool,
    },
    /// Adds a control point that gets the index `point`, 1 to the number of points.
    ///
    /// Without a position the control point that had that index (for the last one, the one before it) becomes two, a
    /// quarter of the way to each neighbour: the curve stays nearly as it is. Where it would
    /// fold, all points are spread anew along the line through them. Past the last point it goes on as far again. With a
    /// position nothing else moves, and what is `None` lies halfway between its neighbours.
    InsertPoint {
        /// In which light.
        light: LightId,
        /// The new point's index.
        point: usize,
        /// Light-local position.
        position: Option<DVec3>,
        /// Light-local radius.
        radius: Option<f64>,
        /// Linear RGB.
        color: Option<DVec3>,
        /// Intensity.
        intensity: Option<f64>,
    },
    /// Removes a control point other than the source.
    RemovePoint {
        /// From which light.
        light: LightId,
        /// Its index.
        point: usize,
    },
    /// Makes a straight light a BendyLight under the same id. One that was a spotlight lights every point as it did; an omni
    /// or directional light is bent as the spotlight that [`light::as_spotlight`] has of it.
    BendLight {
        /// Which.
        light: LightId,
        /// Its quadratic segments: two control points fewer than it gets.
        segments: usize,
        /// How far its control points reach along its axis, in world units. A light that has a range of its own ends there;
        /// another goes on past its last control point. `None` is for [`crate::fill_in_from_scene`] to fill in, and otherwise a
        /// unit of the light.
        range: Option<f64>,
        /// Half angle of the cone that an omni or directional light is given, in degrees; 45 unless said.
        cone_angle: Option<f64>,
        /// World position at which such a light shines then; `None` is for [`crate::fill_in_from_scene`] to fill in, and otherwise
        /// along its own -Z.
        toward: Option<DVec3>,
    },
    /// Makes a BendyLight a spotlight under the same id, from its source to its last control point.
    StraightenLight(LightId),
    /// Adds a camera.
    AddCamera(Camera),
    /// Removes it.
    RemoveCamera(CameraId),
    /// Places it; what is `None` stays.
    PlaceCamera {
        /// Which.
        camera: CameraId,
        /// World position of the eye.
        translation: Option<DVec3>,
        /// Rotation from camera to world axes.
        rotation: Option<DQuat>,
    },
    /// Sets one parameter of a camera.
    SetCamera {
        /// Of which.
        camera: CameraId,
        /// The parameter.
        parameter: CameraParameter,
    },
}

/// A property of a camera, with its value.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraParameter {
    /// Name for people.
    Name(String),
    /// World position of the eye.
    Translation(DVec3),
    /// Rotation from camera to world axes.
    Rotation(DQuat),
    /// How it projects.
    Projection(Projection),
}

impl Command {
    /// The light that it changes; `None` for one that is only being added, for cameras, pins and scenes.
    pub fn light(&self) -> Option<LightId> {
        match *self {
            Self::RemoveLight(light)
            | Self::PlaceLight { light, .. }
            | Self::SetLight { light, .. }
            | Self::SetPoint { light, .. }
            | Self::DragPoint { light, .. }
            | Self::DragFeature { light, .. }
            | Self::InsertPoint { light, .. }
            | Self::RemovePoint { light, .. }
            | Self::BendLight { light, .. }
            | Self::StraightenLight(light) => Some(light),
            Self::LoadScene { .. }
            | Self::AddLight(_)
            | Self::AddPin(_)
            | Self::RemovePin(_)
            | Self::SetPin { .. }
            | Self::AddCamera(_)
            | Self::RemoveCamera(_)
            | Self::PlaceCamera { .. }
            | Self::SetCamera { .. } => None,
        }
    }

    /// Whether it refers to a control point by its index, and so to a numbering.
    pub fn uses_point_indices(&self) -> bool {
        match self {
            Self::SetPoint { .. }
            | Self::DragPoint { .. }
            | Self::InsertPoint { .. }
            | Self::RemovePoint { .. } => true,
            Self::DragFeature { drag, .. } => drag.points.is_some(),
            _ => false,
        }
    }
}
