//! Visibility buffers against rays in f64.

use glam::{DVec3, Mat4, Vec3, Vec4};

use super::Random;
use crate::raster::{PicturePart, VisibilityBuffer, VisibilityBuilder, VisibleTriangles};
use crate::{AlphaTests, CameraRays, CasterHierarchy, CasterLinks, CasterScene, Workers};

const SIZE: [usize; 2] = [70, 50];
const NEAR: f32 = 0.1;
/// Slopes of the picture's right and upper edges.
const SLOPES: [f32; 2] = [0.7, 0.5];

/// Triangles before a camera at the origin that looks along -z.
struct Soup {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    planes: Vec<[f32; 4]>,
    both_sides: Vec<u32>,
}

impl Soup {
    fn new(corners: Vec<[f32; 3]>, has_both_sides: impl Fn(usize) -> bool) -> Self {
        let planes = corners.as_chunks::<3>().0.iter().map(|corners| {
            let [a, b, c] = corners.map(|corner| Vec3::from(corner).as_dvec3());
            let normal = (b - a).cross(c - a).normalize_or_zero();
            [normal.x, normal.y, normal.z, normal.dot(a)].map(|x| x as f32)
        });
        let planes: Vec<_> = planes.collect();
        let mut both_sides = vec![0; planes.len().div_ceil(32)];
        for triangle in (0..planes.len()).filter(|triangle| has_both_sides(*triangle)) {
            both_sides[triangle / 32] |= 1 << (triangle % 32);
        }
        Self { indices: (0..corners.len() as u32).collect(), positions: corners, planes, both_sides }
    }

    /// Draws a part of the picture: the triangle + 1 and z of each pixel.
    fn drawn(&self, first: [usize; 2], size: [usize; 2], threads: usize) -> Vec<(u32, f32)> {
        let scene = CasterScene {
            positions: &self.positions,
            indices: &self.indices,
            planes: &self.planes,
            hierarchy: CasterHierarchy { nodes: &[], triangles: &[] },
            attributes: &[],
            opaque_triangles: self.planes.len() as u32,
            alpha_tests: AlphaTests::default(),
            links: CasterLinks::default(),
        };
        let [right, up] = SLOPES;
        let clip_from_scene = Mat4::from_cols(Vec4::X / right, Vec4::Y / up, Vec4::NEG_W, Vec4::Z * NEAR);
        let [dx, dy] = [2.0 * right / SIZE[0] as f32, -2.0 * up / SIZE[1] as f32];
        let camera = CameraRays {
            origin: [0.0; 3],
            origin_dx: [0.0; 3],
            origin_dy: [0.0; 3],
            direction: [0.5 * dx - right, 0.5 * dy + up, -1.0],
            direction_dx: [dx, 0.0, 0.0],
            direction_dy: [0.0, dy, 0.0],
            depth_from_z: [NEAR, 0.0, 0.0, 1.0],
            tile_origin: first.map(|pixels| pixels as f32),
        };
        let part = PicturePart { clip_from_scene, near: Some(NEAR), camera, whole: SIZE, first, size };
        let triangles = VisibleTriangles { scene: &scene, both_sides: &self.both_sides };
        let mut visible = VisibilityBuffer::default();
        let workers = Workers::with_threads(threads);
        VisibilityBuilder::default().draw(&workers, &triangles, &part, &mut visible).expect("not cancelled");
        (0..size[1])
            .flat_map(|row| (0..size[0]).map(move |column| (column, row)))
            .map(|(x, y)| visible.at(x, y))
            .collect()
    }

    /// Returns the nearest triangle + 1 on the ray through a point of the picture, 0 if there is none, and the distances
    /// of the first two along the view axis.
    fn nearest(&self, [x, y]: [f64; 2]) -> (u32, [f64; 2]) {
        let slope = |at: f64, side: usize, slope: f32| (2.0 * at / side as f64 - 1.0) * f64::from(slope);
        let ray = DVec3::new(slope(x, SIZE[0], SLOPES[0]), -slope(y, SIZE[1], SLOPES[1]), -1.0);
        let mut found = (0, [f64::INFINITY; 2]);
        for (index, corners) in self.positions.as_chunks::<3>().0.iter().enumerate() {
            let [a, b, c] = corners.map(|corner| Vec3::from(corner).as_dvec3());
            let volume = a.dot(b.cross(c));
            // Seen from behind, the volume is positive.
            if volume == 0.0 || volume > 0.0 && self.both_sides[index / 32] >> (index % 32) & 1 == 0 {
                continue;
            }
            let shares = [b.cross(c), c.cross(a), a.cross(b)].map(|normal| ray.dot(normal) / volume);
            let distance = shares.iter().sum::<f64>().recip();
            if shares.iter().all(|share| *share >= 0.0) && distance >= f64::from(NEAR) {
                let [first, second] = found.1;
                if distance < first {
                    found = (index as u32 + 1, [distance, first]);
                } else {
                    found.1[1] = second.min(distance);
                }
            }
        }
        found
    }

