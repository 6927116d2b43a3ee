//! The subject of a scene: its moving triangles, or else the scene without a vast floor, stadium or sky around it.

use glam::Vec3;
use umbrage::Scene;
use umbrage::rays::Bounds;
use umbrage::scene::Frame;

/// Fractions of the animation at which poses are compared. No periodic motion with a few cycles is equal at all of them.
const MOMENTS: [f64; 5] = [0.0, 0.13, 0.37, 0.61, 0.83];

/// Bounds of the subject at a time; `None` for an empty scene.
pub(crate) fn bounds(scene: &Scene, seconds: f64) -> Option<Bounds> {
    let frame = scene.at(seconds).ok()?;
    let moves = moves(scene, &frame);
    let moving =
        BySize::of(triangles(&frame).filter(|triangle| triangle.iter().any(|&vertex| moves[vertex as usize])), &frame);
    let of_all = || BySize::of(triangles(&frame), &frame);
    let chosen = if moving.count() > 0 { moving } else { of_all() };
    Some(chosen.subject()).filter(|bounds| !bounds.is_empty())
}

/// The scene's own triangles, without an added ground.
fn triangles(frame: &Frame) -> impl Iterator<Item = [u32; 3]> {
    let mesh = &*frame.mesh;
    let own = mesh.triangles.len().saturating_sub(mesh.ground_triangles);
    mesh.triangles[..own].iter().copied()
}

/// For each vertex of a frame, whether its position differs at another time. Poses with another number of vertices
/// are skipped.
fn moves(scene: &Scene, frame: &Frame) -> Vec<bool> {
    /// Maximum displacement of a resting vertex, relative to the scene's size: rounding of animations.
    const REST: f32 = 1e-6;
    let still = REST * Bounds::of_points(frame.positions.iter().copied()).size().length();
    let mut moves = vec![false; frame.positions.len()];
    let mut other = Frame::default();
    for part in MOMENTS {
        let moment = part * scene.duration_seconds();
        if scene.pose(moment, &mut other).is_err() || other.positions.len() != moves.len() {
            continue;
        }
        for (moves, (here, there)) in moves.iter_mut().zip(frame.positions.iter().zip(&other.positions)) {
            *moves |= here.distance(*there) > still;
        }
    }
    moves
}

/// Triangles grouped by their size's power of two, with each group's number and bounds.
struct BySize {
    classes: [(usize, Bounds); Self::CLASSES],
}

impl BySize {
    /// One per exponent of an f32.
    const CLASSES: usize = 256;

    fn of(triangles: impl Iterator<Item = [u32; 3]>, frame: &Frame) -> Self {
        let mut classes = [(0, Bounds::EMPTY); Self::CLASSES];
        for triangle in triangles {
            let bounds = Bounds::of_points(triangle.map(|vertex| frame.positions[vertex as usize]));
            let exponent = bounds.size().max_element().to_bits() >> 23;
            let (count, around) = &mut classes[exponent as usize % Self::CLASSES];
            (*count, *around) = (*count + 1, around.union(bounds));
        }
        Self { classes }
    }

    fn count(&self) -> usize {
        self.classes.iter().map(|(count, _)| count).sum()
    }

    /// Bounds of the triangles in order of size, up to the first group that would be vast around the smaller ones; of all
    /// triangles where there is no such group.
    fn subject(&self) -> Bounds {
        /// At least 1 / `SHARE` of all triangles must be in the box.
        const SHARE: usize = 4;
        let (all, mut inside, mut subject) = (self.count(), 0, Bounds::EMPTY);
        for &(count, bounds) in &self.classes {
            if count > 0 && SHARE * inside >= all && is_vast(subject.union(bounds), subject) {
                break;
            }
            (inside, subject) = (inside + count, subject.union(bounds));
        }
        subject
    }
}

/// Whether `around` is far wider and deeper than the longest side of `inner`. Boxes that are only higher aren't vast, such
/// as a body below its head.
fn is_vast(around: Bounds, inner: Bounds) -> bool {
    const TIMES: f32 = 4.0;
    let longest = inner.size().max_element();
    let Vec3 { x: width, z: depth, .. } = around.size();
    longest > 0.0 && width.min(depth) > TIMES * longest
}

#[cfg(test)]
mod tests {
    use umbrage::scene::{Animated, Error, Ground};

