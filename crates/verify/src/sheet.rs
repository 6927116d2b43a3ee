use glam::{DVec2, Vec3};
use umbrage_rays::{Camera, LightSource, Projection, View};

use crate::{Random, TestMesh};

/// A crumpled sheet that fills a camera's view, with vertices exactly on pixels' rays.
///
/// Every `step`-th pixel of every `step`-th row has a vertex on its ray, at a depth of its own; the rays in between go
/// through edges or, if `step` is above two, also through faces. Diagonals and windings are random. Seen from the
/// camera, and so from a light at the same point, no part of the sheet hides another: every ray has to hit it, and
/// every point has to be lit.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// The sheet, or the sheet and a second one right behind it.
    pub mesh: TestMesh,
    /// Triangles of the first sheet; those of the second have higher ids.
    pub front: u32,
    /// The camera.
    pub view: View,
    /// Offset of each pixel's ray in the pixel.
    pub offset_pixels: DVec2,
    /// A light at the camera, or parallel to its rays.
    pub light: LightSource,
    shape: SheetShape,
}

/// Numbers of a [`Sheet`]'s pixels whose rays go exactly through shared features of triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seams {
    /// Through a vertex.
    pub vertices: u64,
    /// Through an edge, between its vertices.
    pub edges: u64,
}

/// Parameters of a [`Sheet`].
#[derive(Clone, Copy, Debug)]
pub struct SheetShape {
    /// Pixels a side of the image: a power of two, at most 1024.
    pub side: u32,
    /// Pixels between vertices: a divisor of `side`.
    pub step: u32,
    /// Position of the camera, in multiples of 1/64.
    pub position: Vec3,
    /// Scale of the whole: a power of two, at least 4 for positions that need all bits of an f32.
    pub scale: f32,
    /// Whether rays are parallel.
    pub is_orthographic: bool,
    /// Whether there is a second sheet 2⁻¹⁵ of the distance behind the first; `side` must be at most 128 then.
    pub has_shell: bool,
}

impl SheetShape {
    /// Positions of cameras and scales of their worlds: near and far, and about a millionth and a million.
    pub const PLACES: [(Vec3, f32); 6] = [
        (Vec3::ZERO, 1.0),
        (Vec3::ZERO, 1.0 / (1 << 20) as f32),
        (Vec3::ZERO, (1 << 20) as f32),
        (Vec3::new(148_376.0, 1_234.0, -223_423.0), 4.0),
        (Vec3::new(-96.25, 0.015_625, 131.5), 8.0),
        (Vec3::new(148_376.0, -223_423.0, 1_234.0), 1024.0),
    ];
}

impl Sheet {
    /// A random sheet of a shape.
    #[must_use]
    pub fn new(shape: SheetShape, random: &mut Random) -> Self {
        let SheetShape { side, step, position, scale, is_orthographic, has_shell } = shape;
        let axes = [[Vec3::X, Vec3::Y], [Vec3::Y, Vec3::Z], [Vec3::Z, Vec3::X]][random.below(3)];
        let (right, up) = (axes[0], axes[1]);
        let forward = -right.cross(up);
        let (projection, light) = if is_orthographic {
            (Projection::Orthographic { half_height: scale }, LightSource::Directional { direction: forward })
        } else {
            (Projection::Perspective { tan_half_height: 1.0 }, LightSource::Point { position })
        };
        let camera = Camera { position, right, up, forward, projection };
        let view = View { camera, width: side, height: side };

        // One more on each side, so that the view's border is covered too.
        let count = side / step + 3;
        // Powers of two leave room for the bits of the second sheet's depths.
        let choices: &[f32] = if has_shell { &[4.0, 8.0] } else { &[4.0, 5.0, 7.0, 8.0] };
        let depths: Vec<f32> = (0..count * count).map(|_| choices[random.below(choices.len())]).collect();
        let is_rising: Vec<bool> = (0..count * count).map(|_| random.below(2) == 0).collect();
        let at = |vertex: u32, behind: f32| {
            let (column, row) = (vertex % count, vertex / count);
            let across = |index: u32| 2.0 * (index as f32 - 1.0) * step as f32 / side as f32 - 1.0;
            let depth = depths[vertex as usize] * behind;
            let spread = if is_orthographic { 1.0 } else { depth };
            position + (right * (across(column) * spread) - up * (across(row) * spread) + forward * depth) * scale
        };
        let mut mesh = TestMesh::default();
        let [sheet, shell] = [1.0, 1.0 + 1.0 / 32_768.0];
        let sheets: &[f32] = if has_shell { &[sheet, shell] } else { &[sheet] };
        let mut front = 0;
        for &behind in sheets {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend((0..count * count).map(|vertex| at(vertex, behind)));
            for (column, row) in (0..count - 1).flat_map(|row| (0..count - 1).map(move |column| (column, row))) {
                let a = first + row * count + column;
                let [a, b, c, d] = [a, a + 1, a + count + 1, a + count];
                let halves =
                    if is_rising[(a - first) as usize] { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
                for mut half in halves {
                    half.rotate_left(random.below(3));
                    if random.below(2) == 0 {
                        half.swap(0, 1);
                    }
                    mesh.indices.push(half);
                }
            }
            front = if front == 0 { mesh.indices.len() as u32 } else { front };
        }
        Self { mesh, front, view, offset_pixels: DVec2::ZERO, light, shape }
    }

    /// Numbers of rays at seams of the sheet.
    #[must_use]
    pub fn seams(&self) -> Seams {
        let SheetShape { side, step, .. } = self.shape;
        let squares = u64::from(side / step).pow(2);
        // Each square has one corner, one side along each axis, and a diagonal of the same number of pixels in either
        // direction.
        Seams { vertices: squares, edges: 3 * u64::from(step - 1) * squares }
    }
}
