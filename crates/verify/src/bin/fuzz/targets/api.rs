//! Frames, settings, cameras and lights that a program might make.

use std::sync::Arc;

use anyhow::{Result, ensure};
use glam::{Quat, Vec2, Vec3};
use umbrage::rays::{Camera, Choice as _, LightSource, Projection};
use umbrage::scene::{Alpha, Frame, Light, LightShape, TextureUse};
use umbrage::{Background, CameraChoice, Renderer, Scene, Settings, Sides, Structure, WorkCounts};
use umbrage_papers::structures;
use umbrage_verify::{Random, TestMesh};

use super::{Answer, Target, check_film, files};
use crate::mutate::{REAL, any};
use crate::worker::Workplace;

/// The renderer and its answers, for scenes of the corpus with changes that a program might make.
pub(crate) struct Api {
    scenes: Vec<Scene>,
}

impl Api {
    pub(crate) fn open() -> Result<Self> {
        Ok(Self { scenes: files::scenes()? })
    }
}

impl Target for Api {
    fn run(&mut self, random: &mut Random, _: &mut Workplace<'_>) -> Result<Answer> {
        let mut renderer = Renderer::default();
        let mut answer = Answer::Refused;
        // The second frame finds the first one's memory.
        for _ in 0..2 {
            let mut frame = any(random, &self.scenes).at(f64::from(random.unit()))?;
            let mut dice = Dice { odd: *any(random, &[0, 0, 1, 4]), random };
            if dice.one_in(2) {
                let mesh = TestMesh::bad_shapes(dice.random);
                frame = Frame { lights: frame.lights, ..Frame::from_triangles(mesh.positions, mesh.indices) };
            }
            let mut settings = dice.settings();
            for _ in 0..dice.random.below(6) {
                dice.change(&mut frame, &mut settings);
            }
            let is_good = frame.check_lit_by(settings.lights.as_ref().unwrap_or(&frame.lights)).is_ok();
            if let Ok(film) = renderer.render_frame(&frame, &settings) {
                ensure!(is_good, "a frame that is none is rendered");
                check_film(film, &frame)?;
                let image = film.develop(&settings);
                ensure!(image.pixels.len() == film.color.len(), "the picture has another size");
                answer = Answer::Accepted;
            }
            let light = dice.random.below(3);
            renderer.count_work(&frame, &settings, Some(light), &mut WorkCounts::default()).ok();
            let Ok(view) = settings.view(&frame) else { continue };
            let Ok(seen) = renderer.see(&frame, &view) else { continue };
            let masks = renderer.shadow(&seen, &frame.lights)?;
            ensure!(masks.len() == frame.lights.len(), "{} masks for {} lights", masks.len(), frame.lights.len());
        }
        Ok(answer)
    }
}

/// Random values; `odd` of sixteen are absurd.
struct Dice<'a> {
    random: &'a mut Random,
    odd: usize,
}

