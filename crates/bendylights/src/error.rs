//! Errors of commands. Each message is one sentence with the place, the fault and the correction.

use std::io;
use std::path::PathBuf;

use ::bench::BenchError;
use assets::AssetError;
use cli::CliError;
use document::AssetHash;
use light::LightError;
use protocol::{FileError, RenderRefusal};
use render::RenderError;
use server::ServerError;
use store::{Difference, StoreError};
use thiserror::Error;

/// Error of a command.
#[derive(Debug, Error)]
pub enum Error {
    /// The system cannot read the file.
    #[error("{file}: cannot be read ({reason}); check the name and that you may read it")]
    Unreadable { file: String, reason: io::Error },
    /// The file would be overwritten.
    #[error("{}: is there already; name another folder, or remove it", file.display())]
    FileExists { file: PathBuf },
    /// The file is a scene, but the command needs a light file.
    #[error(
        "{file}: is a scene, and a light file is wanted: `bendylights bend --scene {file} > light.json` writes one, of \
         a light of the scene"
    )]
    SceneForLight { file: String },
    /// The scene is an address on the network.
    #[error(
        "{address}: is an address, and scenes are files: download it first, as by `curl -O`; a picture of a server's session \
         it gives by itself, at /sessions/NAME/render"
    )]
    RemoteScene { address: String },
    /// The light or point file exceeds the limit.
    #[error("{file}: is larger than {limit_mib} MiB; split it")]
    TooLarge { file: String, limit_mib: u64 },
    /// The light or point file cannot be used.
    #[error("{file}: {reason}")]
    BadFile { file: String, reason: FileError },
    /// The light cannot be bent as requested.
    #[error("{file}: {reason}")]
    BadLight { file: String, reason: LightError },
    /// The command needs one light, but the file has none or several.
    #[error("{file}: holds {count} lights, but this command takes one: keep one in the file")]
    NotOneLight { file: String, count: usize },
    /// `eval` needs a BendyLight, but the light has another type.
    #[error("{file}: is no BendyLight and has no tube: turn it into one with `bendylights bend` first")]
    EvalWithoutTube { file: String },
    /// `bend` needs a straight light, but the scene has none.
    #[error("{scene}: has no straight light to bend: name a light file")]
    NoneToBend { scene: String },
    /// `bend` needs a straight light, but the light is a BendyLight.
    #[error(
        "{file}: is a BendyLight already: `bendylights bend` takes a light of type `spot`, `omni` or `directional`"
    )]
    BendOfBendy { file: String },
    /// `bend` has options for a cone, but the light has a cone of its own.
    #[error("{file}: a spotlight keeps its own cone and direction: leave out --cone-angle and --toward")]
    HasCone { file: String },
    /// The picture of a drag has an invalid size.
    #[error("{file}: drag {index}: `size` must be two whole numbers from 1 to {max_side}: change it")]
    BadDrag { file: String, index: usize, max_side: u32 },
    /// The camera of a drag makes no picture.
    #[error("{file}: drag {index}: `camera`: {why}")]
    DragCamera { file: String, index: usize, why: &'static str },
    /// The scene file cannot be used.
    #[error(transparent)]
    Scene(#[from] AssetError),
    /// A name on the command line does not exist.
    #[error("{whose} has no {what} `{name}`: {choices}")]
    UnknownName { whose: String, what: &'static str, name: String, choices: String },
    /// Options of a picture are given, but no picture is requested.
    #[error("--camera, --size, --samples and the like are of a picture: name one with --render, as PNG or EXR")]
    NoPicture,
    /// The AOV belongs to a light, but there is none.
    #[error("{scene}: has no light to show the {aov} of: name a light file with --lights")]
    NothingToShow { scene: String, aov: &'static str },
    /// The scene of a frame measurement is empty.
    #[error("{0}: has no triangles and no light, so there is nothing to measure: name another scene with --scene")]
    NothingLit(String),
    /// The backend has no shadow maps, but an option sets them.
    #[error(
        "{0}: the reference follows light along its curve and has no shadow maps: leave it out, or take another --backend"
    )]
    NoShadowMaps(&'static str),
    /// The file name of a picture has no known extension.
    #[error("{}: is neither .png nor .exr; name the picture OUT.png or OUT.exr", .0.display())]
    UnknownFormat(PathBuf),
    /// A PNG cannot hold several AOVs.
    #[error("{}: a PNG shows one quantity; ask for one with --aov, or write an EXR", .0.display())]
    OneInPng(PathBuf),
    /// The request for a picture is invalid.
    #[error(transparent)]
    Picture(#[from] RenderRefusal),
    /// The renderer failed.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The reference renderer failed.
    #[error(transparent)]
    Reference(#[from] reference::ReferenceError),
    /// The server cannot listen on the address.
    #[error("{address}: cannot be listened on ({reason}); choose another with --listen, or port 0 for a free one")]
    CannotListen { address: String, reason: io::Error },
    /// The system provides no threads or signals.
    #[error("this system cannot run a server ({0}); check its limits on threads and files")]
    NoRuntime(io::Error),
    /// The server failed.
    #[error(transparent)]
    Server(#[from] ServerError),
    /// The data folder, or a log in it, cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The log file cannot be used.
    #[error("{file}: {reason}")]
    BadLog { file: String, reason: StoreError },
    /// The bundle cannot be used.
    #[error("{file}: is no bundle as `bendylights export` writes them ({reason}); export it again")]
    BadBundle { file: String, reason: String },
    /// The file is a bundle, but the command needs a log file.
    #[error(
        "{file}: is a bundle, and a log file is wanted: `bendylights import {file}` makes a session of it, and \
         `unzip -p {file} log.jsonl` gives its log"
    )]
    BundleForLog { file: String },
    /// The log needs a scene that is neither a demo nor in the data folder.
    #[error(
        "{file}: record {seq} needs the scene {asset}, which is neither a demo nor in the data folder: name the folder \
         that has it with --data, or copy the file assets/{} from there", asset.hex()
    )]
    NoScene { file: String, seq: u64, asset: AssetHash },
    /// The replay differs from the log.
    #[error("{file}: {how}")]
    Differs { file: String, how: Difference },
    /// A measurement failed.
    #[error(transparent)]
    Bench(#[from] BenchError),
    /// The light model's solver gave wrong answers.
    #[error(
        "the solver is wrong: {wrong} roots wrong and {nan} not a number; keep the answer's `firstWrong`, whose family and \
         index give the case again"
    )]
    SolverWrong { wrong: u64, nan: u64 },
    /// The effect of one client on another exceeds a bound.
    #[error("{rows}: bounds are missed; `missed` of each row says which, and `alone` beside `with` by how much")]
    BoundsMissed { rows: String },
    /// An answer or a file cannot be written.
    #[error(transparent)]
    Cli(#[from] CliError),
}

impl Error {
    /// Returns 2 if the user can correct the call, 1 if the machine fails or a measurement misses a bound.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Cli(error) => error.exit_code(),
            Self::Server(ServerError::Store(StoreError::NotAFolder(_))) => 2,
            Self::BoundsMissed { .. }
            | Self::SolverWrong { .. }
            | Self::Store(StoreError::Io { .. } | StoreError::Database(_) | StoreError::Unwritable(_))
            | Self::NoRuntime(_)
            | Self::Server(
                ServerError::Data { .. } | ServerError::Store(_) | ServerError::Render(_) | ServerError::Listen(_),
            )
            | Self::Render(RenderError::NoAdapter(_) | RenderError::DeviceLost(_) | RenderError::Gpu(_)) => 1,
            _ => 2,
        }
    }
}

/// Returns the error that a scene or file has no light called `name`, with the names that it has.
pub fn no_such_light<'a>(whose: String, name: &str, names: impl Iterator<Item = &'a str>) -> Error {
    Error::UnknownName { whose, what: "light", name: name.into(), choices: choices(names) }
}

/// Formats a list of names as the end of a sentence.
pub fn choices<'a>(names: impl Iterator<Item = &'a str>) -> String {
    const SHOWN: usize = 12;
    let names: Vec<_> = names.map(|name| format!("`{name}`")).collect();
    match names.len() {
        0 => "it has none".into(),
        n if n > SHOWN => format!("choose one of {} and {} more", names[..SHOWN].join(", "), n - SHOWN),
        _ => format!("choose one of {}", names.join(", ")),
    }
}
