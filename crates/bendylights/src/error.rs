//! What can go wrong in a command. Every message is one sentence: what is wrong, where, and how to mend it.

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

/// Why a command did not do its work.
#[derive(Debug, Error)]
pub enum Error {
    /// A file that the system would not read.
    #[error("{file}: cannot be read ({reason}); check the name and that you may read it")]
    Unreadable { file: String, reason: io::Error },
    /// A file that would be overwritten.
    #[error("{}: is there already; name another folder, or remove it", file.display())]
    FileExists { file: PathBuf },
    /// A scene where a light file is wanted.
    #[error(
        "{file}: is a scene, and a light file is wanted: `bendylights bend --scene {file} > light.json` writes one, of \
         a light of the scene"
    )]
    SceneForLight { file: String },
    /// A scene that lies on another machine.
    #[error(
        "{address}: is an address, and scenes are files: download it first, as by `curl -O`; a picture of a server's session \
         it gives by itself, at /sessions/NAME/render"
    )]
    RemoteScene { address: String },
    /// A light or point file over the limit.
    #[error("{file}: is larger than {limit_mib} MiB; split it")]
    TooLarge { file: String, limit_mib: u64 },
    /// A light or point file that cannot be used.
    #[error("{file}: {reason}")]
    BadFile { file: String, reason: FileError },
    /// A light that cannot be bent as asked.
    #[error("{file}: {reason}")]
    BadLight { file: String, reason: LightError },
    /// A command for one light was given a file with none or several.
    #[error("{file}: holds {count} lights, but this command takes one: keep one in the file")]
    NotOneLight { file: String, count: usize },
    /// `eval` was given a light of another shape.
    #[error("{file}: is no BendyLight and has no tube: turn it into one with `bendylights bend` first")]
    EvalWithoutTube { file: String },
    /// `bent` was given a scene without a light that it could bend.
    #[error("{scene}: has no straight light to bend: name a light file")]
    NoneToBend { scene: String },
    /// `bent` was given a BendyLight.
    #[error(
        "{file}: is a BendyLight already: `bendylights bend` takes a light of type `spot`, `omni` or `directional`"
    )]
    BendOfBendy { file: String },
    /// `bent` was told a cone for a light that has one.
    #[error("{file}: a spotlight keeps its own cone and direction: leave out --cone-angle and --toward")]
    HasCone { file: String },
    /// A drag in a picture that there cannot be.
    #[error("{file}: drag {index}: `size` must be two whole numbers from 1 to {max_side}: change it")]
    BadDrag { file: String, index: usize, max_side: u32 },
    /// A scene file that cannot be used.
    #[error(transparent)]
    Scene(#[from] AssetError),
    /// A name given on the command line is not among those there are.
    #[error("{whose} has no {what} `{name}`: {choices}")]
    UnknownName { whose: String, what: &'static str, name: String, choices: String },
    /// Options of a picture that is not asked for.
    #[error(
        "--camera, --size, --samples and the like are of a picture: name one with --render, as PNG or EXR"
    )]
    NoPicture,
    /// An AOV that shows a light, where there is none.
    #[error("{scene}: has no light to show the {aov} of: name a light file with --lights")]
    NothingToShow { scene: String, aov: &'static str },
    /// A measurement of frames of nothing.
    #[error(
        "{0}: has no triangles and no light, so there is nothing to measure: name another scene with --scene"
    )]
    NothingLit(String),
    /// An option of shadow maps for the backend that has none.
    #[error(
        "{0}: the reference follows light along its curve and has no shadow maps: leave it out, or take --backend gpu"
    )]
    NoShadowMaps(&'static str),
    /// A picture whose file name does not say a known format.
    #[error("{}: is neither .png nor .exr; name the picture OUT.png or OUT.exr", .0.display())]
    UnknownFormat(PathBuf),
    /// A PNG of several quantities.
    #[error("{}: a PNG shows one quantity; ask for one with --aov, or write an EXR", .0.display())]
    OneInPng(PathBuf),
    /// A picture that is not asked for as it can be.
    #[error(transparent)]
    Picture(#[from] RenderRefusal),
    /// The renderer could not.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The reference could not.
    #[error(transparent)]
    Reference(#[from] reference::ReferenceError),
    /// The address to listen on is taken, or not this machine's.
    #[error(
        "{address}: cannot be listened on ({reason}); choose another with --listen, or port 0 for a free one"
    )]
    CannotListen { address: String, reason: io::Error },
    /// The system gives no threads or signals.
    #[error("this system cannot run a server ({0}); check its limits on threads and files")]
    NoRuntime(io::Error),
    /// The server could not.
    #[error(transparent)]
    Server(#[from] ServerError),
    /// The data folder, or the log in it, cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A log file that cannot be used.
    #[error("{file}: {reason}")]
    BadLog { file: String, reason: StoreError },
    /// A bundle that cannot be used.
    #[error("{file}: is no bundle as `bendylights export` writes them ({reason}); export it again")]
    BadBundle { file: String, reason: String },
    /// A bundle where a log file is wanted.
    #[error(
        "{file}: is a bundle, and a log file is wanted: `bendylights import {file}` makes a session of it, and \
         `unzip -p {file} log.jsonl` gives its log"
    )]
    BundleForLog { file: String },
    /// A log needs a scene that is neither a demo nor in the data folder.
    #[error(
        "{file}: record {seq} needs the scene {asset}, which is neither a demo nor in the data folder: name the folder \
         that has it with --data, or copy the file assets/{} from there", asset.hex()
    )]
    NoScene { file: String, seq: u64, asset: AssetHash },
    /// A replayed log is not what was logged.
    #[error("{file}: {how}")]
    Differs { file: String, how: Difference },
    /// A measurement that could not be made.
    #[error(transparent)]
    Bench(#[from] BenchError),
    /// The light model's solver gave wrong answers.
    #[error(
        "the solver is wrong: {wrong} roots wrong and {nan} not a number; keep the answer's `firstWrong`, whose family and \
         index give the case again"
    )]
    SolverWrong { wrong: u64, nan: u64 },
    /// A server that lets one client take from another more than it may.
    #[error(
        "{rows}: bounds are missed; `missed` of each row says which, and `alone` beside `with` by how much"
    )]
    BoundsMissed { rows: String },
    /// An answer or a file could not be written.
    #[error(transparent)]
    Cli(#[from] CliError),
}

