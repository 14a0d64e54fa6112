//! Vectors and quaternions as JSON arrays.

/// Vector or color: `[x, y, z]`, `[r, g, b]`.
pub type Vec3 = [f64; 3];
/// Quaternion: `[x, y, z, w]`.
pub type Quat = [f64; 4];
