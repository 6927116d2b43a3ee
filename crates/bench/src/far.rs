//! Scenes with one triangle that reaches far beyond all others.

use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4};
use umbrage::rays::Camera;
use umbrage::scene::{Frame, Mesh};

/// How far away, in diagonals of the scene.
const DISTANCE: f32 = 1e7;

/// The part of the scene's last triangle that is moved.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Far {
    /// One corner, to one side.
    Vertex,
    /// All of it, behind everything, as large as covers the whole image.
    Triangle,
}

impl Far {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Vertex => "far vertex",
            Self::Triangle => "far triangle",
        }
    }

    /// Gives the last triangle three vertices of its own and moves them. A mesh that was changed in the last frame stays the same
    /// one, as structures know it again.
    pub(crate) fn place(self, frame: &mut Frame, camera: &Camera, last: &mut Option<[Arc<Mesh>; 2]>) {
        let bounds = frame.triangles().bounds();
        let Some(&[a, b, _]) = frame.mesh.triangles.last() else { return };
        let distance = DISTANCE * bounds.size().length();
        let Camera { position, right, up, forward, .. } = *camera;
        let corners = match self {
            Self::Vertex => {
                let aside = bounds.center() + right * distance;
                [frame.positions[a as usize], frame.positions[b as usize], aside]
            }
            // As seen from the camera, counterclockwise.
            Self::Triangle => [-6.0 * right - 3.0 * up, 6.0 * right - 3.0 * up, 6.0 * up]
                .map(|across| position + (forward + across) * distance),
        };
        let first = frame.positions.len();
        frame.positions.extend(corners);
        lengthen(&mut frame.normals, Vec3::ZERO);
        lengthen(&mut frame.tangents, Vec4::ZERO);
        let changed = match last {
            Some([source, changed]) if Arc::ptr_eq(source, &frame.mesh) => Arc::clone(changed),
            _ => Arc::new(with_own_vertices(&frame.mesh, first as u32)),
        };
        let source = std::mem::replace(&mut frame.mesh, Arc::clone(&changed));
        *last = Some([source, changed]);
    }
}

/// The mesh, whose last triangle has the next three vertices.
fn with_own_vertices(mesh: &Mesh, first: u32) -> Mesh {
    let mut mesh = mesh.clone();
    if let Some(last) = mesh.triangles.last_mut() {
        *last = [first, first + 1, first + 2];
    }
    mesh.tex_coords.iter_mut().for_each(|coords| lengthen(coords, Vec2::ZERO));
    lengthen(&mut mesh.colors, Vec4::ONE);
    mesh
}

/// Values for three more vertices, unless no vertex has any.
fn lengthen<T: Copy>(values: &mut Vec<T>, value: T) {
    if !values.is_empty() {
        values.extend([value; 3]);
    }
}

#[cfg(test)]
mod tests {
    use umbrage::rays::SeenPixels;
    use umbrage::{Renderer, Settings};

    use super::*;

    #[test]
    fn one_triangle_is_far_away_and_one_covers_the_image() {
        let scene = umbrage::open("demo:cloth?triangles=300").unwrap();
        let settings = |camera| Settings { width: 24, height: 16, camera, ..Settings::default() };
        for far in [Far::Vertex, Far::Triangle] {
            let (mut renderer, mut last, mut meshes) = (Renderer::default(), None, Vec::new());
            for seconds in [0.0, 0.1] {
                let mut frame = scene.at(seconds).unwrap();
                let (camera, size) = (frame.camera(1.5), frame.triangles().bounds().size().length());
                far.place(&mut frame, &camera, &mut last);
                frame.check().unwrap();
                assert!(frame.triangles().bounds().size().length() > 0.9 * DISTANCE * size, "{far:?}");
                renderer.render_frame(&frame, &settings(camera.into())).unwrap();
                meshes.push(Arc::clone(&frame.mesh));
                let is_everywhere = renderer.film().triangle.iter().all(|&triangle| triangle != SeenPixels::NONE);
                assert!(is_everywhere || matches!(far, Far::Vertex), "{far:?}");
            }
            assert!(Arc::ptr_eq(&meshes[0], &meshes[1]), "{far:?}");
        }
    }
}
