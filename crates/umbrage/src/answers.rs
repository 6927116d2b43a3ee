//! Answers without a picture: the triangle that each pixel sees, the lights that reach it, and the work of finding them.

use glam::DVec3;
use rayon::prelude::*;
use umbrage_rays::predicate::{self, HitPoint};
use umbrage_rays::{LightCells, LightMask, PixelWork, SeenPixels, View};
use umbrage_scene::{Frame, Light};

use crate::sampling::Sample;
use crate::{Error, Film, Renderer, Settings};

/// The hits of the rays through the middles of a view's pixels, in rows from the upper left corner.
#[derive(Clone, Debug)]
pub struct Seen<'a> {
    frame: &'a Frame,
    view: View,
    pixels: SeenPixels,
    /// Id of the nearest triangle; of several at equal distance the lowest. [`Seen::NO_TRIANGLE`] for a miss.
    pub triangle: Vec<u32>,
    /// Depth along [`Camera::forward`](umbrage_rays::Camera::forward), in world units; infinite for a miss.
    pub depth: Vec<f64>,
    /// Weights of the triangle's second and third corner at the hit, from 0 to 1; NaN for a miss.
    pub barycentric: Vec<[f32; 2]>,
    /// World position of the hit; NaN for a miss.
    pub position: Vec<DVec3>,
}

/// The work of finding each pixel's triangle.
#[derive(Clone, Debug, Default)]
pub struct WorkCounts {
    /// The work of camera rays.
    pub pixels: PixelWork,
    /// With a chosen light, the cell of its grid that each pixel's point is in.
    pub cells: LightCells,
}

impl<'a> Seen<'a> {
    /// The value of [`Seen::triangle`] for a miss.
    pub const NO_TRIANGLE: u32 = SeenPixels::NONE;

    fn new(frame: &'a Frame, view: View, pixels: SeenPixels) -> Self {
        let hits = (0..view.width as usize * view.height as usize).into_par_iter().map(|pixel| {
            let (x, y) = (pixel as u32 % view.width, pixel as u32 / view.width);
            let ray = Sample::MIDDLE.ray(&view, x, y);
            let triangle = pixels.triangle_at(x, y);
            let is_hit = triangle != Self::NO_TRIANGLE;
            match is_hit.then(|| predicate::hit(&ray, frame.triangles(), triangle)).flatten() {
                Some(hit) => ((triangle, hit.t), (hit.barycentric, HitPoint::new(&ray, hit.t).position)),
                None => ((triangle, f64::INFINITY), ([f32::NAN; 2], DVec3::NAN)),
            }
        });
        let ((triangle, depth), (barycentric, position)) = hits.unzip();
        Self { frame, view, pixels, triangle, depth, barycentric, position }
    }
}

impl Renderer {
    /// Finds the triangle that each pixel of a view sees in a frame, on the CPU, without shading. Alpha masks have holes;
    /// nothing is traced behind blended and transmissive surfaces.
    ///
    /// ```
    /// use umbrage::scene::Frame;
    /// use umbrage::{Renderer, Seen, Settings};
    ///
    /// let frame = umbrage::open("demo:shatter?triangles=500")?.at(0.5)?;
    /// let view = Settings { width: 64, height: 36, ..Settings::default() }.view(&frame)?;
    /// let mut renderer = Renderer::default();
    /// let seen = renderer.see(&frame, &view)?;
    /// let masks = renderer.shadow(&seen, &frame.lights)?;
    /// let pixels = (0..36).flat_map(|y| (0..64).map(move |x| (x, y)));
    /// let lit = pixels.filter(|&(x, y)| masks[0].is_lit(x, y)).count();
    /// let hit = seen.triangle.iter().filter(|&&triangle| triangle != Seen::NO_TRIANGLE).count();
    /// assert!(0 < lit && lit < hit);
    /// # Ok::<(), umbrage::Error>(())
    /// ```
    ///
    /// # Errors
    /// Where [`Frame::check`] rejects the frame, the image has no pixels or too many, or a GPU renders.
    pub fn see<'a>(&mut self, frame: &'a Frame, view: &View) -> Result<Seen<'a>, Error> {
        let cpu = self.answering.as_mut().ok_or(Error::AnswersOnGpu)?;
        Settings { width: view.width, height: view.height, camera: view.camera.into(), ..Settings::default() }
            .check()?;
        frame.check()?;
        Ok(Seen::new(frame, *view, cpu.seen_alone(frame, view)?))
    }

    /// Finds the seen points that each light reaches: a mask for each light, in which misses are dark.
    ///
    /// A spot lights no point outside of its cone. Ranges of lights are ignored, and lights that cast no shadow reach
    /// all points in their cones.
    ///
    /// # Errors
    /// Where [`Frame::check`] would reject a light, or a GPU renders.
    pub fn shadow(&mut self, seen: &Seen<'_>, lights: &[Light]) -> Result<Vec<LightMask>, Error> {
        let cpu = self.answering.as_mut().ok_or(Error::AnswersOnGpu)?;
        seen.frame.check_lit_by(lights)?;
        cpu.lit_alone(seen.frame, lights, &seen.view, &seen.pixels)
    }

    /// Counts, pixel by pixel, the work of seeing a frame through the middle of each pixel. With the index `light`, among
    /// the settings' lights or else the frame's, it also finds the cell of that light's grid for each visible point. Only
    /// [specialised](crate::Structure::is_specialised) structures have such work.
    ///
    /// [`Renderer::frame`] is the frame of a scene that was just rendered.
    ///
    /// # Errors
    /// As [`Renderer::render_frame`], and where there is no such light, the structure isn't specialised, or a GPU renders.
    pub fn count_work(
        &mut self,
        frame: &Frame,
        settings: &Settings,
        light: Option<usize>,
        counts: &mut WorkCounts,
    ) -> Result<(), Error> {
        let cpu = self.answering.as_mut().ok_or(Error::CountsOnGpu)?;
        settings.check()?;
        if !settings.structure.is_specialised() {
            return Err(Error::CountsOfStructure);
        }
        let lights = settings.lights(frame);
        frame.check_lit_by(lights)?;
        let view = settings.view(frame)?;
        Film::check_memory_without([view.width, view.height])?;
        let no_such = |light| Error::NoSuchLight { light, lights: lights.len() };
        let light = light.map(|light| lights.get(light).ok_or_else(|| no_such(light))).transpose()?;
        cpu.count_alone(frame, &view, settings, light.map(|light| &light.source), counts)
    }
}