    use super::*;

    /// A flat grid of squares of two triangles each, of side `width` around a point.
    struct Sheet {
        center: Vec3,
        width: f32,
        squares: u32,
    }

    impl Sheet {
        fn add_to(&self, positions: &mut Vec<Vec3>, triangles: &mut Vec<[u32; 3]>) {
            let (first, side) = (positions.len() as u32, self.squares + 1);
            let at = |index: u32| self.width * (index as f32 / self.squares as f32 - 0.5);
            let corners =
                (0..side * side).map(|corner| self.center + Vec3::new(at(corner % side), 0.0, at(corner / side)));
            positions.extend(corners);
            for corner in (0..self.squares).flat_map(|row| (0..self.squares).map(move |column| row * side + column)) {
                let [near, far] = [first + corner, first + corner + side];
                triangles.extend([[near, near + 1, far], [near + 1, far + 1, far]]);
            }
        }
    }

    /// A small sheet over a floor. The sheet moves up and down by `height`, or stays.
    #[derive(Debug)]
    struct OnFloor {
        floor_squares: u32,
        height: f32,
    }

    impl Animated for OnFloor {
        fn duration_seconds(&self) -> f64 {
            2.0
        }

        fn pose(&self, seconds: f64, frame: &mut Frame) -> Result<(), Error> {
            let height = self.height * (std::f64::consts::TAU * seconds).sin() as f32;
            let (mut positions, mut triangles) = (Vec::new(), Vec::new());
            let floor = Sheet { center: Vec3::ZERO, width: 4000.0, squares: self.floor_squares };
            let subject = Sheet { center: Vec3::new(30.0, 2.0 + height, -5.0), width: 1.0, squares: 20 };
            floor.add_to(&mut positions, &mut triangles);
            subject.add_to(&mut positions, &mut triangles);
            *frame = Frame::from_triangles(positions, triangles);
            Ok(())
        }
    }

    fn scene(floor_squares: u32, height: f32) -> Scene {
        Scene::new(Box::new(OnFloor { floor_squares, height })).expect("a scene")
    }

    fn sheet(height: f32) -> Bounds {
        Bounds { min: Vec3::new(29.5, height, -5.5), max: Vec3::new(30.5, height, -4.5) }
    }

    #[test]
    fn it_is_what_moves_where_it_is() {
        for floor_squares in [1, 100] {
            let scene = scene(floor_squares, 1.0);
            assert_eq!(bounds(&scene, 0.0), Some(sheet(2.0)));
            assert_eq!(bounds(&scene, 0.25), Some(sheet(3.0)));
        }
    }

    #[test]
    fn or_what_a_vast_floor_is_around() {
        for floor_squares in [1, 30] {
            let mut scene = scene(floor_squares, 0.0);
            assert_eq!(bounds(&scene, 0.0), Some(sheet(2.0)), "{floor_squares}");
            scene.set_ground(Some(Ground::default()));
            assert_eq!(bounds(&scene, 0.0), Some(sheet(2.0)), "{floor_squares} on a ground");
        }
    }

    #[test]
    fn a_floor_with_most_of_the_triangles_is_the_subject_itself() {
        let whole = bounds(&scene(100, 0.0), 0.0).expect("a floor");
        assert_eq!((whole.size().x, whole.size().z), (4000.0, 4000.0));
    }

    #[test]
    fn what_is_higher_but_no_wider_belongs_to_it() {
        let of = |size: Vec3| Bounds { min: -size, max: size };
        let (head, body, floor) = (of(Vec3::splat(0.1)), of(Vec3::new(0.8, 0.9, 0.2)), of(Vec3::new(9.0, 0.0, 9.0)));
        assert!(!is_vast(body, head) && is_vast(body.union(floor), body));
    }

    #[test]
    fn nothing_has_no_bounds() {
        #[derive(Debug)]
        struct Nothing;
        impl Animated for Nothing {
            fn duration_seconds(&self) -> f64 {
                0.0
            }

            fn pose(&self, _: f64, frame: &mut Frame) -> Result<(), Error> {
                *frame = Frame::default();
                Ok(())
            }
        }
        assert_eq!(bounds(&Scene::new(Box::new(Nothing)).expect("a scene"), 0.0), None);
    }
}
