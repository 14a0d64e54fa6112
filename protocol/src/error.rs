//! Why a file is refused, and reading JSON so that the reason names the place.

use document::{EditError, InvalidAssetHash};
use light::LightError;
use std::marker::PhantomData;

use serde::de::{DeserializeOwned, DeserializeSeed};
use thiserror::Error;

use crate::ErrorCode;
use crate::words::{json_wording, syntax_error_wording};

/// Why a light file or a point file is refused. The caller knows the file's name and puts it in front.
#[derive(Debug, Error)]
pub enum FileError {
    /// The text is not JSON.
    #[error("not valid JSON: {} (numbers must be finite; JSON has no NaN or Infinity)", syntax_error_wording(&.0.to_string()))]
    Syntax(serde_json::Error),
    /// The JSON does not have the shape of what it should hold.
    #[error("{place}{problem}")]
    Shape {
        /// Path of the field and a colon, or empty where the whole is meant.
        place: String,
        /// What is wrong there and what was expected.
        problem: String,
    },
    /// The light cannot be evaluated.
    #[error("{place}{reason}")]
    Model {
        /// Which light of the file and a colon, or empty where there is one.
        place: String,
        /// Why not, and what to change.
        reason: LightError,
    },
    /// A log or a record of a format that this program does not know: [`Refused::Format`].
    #[error("{0}")]
    Format(Refused),
    /// A reference in a log that leads nowhere.
    #[error("{0}")]
    Reference(String),
}

/// Why what is well-formed JSON has no meaning in the domain.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Refused {
    /// A light that cannot be evaluated.
    #[error("{0}")]
    Light(#[from] LightError),
    /// An asset that is not named by its hash.
    #[error("{0}")]
    Asset(#[from] InvalidAssetHash),
    /// Something that the document does not allow.
    #[error("{0}")]
    Edit(#[from] EditError),
    /// What names no value of a document.
    #[error("{0}")]
    Address(String),
    /// Radii that are to be solved for where nothing is.
    #[error("`radii` of `dragPoint` is \"keep\" or \"follow\": \"solve\" is for `dragFeature`")]
    SolvedRadii,
    /// How a drag ended, told in parts that do not fit together.
    #[error("{0}: the log was changed; export it again")]
    Outcome(&'static str),
    /// A record of a format that this program does not know.
    #[error(
        "format {found} is not known to this program, which knows formats 1 to {}: use a newer program",
        crate::FORMAT
    )]
    Format {
        /// What it says.
        found: u32,
    },
    /// A record that holds what its format did not have.
    #[error("format {format} has no `{what}`, which came later: the log was changed; export it again")]
    Younger {
        /// Of the record.
        format: u32,
        /// A parameter, or a light's type.
        what: &'static str,
    },
}

impl Refused {
    /// The code that programs act on.
    pub fn code(&self) -> ErrorCode {
        match self {
            Self::Light(error) => error.into(),
            Self::Asset(_) | Self::Address(_) | Self::SolvedRadii => ErrorCode::BadMessage,
            Self::Edit(error) => error.into(),
            Self::Format { .. } => ErrorCode::Format,
            Self::Younger { .. } | Self::Outcome(_) => ErrorCode::BadLog,
        }
    }
}

impl FileError {
    /// The same error, said of light `index` of a file of several.
    pub(crate) fn of_light(self, index: usize) -> Self {
        let prefix = |place| format!("light {index}: {place}");
        match self {
            Self::Syntax(_) | Self::Format(_) | Self::Reference(_) => self,
            Self::Shape { place, problem } => Self::Shape { place: prefix(place), problem },
            Self::Model { place, reason } => Self::Model { place: prefix(place), reason },
        }
    }
}

/// Characters of the input that a sentence quotes.
const MAX_QUOTED: usize = 80;

/// A piece of the input within a sentence, its beginning where it is long: sentences are kept as the results of operations.
pub(crate) fn excerpt(text: &str) -> String {
    let mut said: String = text.chars().take(MAX_QUOTED).collect();
    if said.len() < text.len() {
        said.push('…');
    }
    said
}

/// Reads a `T` from the text of one JSON value, all of it.
pub(crate) fn from_json<T: DeserializeOwned>(text: &str) -> Result<T, FileError> {
    seeded_from_json(text, PhantomData)
}

/// The same of what `seed` reads.
pub(crate) fn seeded_from_json<'de, S: DeserializeSeed<'de>>(
    text: &'de str,
    seed: S,
) -> Result<S::Value, FileError> {
    let mut json = serde_json::Deserializer::from_str(text);
    let mut track = serde_path_to_error::Track::new();
    let read = seed.deserialize(serde_path_to_error::Deserializer::new(&mut json, &mut track));
    let value = read.map_err(|error| {
        let place = match track.path().to_string() {
            root if root == "." => String::new(),
            path => format!("{path}: "),
        };
        refused(place, error)
    })?;
    json.end().map_err(FileError::Syntax)?;
    Ok(value)
}

fn refused(place: String, error: serde_json::Error) -> FileError {
    // serde_json calls a fixed-length array's surplus a syntax error; inside a value it is one of shape.
    if error.to_string().starts_with("trailing characters") && !place.is_empty() {
        return FileError::Shape {
            place,
            problem: "too many numbers: a pair has 2, a vector 3, a rotation 4".into(),
        };
    }
    if !error.is_data() {
        return FileError::Syntax(error);
    }
    // The path says where; a line and column would count from the start of the light, not of the file. And
    // the reader knows JSON's words, not Rust's.
    let text = error.to_string();
    let problem = text.rsplit_once(" at line ").map_or(text.as_str(), |(problem, _)| problem);
    FileError::Shape { place, problem: json_wording(problem) }
}
