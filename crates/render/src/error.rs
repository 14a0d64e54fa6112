//! Why a picture cannot be made.

use thiserror::Error;

/// Why a picture cannot be made. Each sentence says what to change.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum RenderError {
    /// No usable Vulkan or GL driver.
    #[error(
        "no graphics driver can render this: {0}; install mesa-vulkan-drivers (it renders without a GPU) or the \
         driver of your GPU"
    )]
    NoAdapter(String),
    /// The device is gone; a new [`crate::Gpu`] is needed.
    #[error("the graphics device was lost ({0}): open it again")]
    DeviceLost(String),
    /// The driver refused something.
    #[error("the graphics driver reports an error, try a smaller picture or scene: {0}")]
    Gpu(String),
    /// More than this device, or f32 arithmetic, can hold.
    #[error("{what} is {size}, but at most {limit} can be rendered: make it smaller")]
    TooLarge {
        /// What is too large, as the start of a sentence.
        what: &'static str,
        /// How large it is.
        size: f64,
        /// How large it may be.
        limit: f64,
    },
    /// A light that f32 cannot relate to the scene.
    #[error(transparent)]
    OutOfReach(#[from] light::UndrawableLight),
    /// A picture without pixels, without samples, or through an impossible camera.
    #[error("this view cannot be rendered: {0}")]
    InvalidView(&'static str),
    /// Shadow settings that no map can be made of.
    #[error("shadows cannot be made so: {0}")]
    InvalidShadows(&'static str),
    /// An AOV of a light that is not there.
    #[error("there is no light {index} to show, this picture has {count}: choose one of them or another AOV")]
    NoSuchLight {
        /// The index asked for.
        index: usize,
        /// How many lights there are.
        count: usize,
    },
    /// A wireframe of a light whose map is not mapped.
    #[error("only a BendyLight or a spotlight has a wireframe: choose another light or another AOV")]
    NoWireframe,
    /// A picture that its file format cannot hold.
    #[error("the picture cannot be encoded ({0}): make it smaller")]
    Encode(String),
    /// Whoever asked for the picture has gone.
    #[error("the picture was cancelled: ask for it again")]
    Cancelled,
    /// A light with numbers outside their domains.
    #[error(transparent)]
    Light(#[from] light::LightError),
}

impl From<relight::Cancelled> for RenderError {
    fn from(_: relight::Cancelled) -> Self {
        Self::Cancelled
    }
}
