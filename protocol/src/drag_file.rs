//! Drag files: a JSON array of drags, and the results of such drags.

use schemars::JsonSchema;
use serde::Serialize;

pub use crate::drag::NameOrIndex;
use crate::error::from_json;
use crate::{Drag, DragOutcome, FileError, Light};

/// Drag in a file. Pins of other lights have no effect on it.
pub type FileDrag = Drag<NameOrIndex, Option<NameOrIndex>>;

/// [`drag::DragResult`] in JSON.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct DragResult {
    #[serde(flatten)]
    pub outcome: DragOutcome,
    /// Duration of the drag in seconds, picks included.
    pub seconds: f64,
    /// Light after the drag.
    pub light: Light,
}

impl DragResult {
    /// Converts the result of a drag that took `seconds`.
    pub fn new(result: &drag::DragResult, seconds: f64) -> Self {
        Self { outcome: (&result.outcome).into(), seconds, light: Light::from(&result.light) }
    }
}

/// Parses the text of a drag file.
pub fn parse(text: &str) -> Result<Vec<FileDrag>, FileError> {
    from_json(text)
}