impl Dice<'_> {
    fn one_in(&mut self, count: usize) -> bool {
        self.random.below(count) == 0
    }

    /// From −1 to 1, or absurd.
    fn number(&mut self) -> f32 {
        let is_odd = self.random.below(16) < self.odd;
        if is_odd { *any(self.random, &REAL) as f32 } else { 2.0 * self.random.unit() - 1.0 }
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }

    /// An index below `count`, or absurd.
    fn index(&mut self, count: usize) -> u32 {
        let is_odd = self.random.below(16) < self.odd;
        if is_odd { u32::MAX >> self.random.below(32) } else { self.random.below(count.max(1)) as u32 }
    }

    fn light(&mut self) -> Light {
        let (position, direction, inner_radians) = (self.vector() * 3.0, self.vector(), 0.5 * self.number().abs());
        let source = match self.random.below(3) {
            0 => LightSource::Point { position },
            1 => LightSource::Directional { direction: direction.normalize_or_zero() },
            _ => LightSource::Spot { position, direction, inner_radians, outer_radians: 2.0 * inner_radians },
        };
        let (range, casts_shadow) = (self.one_in(3).then(|| 5.0 * self.number().abs()), !self.one_in(4));
        Light { color: self.vector(), range, casts_shadow, ..Light::new(source, 10.0 * self.number()) }
    }

    fn wide_light(&mut self) -> Light {
        let mut light = self.light();
        light.shape = match self.random.below(3) {
            0 => LightShape::Ball(self.number()),
            1 => LightShape::Disk(self.number()),
            _ => LightShape::Rectangle { width: self.number(), height: self.number() },
        };
        if light.shape.is_flat() && !self.one_in(4) {
            light.source = LightSource::to_one_side(self.vector() * 3.0, self.vector());
        }
        light
    }

    fn camera(&mut self) -> Camera {
        let turn = Quat::from_rotation_y(self.number() * 3.0) * Quat::from_rotation_x(self.number() * 1.6);
        let position = turn * Vec3::Z * 3.0 + self.vector();
        let camera = Camera::look_at(position, self.vector(), Vec3::Y, 3.0 * self.number().abs());
        let projection = Projection::Orthographic { half_height: self.number() };
        if self.one_in(3) { Camera { projection, ..camera } } else { camera }
    }

    fn settings(&mut self) -> Settings {
        let known: Vec<Structure> = structures().iter().cloned().collect();
        let options: Vec<_> = known.iter().flat_map(Structure::options).collect();
        let mut structure = any(self.random, &known).clone();
        for _ in 0..self.random.below(3) {
            let (option, value) = (any(self.random, &options), self.random.below(70));
            structure.set_option(option.name, &value.to_string()).ok();
        }
        Settings {
            width: 1 + self.random.below(9) as u32,
            height: 1 + self.random.below(9) as u32,
            camera: if self.one_in(2) { CameraChoice::Own(self.camera()) } else { CameraChoice::Default },
            lights: self.one_in(3).then(|| (0..self.random.below(3)).map(|_| self.light()).collect()),
            structure,
            sides: any(self.random, Sides::CHOICES).1,
            bounces: self.random.below(3) as u32,
            ..Settings::default()
        }
    }

    /// Changes one thing that a program may set, within its range or not.
    fn change(&mut self, frame: &mut Frame, settings: &mut Settings) {
        let (mesh, materials) = (Arc::make_mut(&mut frame.mesh), Arc::make_mut(&mut frame.materials));
        let (vertices, textures) = (frame.positions.len(), materials.textures.len());
        let of_materials = materials.materials.len();
        let vertex = self.random.below(vertices);
        let triangle = self.random.below(mesh.triangles.len());
        let material = &mut materials.materials[self.random.below(of_materials)];
        match self.random.below(27) {
            0..4 => frame.positions[vertex] = self.vector() * 3.0,
            4 => frame.normals = (0..vertices).map(|_| self.vector().normalize_or_zero()).collect(),
            5 => frame.tangents = (0..vertices).map(|_| self.vector().extend(1.0)).collect(),
            6 => mesh.tex_coords[0] = (0..vertices).map(|_| Vec2::new(self.number(), self.number())).collect(),
            7 => mesh.colors = (0..vertices).map(|_| self.vector().extend(self.number())).collect(),
            8 => drop(frame.normals.pop()),
            9 => mesh.triangles[triangle][1] = self.index(vertices),
            10 => mesh.material_of_triangle[triangle] = self.index(of_materials),
            11 => material.base_color_texture = Some(TextureUse::new(self.index(textures))),
            12 => material.base_color = self.vector().extend(self.number()),
            13 => (material.metallic, material.roughness) = (self.number(), self.number()),
            14 => (material.emissive, material.normal_scale) = (self.vector(), self.number()),
            15 => material.alpha = *any(self.random, &[Alpha::Mask { cutoff: 0.5 }, Alpha::Blend]),
            16 => (material.transmission, material.ior) = (self.number(), 1.0 + self.number()),
            17 => frame.lights.push(self.light()),
            18 => settings.width = self.index(9).min(1 << 15),
            19 => settings.samples = self.index(3).min(9),
            20 => settings.bounces = self.index(3),
            21 => settings.background = Background::Color(self.vector()),
            22 => settings.exposure_stops = self.number(),
            23 => (settings.samples, settings.aperture) = (2, self.number()),
            24 => (settings.samples, settings.light_radius) = (2, self.number().abs()),
            25 => settings.lights = Some(vec![self.wide_light()]),
            _ => settings.camera = CameraChoice::Scene(self.index(2) as usize),
        }
    }
}
