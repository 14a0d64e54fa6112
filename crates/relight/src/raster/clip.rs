//! Clipping of triangles that reach behind the source of the light, or so far aside that the face coordinates of their
//! corners are too large for exact computation.

/// Corner in clip coordinates (x, y, w), with its value and further interpolated numbers.
pub(super) type ClipCorner<const N: usize> = [f32; N];

/// Most corners of a triangle after clipping by five planes.
const MAX_CORNERS: usize = 8;

/// Corners of a convex polygon, in order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Polygon<const N: usize> {
    corners: [ClipCorner<N>; MAX_CORNERS],
    count: usize,
}

impl<const N: usize> Polygon<N> {
    /// Clips a triangle to w >= `least_w`, |x| <= `guard[0]` w and |y| <= `guard[1]` w. The polygon is empty if nothing
    /// remains, if a coordinate is not finite, or if a corner is the origin, from which the triangle is seen edge on.
    ///
    /// Two triangles that share an edge get the same corners on it: interpolation goes from inside to outside, whatever
    /// the winding, and corners inside stay as they are.
    pub fn clip(triangle: [ClipCorner<N>; 3], least_w: f32, guard: [f32; 2]) -> Self {
        let mut polygon = Self { corners: [[0.0; N]; MAX_CORNERS], count: 0 };
        let is_finite = triangle.as_flattened().iter().all(|x| x.is_finite());
        if is_finite && triangle.iter().all(|corner| corner[..3] != [0.0; 3]) {
            polygon.corners[..3].copy_from_slice(&triangle);
            polygon.count = 3;
        }
        let [right, up] = guard.map(f64::from);
        // Coefficients of x, y, w and 1. The part where their sum is negative is clipped.
        let planes = [
            [0.0, 0.0, 1.0, -f64::from(least_w)],
            [-1.0, 0.0, right, 0.0],
            [1.0, 0.0, right, 0.0],
            [0.0, -1.0, up, 0.0],
            [0.0, 1.0, up, 0.0],
        ];
        for plane in planes {
            polygon = polygon.clip_by_plane(plane);
        }
        polygon
    }

    /// Splits the polygon into triangles.
    pub fn triangles(&self) -> impl Iterator<Item = [ClipCorner<N>; 3]> {
        let corners = &self.corners[..self.count];
        corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]])
    }

    fn clip_by_plane(&self, plane: [f64; 4]) -> Self {
        let mut cut = Self { corners: [[0.0; N]; MAX_CORNERS], count: 0 };
        let mut push = |corner: ClipCorner<N>| {
            cut.corners[cut.count] = corner;
            cut.count += 1;
        };
        for k in 0..self.count {
            let (here, next) = (self.corners[k], self.corners[(k + 1) % self.count]);
            let (height, next_height) = (height(here, plane), height(next, plane));
            if height >= 0.0 {
                push(here);
            }
            if height >= 0.0 && next_height < 0.0 {
                push(between(here, next, height / (height - next_height)));
            } else if height < 0.0 && next_height >= 0.0 {
                push(between(next, here, next_height / (next_height - height)));
            }
        }
        cut
    }
}

fn height<const N: usize>(corner: ClipCorner<N>, plane: [f64; 4]) -> f64 {
    f64::from(corner[0]) * plane[0] + f64::from(corner[1]) * plane[1] + f64::from(corner[2]) * plane[2] + plane[3]
}

fn between<const N: usize>(inside: ClipCorner<N>, outside: ClipCorner<N>, share: f64) -> ClipCorner<N> {
    std::array::from_fn(|k| (f64::from(inside[k]) + share * (f64::from(outside[k]) - f64::from(inside[k]))) as f32)
}
