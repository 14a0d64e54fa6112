//! Drag files: a JSON array of drags, and the results of such drags.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use crate::drag::NameOrIndex;
use crate::error::from_json;
use crate::{Camera, Drag, DragOutcome, FileError, Light};

/// Drag in a file. Pins of other lights have no effect on it.
pub type FileDrag = Drag<NameOrIndex, Option<DragCamera>>;

/// Camera of a drag in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a name, an index or a camera")]
pub enum DragCamera {
    /// Name or index of a camera.
    Listed(NameOrIndex),
    /// Camera with all its values.
    Own(Box<Camera>),
}

/// Result of a drag in a file.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct DragResult {
    #[serde(flatten)]
    pub solved: SolvedDrag,
    /// Duration of the drag in seconds, picks and alternatives included.
    pub seconds: f64,
    /// All alternatives, if the drag asks for them: the best first, which is the result, then those that land, are limited
    /// and are refused. Of alternatives with the same picture there is one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub alternatives: Vec<SolvedDrag>,
}

/// [`drag::DragResult`] in JSON.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct SolvedDrag {
    #[serde(flatten)]
    pub outcome: DragOutcome,
    /// Light after the drag.
    pub light: Light,
    /// Light that the drag adds, if a linked copy illuminates what the light no longer does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub copy: Option<Light>,
    /// Picture of an alternative over HTTP, 160 pixels wide: a PNG file in base64.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thumbnail: Option<String>,
}

impl DragResult {
    /// Converts the result of a drag that took `seconds`, with its alternatives if it asks for them.
    pub fn new(result: &drag::DragResult, alternatives: &[drag::DragResult], seconds: f64) -> Self {
        Self { solved: result.into(), seconds, alternatives: alternatives.iter().map(Into::into).collect() }
    }
}

impl From<&drag::DragResult> for SolvedDrag {
    fn from(result: &drag::DragResult) -> Self {
        Self {
            outcome: (&result.outcome).into(),
            light: Light::from(&result.light),
            copy: result.copy.as_ref().map(|copy| Light::from(&copy.light)),
            thumbnail: None,
        }
    }
}

/// Parses the text of a drag file.
pub fn parse(text: &str) -> Result<Vec<FileDrag>, FileError> {
    from_json(text)
}