impl Error {
    /// 2 where the user can mend it, 1 where this machine stands in the way or what is measured misses a bound.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Cli(error) => error.exit_code(),
            Self::Server(ServerError::Store(StoreError::NotAFolder(_))) => 2,
            Self::BoundsMissed { .. }
            | Self::SolverWrong { .. }
            | Self::Store(StoreError::Io { .. } | StoreError::Database(_) | StoreError::Unwritable(_))
            | Self::NoRuntime(_)
            | Self::Server(
                ServerError::Data { .. }
                | ServerError::Store(_)
                | ServerError::Render(_)
                | ServerError::Listen(_),
            )
            | Self::Render(RenderError::NoAdapter(_) | RenderError::DeviceLost(_) | RenderError::Gpu(_)) => 1,
            _ => 2,
        }
    }
}

/// That a scene or a file has no light of that name, and which it has.
pub fn no_such_light<'a>(whose: String, name: &str, names: impl Iterator<Item = &'a str>) -> Error {
    Error::UnknownName { whose, what: "light", name: name.into(), choices: choices(names) }
}

/// What there is to choose from, as the end of a sentence.
pub fn choices<'a>(names: impl Iterator<Item = &'a str>) -> String {
    const SHOWN: usize = 12;
    let names: Vec<_> = names.map(|name| format!("`{name}`")).collect();
    match names.len() {
        0 => "it has none".into(),
        n if n > SHOWN => format!("choose one of {} and {} more", names[..SHOWN].join(", "), n - SHOWN),
        _ => format!("choose one of {}", names.join(", ")),
    }
}
