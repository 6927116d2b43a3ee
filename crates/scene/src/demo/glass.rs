use glam::{Vec2, Vec3};
use umbrage_rays::LightSource;

use super::DemoScene;
use super::build::math::{camera, wave};
use super::build::{MeshBuilder, Palette, srgb};
use crate::still::Still;
use crate::{Frame, Light, NamedCamera};

/// Spheres of glass and mirror on a board.
#[derive(Debug)]
pub(crate) struct Glass {
    still: Still,
}

impl Glass {
    pub(crate) const SCENE: DemoScene =
        DemoScene { name: "glass", about: "spheres of glass and mirror", triangles: 60_000 };

    pub(crate) fn open(triangles: usize) -> Self {
        let mut palette = Palette::default();
        let floor = palette.dull("floor", srgb(0xd8d2c8), 0.6);
        let mut builder = MeshBuilder::new();
        builder.material(floor).floor(Vec3::ZERO, Vec2::splat(12.0), [1, 1]);
        let rows = (triangles as f32 / 4.0).sqrt() as u32;
        builder.material(floor).sphere(Vec3::Y, 1.0, 2 * rows, rows + 1);
        Self { still: builder.finish(palette.finish()) }
    }

    pub(crate) fn duration_seconds(&self) -> f64 {
        8.0
    }

    pub(crate) fn pose(&self, seconds: f64, frame: &mut Frame) {
        self.still.pose(frame);
        let turns = (seconds / self.duration_seconds()) as f32;
        let eye = Vec3::new(6.0 * wave(turns), 3.0, 6.0 * wave(turns + 0.25));
        frame.cameras.push(NamedCamera { name: "main".into(), camera: camera(eye, Vec3::Y, 0.4) });
        let position = Vec3::new(3.0, 5.0, 2.0);
        let source = LightSource::Point { position };
        let intensity = std::f32::consts::PI * position.length_squared();
        frame.lights.push(Light { name: "lamp".into(), source, color: Vec3::ONE, intensity, range: None });
    }
}
