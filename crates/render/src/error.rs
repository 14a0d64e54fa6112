//! Errors of rendering.

use thiserror::Error;

/// Reason why a picture cannot be drawn. Each message says what to change.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum RenderError {
    /// There is no usable Vulkan or GL driver.
    #[error(
        "no graphics driver can render this: {0}; install mesa-vulkan-drivers (it renders without a GPU) or the \
         driver of your GPU, or draw on the CPU (backend native)"
    )]
    NoAdapter(String),
    /// The device is lost; open a new [`crate::Device`].
    #[error("the graphics device was lost ({0}): open it again")]
    DeviceLost(String),
    /// The driver reported an error.
    #[error("the graphics driver reports an error, try a smaller picture or scene: {0}")]
    Gpu(String),
    /// The size exceeds this device or f32 arithmetic.
    #[error("{what} is {size}, but at most {limit} can be rendered: make it smaller")]
    TooLarge {
        /// Name of the oversized thing, as the start of a sentence.
        what: &'static str,
        /// Size that was requested.
        size: f64,
        /// Largest permitted size.
        limit: f64,
    },
    /// f32 cannot represent the light relative to the scene.
    #[error(transparent)]
    OutOfReach(#[from] light::UndrawableLight),
    /// The picture has no pixels, no samples, or an impossible camera.
    #[error("this view cannot be rendered: {0}")]
    InvalidView(&'static str),
    /// The shadow settings permit no map.
    #[error(transparent)]
    InvalidShadows(#[from] shadow::InvalidSettings),
    /// The AOV is of a light that does not exist.
    #[error("there is no light {index} to show, this picture has {count}: choose one of them or another AOV")]
    NoSuchLight {
        /// The requested index.
        index: usize,
        /// Number of lights.
        count: usize,
    },
    /// The light has no bent map, so it has no wireframe.
    #[error("only a BendyLight or a spotlight has a wireframe: choose another light or another AOV")]
    NoWireframe,
    /// The file format cannot hold the picture.
    #[error("the picture cannot be encoded ({0}): make it smaller")]
    Encode(String),
    /// The client cancelled the picture.
    #[error("the picture was cancelled: ask for it again")]
    Cancelled,
    /// The light has numbers outside their domains.
    #[error(transparent)]
    Light(#[from] light::LightError),
}

impl RenderError {
    /// Returns [`Self::TooLarge`] if `size` exceeds `limit`. `what` names the thing with its unit.
    pub(crate) fn check_size(what: &'static str, size: u64, limit: u64) -> Result<(), Self> {
        if size > limit {
            return Err(Self::TooLarge { what, size: size as f64, limit: limit as f64 });
        }
        Ok(())
    }
}

impl From<relight::Cancelled> for RenderError {
    fn from(_: relight::Cancelled) -> Self {
        Self::Cancelled
    }
}
