//! Settings of a viewer's view, besides the camera.

use std::collections::BTreeSet;

use document::MAX_LIGHTS;
use light::{LightId, LightInstance};
use protocol::RenderRequest;

use crate::ServerError;
use crate::error::check_size;

/// Settings of a view. They are in no document, and each viewer has its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ViewSettings {
    /// Stops, within [`scene::View::EXPOSURE_RANGE`].
    pub exposure: f64,
    /// Lights to show alone. If the document has none of them, all lights are shown.
    pub solo: BTreeSet<LightId>,
}

impl ViewSettings {
    /// Returns the lights of the document that the view shows.
    pub fn visible_lights(&self, mut lights: Vec<LightInstance>) -> Vec<LightInstance> {
        let hidden = self.hidden_lights(&lights);
        lights.retain(|instance| !hidden.contains(&instance.id));
        lights
    }

    /// Returns the lights of the document that the view hides.
    pub fn hidden_lights(&self, lights: &[LightInstance]) -> BTreeSet<LightId> {
        let (shown, hidden): (BTreeSet<_>, BTreeSet<_>) =
            lights.iter().map(|instance| instance.id).partition(|id| self.solo.contains(id));
        if shown.is_empty() { BTreeSet::new() } else { hidden }
    }
}

impl TryFrom<protocol::ViewSettings> for ViewSettings {
    type Error = ServerError;

    fn try_from(wire: protocol::ViewSettings) -> Result<Self, ServerError> {
        let protocol::ViewSettings { exposure, solo } = wire;
        check_size("the list of lights that a view shows alone", solo.len(), MAX_LIGHTS, "lights")?;
        let exposure = RenderRequest::check_exposure(exposure)?;
        Ok(Self { exposure, solo: solo.into_iter().map(LightId).collect() })
    }
}

impl From<&ViewSettings> for protocol::ViewSettings {
    fn from(ViewSettings { exposure, solo }: &ViewSettings) -> Self {
        Self { exposure: *exposure, solo: solo.iter().map(|id| id.0).collect() }
    }
}