    /// Returns the pixels at which the nearest triangle is certain, each with it, and how many pixels are not judged.
    fn judged(&self) -> (Vec<(usize, u32, f64)>, usize) {
        let mut judged = Vec::new();
        for (pixel, (row, column)) in (0..SIZE[1]).flat_map(|row| (0..SIZE[0]).map(move |x| (row, x))).enumerate() {
            let at = |dx: f64, dy: f64| self.nearest([column as f64 + 0.5 + dx, row as f64 + 0.5 + dy]);
            let (triangle, [first, second]) = at(0.0, 0.0);
            // Corners are rounded to 1/256 of a pixel.
            let around = [(-0.01, -0.01), (0.01, -0.01), (-0.01, 0.01), (0.01, 0.01)];
            let is_stable = around.into_iter().all(|(dx, dy)| at(dx, dy).0 == triangle);
            if is_stable && second > first * 1.001 {
                judged.push((pixel, triangle, first));
            }
        }
        let unjudged = SIZE[0] * SIZE[1] - judged.len();
        (judged, unjudged)
    }
}

/// Returns triangles of all sizes: some behind the camera, some through its near plane, some seen from behind.
fn soup(has_both_sides: impl Fn(usize) -> bool) -> Soup {
    let mut random = Random(7);
    let mut corners = Vec::new();
    for triangle in 0..160 {
        let size = [0.05, 0.3, 1.5, 20.0][triangle % 4];
        let middle = [random.real(-3.0, 3.0), random.real(-2.0, 2.0), random.real(-9.0, 0.5)];
        for _ in 0..3 {
            corners.push(middle.map(|x| x + random.real(-size, size)));
        }
    }
    Soup::new(corners, has_both_sides)
}

fn wrong(drawn: &[(u32, f32)], judged: &[(usize, u32, f64)]) -> usize {
    judged.iter().filter(|(pixel, triangle, _)| drawn[*pixel].0 != *triangle).count()
}

#[test]
fn each_pixel_shows_the_nearest_triangle() {
    let soup = soup(|triangle| triangle % 3 == 0);
    let (judged, unjudged) = soup.judged();
    assert!(unjudged * 10 < judged.len(), "{unjudged} of {}", judged.len());
    let drawn = soup.drawn([0, 0], SIZE, 2);
    assert_eq!(wrong(&drawn, &judged), 0);
    for (pixel, triangle, distance) in judged.iter().filter(|(_, triangle, _)| *triangle != 0) {
        let (_, z) = drawn[*pixel];
        let found = f64::from(NEAR / z);
        // f32 rounds positions, normals and the three products: some ulps, more where a plane is seen at a small angle.
        assert!((found - distance).abs() < 1e-3 * distance, "{found} for {distance} of {triangle}");
    }
    // Deliberate faults that the check must detect: the sides of triangles exchanged, and a picture shifted by a pixel.
    let mut turned = self::soup(|triangle| triangle % 3 == 0);
    turned.both_sides.iter_mut().for_each(|word| *word = !*word);
    assert!(wrong(&turned.drawn([0, 0], SIZE, 2), &judged) > 100);
    let shifted: Vec<_> = drawn.iter().copied().cycle().skip(1).take(drawn.len()).collect();
    assert!(wrong(&shifted, &judged) > 100);
}

#[test]
fn a_part_has_the_bits_of_the_whole_with_any_number_of_threads() {
    let soup = soup(|_| true);
    let whole = soup.drawn([0, 0], SIZE, 1);
    assert!(whole == soup.drawn([0, 0], SIZE, 8));
    let part_of = |[left, top]: [usize; 2], [width, height]: [usize; 2]| {
        let rows = whole.chunks(SIZE[0]).skip(top).take(height);
        rows.flat_map(|row| row[left..left + width].to_vec()).collect::<Vec<_>>()
    };
    for (first, size) in [([0, 0], [70, 1]), ([16, 32], [33, 18]), ([69, 49], [1, 1]), ([5, 7], [20, 40])] {
        assert!(soup.drawn(first, size, 2) == part_of(first, size), "{first:?}, {size:?}");
    }
    // Deliberate fault that the check must detect: a part from elsewhere.
    assert!(soup.drawn([16, 32], [33, 18], 2) != part_of([17, 32], [33, 18]));
}

/// A carpet on a floor, each of triangles of its own: everywhere the first one wins, and from every part of the picture.
#[test]
fn of_coincident_surfaces_the_first_wins_everywhere() {
    let rectangle = |half: [f32; 2], turn: bool| {
        let corner = |x: f32, z: f32| [x * half[0], -0.61, z * half[1] - 4.0];
        let [a, b, c, d] = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
        if turn { [a, b, d, b, c, d] } else { [a, b, c, a, c, d] }
    };
    let corners = [rectangle([3.3, 3.1], false), rectangle([1.7, 2.3], true)].concat();
    let drawn = Soup::new(corners.clone(), |_| true).drawn([0, 0], SIZE, 2);
    let count = |drawn: &[(u32, f32)], ids: [u32; 2]| drawn.iter().filter(|(id, _)| ids.contains(id)).count();
    assert!(count(&drawn, [1, 2]) > 500 && count(&drawn, [3, 4]) == 0);
    // Deliberate fault that the check must detect: a carpet that lies higher is seen.
    let raised = corners.iter().enumerate().map(|(k, [x, y, z])| [*x, if k < 6 { *y } else { y + 1e-3 }, *z]);
    assert!(count(&Soup::new(raised.collect(), |_| true).drawn([0, 0], SIZE, 2), [3, 4]) > 100);
}
