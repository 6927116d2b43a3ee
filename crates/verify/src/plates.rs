use glam::Vec3;
use umbrage_rays::{Camera, LightSource, View};

use crate::lights::{point, sun};
use crate::views::{OFFSET_PIXELS, view};
use crate::{Case, Oracle, TestMesh, Truth};

/// A pile of plates above the part of a floor that one pixel shows, and above the camera. Each plate is within one of
/// 192² cells of the lights' views of the floor.
#[derive(Clone, Debug)]
pub struct Plates {
    /// The floor and the plates. The first plate is the highest; all have its shadow.
    pub mesh: TestMesh,
    view: View,
    lights: [LightSource; 2],
    middle: Vec3,
}

impl Plates {
    const PIXEL: [u32; 2] = [20, 15];

    /// The floor and its first plate.
    ///
    /// # Panics
    /// If the oracle doesn't find the floor at the pixel.
    #[must_use]
    pub fn one() -> Self {
        let mesh = TestMesh::floor(8);
        let camera = Camera::look_at(Vec3::new(0.2, 0.9, 1.5), Vec3::new(0.0, -1.0, 0.0), Vec3::Y, 0.7);
        let view = view(camera, 40, 30);
        let [x, y] = Self::PIXEL.map(f64::from);
        let ray = view.ray(x + OFFSET_PIXELS.x, y + OFFSET_PIXELS.y);
        let shaded = Oracle::new(mesh.triangles()).nearest(&ray, |_| true).expect("the floor").t;
        let middle = (ray.origin + ray.direction * shaded).as_vec3();
        // From straight above, all plates have the same shadow; from a lamp above their middle, the highest has the largest.
        let lights = [sun(0.0, -1.0, 0.0), point(middle.with_y(4000.0))];
        let mut plates = Self { mesh, view, lights, middle };
        plates.push(2.0);
        plates
    }

    /// Adds plates until there are `count`, each `step` below the last.
    pub fn pile(&mut self, count: u32, step: f32) {
        (1..count).for_each(|number| self.push(2.0 - step * number as f32));
    }

    /// The floor as the camera sees it.
    #[must_use]
    pub fn case(&self) -> Case {
        Case::new("plates", self.mesh.clone(), self.view, &self.lights)
    }

    /// The truth for any number of plates, from the oracle for the present ones.
    ///
    /// # Panics
    /// If the plates don't shadow the pixel, or shadow many others.
    #[must_use]
    pub fn truth(&self) -> Truth {
        let truth = self.case().truth();
        let [x, y] = Self::PIXEL;
        for lit in &truth.lit {
            assert!(!lit[(y * self.view.width + x) as usize] && lit.iter().filter(|&&lit| lit).count() > 1000);
        }
        truth
    }

    fn push(&mut self, height: f32) {
        let Vec3 { x, z, .. } = self.middle;
        let corners = [(-0.004, -0.003), (0.005, -0.004), (0.001, 0.005)];
        self.mesh.push(corners.map(|(along_x, along_z)| Vec3::new(x + along_x, height, z + along_z)));
    }
}
