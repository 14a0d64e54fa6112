//! Drag files: a JSON array of drags, and the results of such drags.

use schemars::JsonSchema;
use serde::Serialize;

pub use crate::drag::{DragCamera, NameOrIndex};
use crate::error::from_json;
use crate::{Drag, DragOutcome, FileError, Light};

/// Drag in a file. Pins of other lights have no effect on it.
pub type FileDrag = Drag<NameOrIndex, Option<DragCamera>>;

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
