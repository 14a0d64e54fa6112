//! Errors of files and of conversions, and JSON parsing whose errors name the field.

use document::{EditError, InvalidAssetHash};
use light::LightError;
use std::marker::PhantomData;

use serde::de::{DeserializeOwned, DeserializeSeed};
use thiserror::Error;

use crate::ErrorCode;
use crate::words::{json_wording, syntax_error_wording};

/// Error of a file. The caller knows the file's name and puts it in front.
#[derive(Debug, Error)]
pub enum FileError {
    /// The text is not JSON.
    #[error("not valid JSON: {} (numbers must be finite; JSON has no NaN or Infinity)", syntax_error_wording(&.0.to_string()))]
    Syntax(serde_json::Error),
    /// The JSON has another shape than expected.
    #[error("{path}{problem}")]
    Shape {
        /// Path of the field and a colon; empty for the whole value.
        path: String,
        /// Description of the value that was found, and of what was expected.
        problem: String,
    },
    /// The light cannot be evaluated.
    #[error("{path}{reason}")]
    Model {
        /// Index of the light in the file and a colon; empty if the file has one light.
        path: String,
        /// Error of the light, which also says what to change.
        reason: LightError,
    },
    /// The log or record has a format that this program does not know: [`Refused::Format`].
    #[error("{0}")]
    Format(Refused),
    /// A reference in a log cannot be resolved.
    #[error("{0}")]
    Reference(String),
}

/// Error of well-formed JSON that has no meaning in the domain.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Refused {
    /// The light cannot be evaluated.
    #[error("{0}")]
    Light(#[from] LightError),
    /// The asset is not named by its hash.
    #[error("{0}")]
    Asset(#[from] InvalidAssetHash),
    /// The document does not allow the edit.
    #[error("{0}")]
    Edit(#[from] EditError),
    /// The address names no parameter, or the value does not fit it.
    #[error("{0}")]
    Address(String),
    /// `radii` is `solve` for a drag without a solver.
    #[error("`radii` of `dragPoint` is \"keep\" or \"follow\": \"solve\" is for `dragFeature`")]
    SolvedRadii,
    /// A drag in a session has pins of its own.
    #[error("`dragFeature` keeps the pins of the session: `pins` is for drag files")]
    DragPins,
    /// A drag in a session asks for alternatives.
    #[error("`dragFeature` is solved one way, which `alternative` names: `alternatives` is for drag files")]
    DragAlternatives,
    /// The parts of a drag's outcome contradict one another.
    #[error("{0}: the log was changed; export it again")]
    Outcome(&'static str),
    /// The record has a format that this program does not know.
    #[error(
        "format {found} is not known to this program, which knows formats 1 to {}: use a newer program",
        crate::format::FORMAT
    )]
    Format { found: u32 },
    /// The record contains a parameter or a type of light that did not exist in the record's format.
    #[error("format {format} has no `{what}`, which came later: the log was changed; export it again")]
    Younger {
        format: u32,
        /// Name of the parameter, or type of the light.
        what: &'static str,
    },
}

/// Returns an error for a format that this version cannot read.
pub(crate) fn check_format(found: u32) -> Result<(), Refused> {
    if (1..=crate::format::FORMAT).contains(&found) { Ok(()) } else { Err(Refused::Format { found }) }
}

impl Refused {
    /// Returns the code for programs.
    pub fn code(&self) -> ErrorCode {
        match self {
            Self::Light(error) => error.into(),
            Self::Asset(_) | Self::Address(_) | Self::SolvedRadii | Self::DragPins | Self::DragAlternatives => {
                ErrorCode::BadMessage
            }
            Self::Edit(error) => error.into(),
            Self::Format { .. } => ErrorCode::Format,
            Self::Younger { .. } | Self::Outcome(_) => ErrorCode::BadLog,
        }
    }
}

impl FileError {
    /// Returns the same error, with `index` of the light in a file of several lights.
    pub(crate) fn of_light(self, index: usize) -> Self {
        let prefix = |path| format!("light {index}: {path}");
        match self {
            Self::Syntax(_) | Self::Format(_) | Self::Reference(_) => self,
            Self::Shape { path, problem } => Self::Shape { path: prefix(path), problem },
            Self::Model { path, reason } => Self::Model { path: prefix(path), reason },
        }
    }
}

/// Characters of the input that a message quotes at most.
const MAX_QUOTED: usize = 80;

/// Returns the start of `text`, of at most `MAX_QUOTED` characters. The limit is needed because messages are
/// stored as results of operations.
pub(crate) fn excerpt(text: &str) -> String {
    let mut said: String = text.chars().take(MAX_QUOTED).collect();
    if said.len() < text.len() {
        said.push('…');
    }
    said
}

/// Parses `text`, which must be exactly one JSON value, as a `T`: a message, a body or a file. An error names the field.
pub fn from_json<T: DeserializeOwned>(text: &str) -> Result<T, FileError> {
    seeded_from_json(text, PhantomData)
}

/// Parses `text`, which must be exactly one JSON value, with `seed`.
pub(crate) fn seeded_from_json<'de, S: DeserializeSeed<'de>>(text: &'de str, seed: S) -> Result<S::Value, FileError> {
    let mut json = serde_json::Deserializer::from_str(text);
    let mut track = serde_path_to_error::Track::new();
    let read = seed.deserialize(serde_path_to_error::Deserializer::new(&mut json, &mut track));
    let value = read.map_err(|error| {
        let path = match track.path().to_string() {
            root if root == "." => String::new(),
            path => format!("{path}: "),
        };
        refused(path, error)
    })?;
    json.end().map_err(FileError::Syntax)?;
    Ok(value)
}

fn refused(path: String, error: serde_json::Error) -> FileError {
    // serde_json reports a surplus item of a fixed-length array as a syntax error. Inside a value it is an
    // error of shape.
    if error.to_string().starts_with("trailing characters") && !path.is_empty() {
        return FileError::Shape { path, problem: "too many numbers: a pair has 2, a vector 3, a rotation 4".into() };
    }
    if !error.is_data() {
        return FileError::Syntax(error);
    }
    // The path names the field. A line and column would count from the start of the light, not of the file. The
    // translation replaces Rust's terms by JSON's.
    let text = error.to_string();
    let problem = text.rsplit_once(" at line ").map_or(text.as_str(), |(problem, _)| problem);
    FileError::Shape { path, problem: json_wording(problem) }
}
