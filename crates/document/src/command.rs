//! Commands: the closed set of requests for edits of a document.

use drag::Drag;
use std::sync::Arc;

use glam::{DQuat, DVec3};
use light::{CheckedLight, LightId, Setting};

use crate::{AssetHash, CameraId, LightPin, PinId};
use scene::{Camera, Projection};

/// Request for an edit. [`crate::execute_command`] turns it into changes or refuses it.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Replaces geometry, cameras and lights by those of a scene.
    LoadScene {
        /// Hash of the scene's bytes.
        asset: AssetHash,
        /// Name for people.
        name: String,
    },
    AddLight(Arc<CheckedLight>),
    RemoveLight(LightId),
    /// Places the whole light. Values that are `None` stay.
    PlaceLight {
        light: LightId,
        /// World position of its source.
        translation: Option<DVec3>,
        /// Rotation from light-local to world axes.
        rotation: Option<DQuat>,
        /// World units per light-local unit.
        scale: Option<f64>,
        /// True if the command may break hard pins, as in the other commands that have it. Otherwise the light comes as
        /// near to the place as they allow.
        ignore_pins: bool,
    },
    /// Sets one parameter of a light.
    SetLight {
        light: LightId,
        setting: Setting,
        ignore_pins: bool,
    },
    SetPoint {
        light: LightId,
        point: usize,
        setting: Setting,
        ignore_pins: bool,
    },
    /// Drags a control point. It moves as near to `position` as it can without a fold of the tube and without breaking a
    /// hard pin. The result depends on the light in the document, and with hard pins on the scene.
    DragPoint {
        light: LightId,
        /// Index of the point, 1 or more.
        point: usize,
        /// Target position in light-local space.
        position: DVec3,
        /// True if radii that would fold the tube shrink, so that they do not limit the point.
        radii_follow: bool,
        ignore_pins: bool,
    },
    /// Drags a feature of the light to another point of a picture: a shadow, a hotspot, a highlight or the brightest
    /// side of a surface. The light moves or bends until the feature is as near as possible. [`crate::solve_drag`]
    /// computes the result, which [`crate::CommandContext::solved`] carries.
    DragFeature {
        light: LightId,
        drag: Box<Drag>,
    },
    /// Adds a pin, which keeps a feature of its light unchanged. A hard one does so in every edit, a soft one in drags.
    AddPin(LightPin),
    RemovePin(PinId),
    /// Makes a pin hard or soft.
    SetPin {
        pin: PinId,
        /// True if every edit keeps the pin. False if only drags of features do, as far as they can.
        is_hard: bool,
    },
    /// Adds a control point that gets the index `point`, 1 to the number of points.
    ///
    /// Without a position the control point that had that index (for the last one, the one before it) becomes two, a
    /// quarter of the way to each adjacent point, so that the curve stays nearly the same. If it would fold, all points
    /// are spread evenly along the polyline through them. A point past the last one continues by the same distance.
    /// With a position no other point moves, and values that are `None` are the mean of the adjacent points.
    InsertPoint {
        light: LightId,
        /// Index of the new point.
        point: usize,
        /// Position in light-local space.
        position: Option<DVec3>,
        /// Radius in light-local units.
        radius: Option<f64>,
        color: Option<DVec3>,
        intensity: Option<f64>,
        ignore_pins: bool,
    },
    RemovePoint {
        light: LightId,
        point: usize,
        ignore_pins: bool,
    },
    /// Makes a straight light a BendyLight under the same id. A bent spotlight lights every point as before. An omni or
    /// directional light is first made a spotlight by [`light::as_spotlight`].
    BendLight {
        light: LightId,
        /// Number of quadratic segments, two less than the number of control points.
        segments: usize,
        /// Length along the light's axis that its control points span, in world units. A light with a range ends at the
        /// range. Any other light is extended past its last control point. [`crate::fill_in_from_scene`] fills in
        /// `None`; otherwise `None` is one unit of the light.
        range: Option<f64>,
        /// Half angle of the cone of an omni or directional light, in degrees; 45 by default.
        cone_angle: Option<f64>,
        /// World position at which an omni or directional light then shines. [`crate::fill_in_from_scene`] fills in
        /// `None`; otherwise the light shines along its own -Z.
        toward: Option<DVec3>,
        ignore_pins: bool,
    },
    /// Makes a BendyLight a spotlight under the same id, from its source to its last control point.
    StraightenLight {
        light: LightId,
        ignore_pins: bool,
    },
    AddCamera(Camera),
    RemoveCamera(CameraId),
    /// Places a camera. Values that are `None` stay.
    PlaceCamera {
        camera: CameraId,
        /// World position of the eye.
        translation: Option<DVec3>,
        /// Rotation from camera to world axes.
        rotation: Option<DQuat>,
    },
    SetCamera {
        camera: CameraId,
        parameter: CameraParameter,
    },
}

/// Property of a camera with its value.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraParameter {
    /// Name for people.
    Name(String),
    /// World position of the eye.
    Translation(DVec3),
    /// Rotation from camera to world axes.
    Rotation(DQuat),
    Projection(Projection),
}

impl Command {
    /// Returns the light that the command changes; `None` for an added light, and for cameras, pins and scenes.
    pub fn light(&self) -> Option<LightId> {
        match *self {
            Self::RemoveLight(light)
            | Self::StraightenLight { light, .. }
            | Self::PlaceLight { light, .. }
            | Self::SetLight { light, .. }
            | Self::SetPoint { light, .. }
            | Self::DragPoint { light, .. }
            | Self::DragFeature { light, .. }
            | Self::InsertPoint { light, .. }
            | Self::RemovePoint { light, .. }
            | Self::BendLight { light, .. } => Some(light),
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

    /// Returns true if the command refers to control points by index, and so to a numbering.
    pub fn uses_point_indices(&self) -> bool {
        match self {
            Self::SetPoint { .. } | Self::DragPoint { .. } | Self::InsertPoint { .. } | Self::RemovePoint { .. } => {
                true
            }
            Self::DragFeature { drag, .. } => drag.points.is_some(),
            _ => false,
        }
    }
}
