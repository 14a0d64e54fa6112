//! Functions of lights on the GPU, evaluated at points with the shaders of pictures, for `eval`, benchmarks and tests.

mod increasing_roots;
mod locate;
mod mapped;

pub use increasing_roots::increasing_roots;
pub use locate::locate;
pub use mapped::map_points;
