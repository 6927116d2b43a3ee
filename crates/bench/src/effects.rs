//! Lenses and large lights by two methods with the same limit: exact frames, each with one point of the lens and of the
//! light, and rays with points of their own in each pixel, as in most ray tracers (Pharr, Jakob and Humphreys,
//! *Physically Based Rendering*). Compares their errors after the same time.

use std::f64::consts::TAU;
use std::time::Instant;

use anyhow::{Context, Result};
use clap::Args;
use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;
use umbrage::internals::{disk, pair, triple};
use umbrage::rays::predicate::{HitPoint, ShadowRay};
use umbrage::rays::{
    Bvh, Camera, DirectGrids, LightMask, LightSource, Projection, SeenPixels, SingleRays as _, Structure as _,
    Triangles, View,
};
use umbrage::scene::Frame;
use umbrage::{Sample, Samples};

use crate::flags::{size, use_threads};
use crate::measure::median;
use crate::shot::{Lights, Shot, name};
use crate::table::{Cell, Form, Table, row};

#[derive(Debug, Args)]
pub(crate) struct EffectsFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth"])]
    scenes: Vec<String>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = size)]
    size: [u32; 2],
    /// Samples of each pixel
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [1, 4, 16, 64])]
    samples: Vec<u32>,
    /// Frames of the reference, with other points
    #[arg(long, value_name = "N", default_value = "2048")]
    reference: u32,
    /// Radius of the light, and diameter of the lens, in parts of the scene's diagonal
    #[arg(long, value_name = "PART", default_value = "0.05")]
    part: f64,
    /// How often each picture is made; times are medians
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Threads to work with [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// How the results are written
    #[arg(long, value_enum, default_value = "table")]
    form: Form,
}

pub(crate) fn run(flags: &EffectsFlags) -> Result<()> {
    use_threads(flags.threads)?;
    let [width, height] = flags.size;
    let threads = rayon::current_num_threads();
    let mut table = Table::start(flags.form, &format!("{width}x{height}, threads {threads}, times in milliseconds"))?;
    for address in &flags.scenes {
        let scene = umbrage::open(address).with_context(|| format!("scene {address}"))?;
        let mut frame = Frame::default();
        scene.pose(scene.duration_seconds() / 2.0, &mut frame)?;
        let shot = Shot::new(&frame, address, flags.size, 1, Lights::Count(1));
        for effect in [Effect::Lens, Effect::Light] {
            let setting = Setting::new(&shot, effect, flags.part);
            for row in rows(&setting, flags)? {
                let mut whole = row![("scene", name(address)), ("effect", effect.name())];
                whole.extend(row);
                table.push(whole)?;
            }
        }
    }
    table.finish(&[
        "frames: exact frames; pixels: each pixel with points of its own, one ray at a time through the hierarchy. Both with",
        "building. error: root of the mean squared difference from the reference, in percent of its mean. pixels_then: the",
        "error of pixels after the time of frames, between and beyond their measured ones on a line of logarithms.",
    ])?;
    Ok(())
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Effect {
    Lens,
    Light,
}

impl Effect {
    fn name(self) -> &'static str {
        match self {
            Self::Lens => "lens",
            Self::Light => "light",
        }
    }
}

/// Parameters of the pictures.
struct Setting<'a> {
    shot: &'a Shot<'a>,
    light: Vec3,
    lens_radius: f64,
    light_radius: f64,
    focus: f64,
}

/// Random points of a sample, besides its position in the pixel.
struct Drawn {
    /// A point in the unit disk.
    lens: DVec2,
    /// A point in the unit ball, in a distribution that looks like an even disk from all directions.
    light: DVec3,
}

impl Drawn {
    /// Dimensions of a sample; the last one is for the position in the pixel.
    const DIMENSIONS: u32 = 4;

    /// Sample `number` of one of many independent series.
    fn new(number: u32, series: u32) -> Self {
        let first = series.wrapping_mul(Self::DIMENSIONS);
        let point = triple(number, first + 1);
        let flat = disk(point.truncate());
        let light = DVec3::new(flat.x, (1.0 - point.x).sqrt() * (TAU * point.z).cos(), flat.y);
        Self { lens: disk(pair(number, first)), light }
    }
}

/// A picture of one channel.
type Picture = Vec<f32>;

impl<'a> Setting<'a> {
    fn new(shot: &'a Shot<'a>, effect: Effect, part: f64) -> Self {
        let (center, size) = (shot.bounds.center(), shot.bounds.size());
        let light = match shot.lights[0] {
            LightSource::Point { position } | LightSource::Spot { position, .. } => position,
            LightSource::Directional { direction } => center - direction.normalize() * size.length(),
        };
        let radius = part * f64::from(size.length());
        let of = |other: Effect, radius: f64| if effect == other { radius } else { 0.0 };
        let Camera { position, forward, .. } = shot.view.camera;
        let focus = f64::from((center - position).dot(forward)).max(radius);
        let (lens_radius, light_radius) = (of(Effect::Lens, 0.5 * radius), of(Effect::Light, radius));
        Self { shot, light, lens_radius, light_radius, focus }
    }

    fn triangles(&self) -> Triangles<'a> {
        self.shot.frame.triangles()
    }

    /// The camera at a point of its lens, and the shift of its rays in pixels that keeps points in focus in place.
    fn view(&self, drawn: &Drawn) -> (View, DVec2) {
        let View { camera, height, .. } = self.shot.view;
        let Projection::Perspective { tan_half_height } = camera.projection else {
            return (self.shot.view, DVec2::ZERO);
        };
        let off = drawn.lens * self.lens_radius;
        let (middle, right, up) = (camera.position.as_dvec3(), camera.right.as_dvec3(), camera.up.as_dvec3());
        let position = (middle + right * off.x + up * off.y).as_vec3();
        let moved = position.as_dvec3() - middle;
        let pixels_per_unit = f64::from(height) / (2.0 * f64::from(tan_half_height) * self.focus);
        let shift = DVec2::new(-moved.dot(right), moved.dot(up)) * pixels_per_unit;
        // Grids add these to pixels exactly.
        let shift = (shift * f64::from(1 << 20)).round() / f64::from(1 << 20);
        (View { camera: Camera { position, ..camera }, ..self.shot.view }, shift)
    }

    fn light(&self, drawn: &Drawn) -> LightSource {
        LightSource::Point { position: (self.light.as_dvec3() + drawn.light * self.light_radius).as_vec3() }
    }

    /// Radiance of a lit white surface; the light's intensity makes it about 1 around the scene's middle.
    fn shaded(&self, triangle: u32, point: DVec3, light: &LightSource) -> f32 {
        let LightSource::Point { position } = light else { return 0.0 };
        let [a, b, c] = self.triangles().corners(triangle).map(Vec3::as_dvec3);
        let towards = position.as_dvec3() - point;
        let squared = towards.length_squared();
        let cosine = (b - a).cross(c - a).normalize_or_zero().dot(towards).abs() / squared.sqrt();
        let usual = f64::from(self.light.distance_squared(self.shot.bounds.center()));
        (cosine * usual / squared) as f32
    }

    /// The mean of `count` exact frames with points of some series.
    fn by_frames(&self, count: u32, series: u32) -> Result<Picture> {
        let (mut grids, mut seen, mut masks) = (DirectGrids::default(), SeenPixels::default(), [LightMask::default()]);
        let width = self.shot.view.width as usize;
        let mut sums = vec![0.0_f32; width * self.shot.view.height as usize];
        let opacities = self.shot.opacities();
        grids.build_parts(self.triangles(), self.shot.frame.parts());
        for (number, sample) in (0..).zip(Sample::all(count)) {
            let drawn = Drawn::new(number, series);
            let ((view, shift), light) = (self.view(&drawn), self.light(&drawn));
            let sample = Sample { offset_pixels: sample.offset_pixels + shift, ..sample };
            let question = self.shot.question(&opacities, &Samples::one(sample));
            let question = umbrage::rays::Shot { view, ..question };
            grids.see(&question, &mut seen)?;
            grids.shadow(&question, &seen, &[light], &mut masks);
            sums.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
                for (x, sum) in row.iter_mut().enumerate() {
                    let (x, y) = (x as u32, y as u32);
                    let index = seen.order().index(x, y);
                    let triangle = seen.triangle[index];
                    if triangle != SeenPixels::NONE && masks[0].is_lit(x, y) {
                        let ray = sample.ray(&view, x, y);
                        let point = ray.origin + ray.direction / f64::from(seen.inverse_depth[index]);
                        *sum += self.shaded(triangle, point, &light);
                    }
                }
            });
        }
        sums.iter_mut().for_each(|sum| *sum /= count as f32);
        Ok(sums)
    }

    /// The mean of `count` rays of each pixel.
    fn by_pixels(&self, count: u32) -> Picture {
        let mut rays = Bvh::default();
        rays.build(self.triangles());
        let width = self.shot.view.width;
        let pixels = (0..width * self.shot.view.height).into_par_iter().with_min_len(64);
        pixels
            .map(|pixel| {
                let sum: f32 = (0..count).map(|number| self.along_ray(&rays, pixel, number)).sum();
                sum / count as f32
            })
            .collect()
    }

    /// Value of sample `number` of a pixel.
    fn along_ray(&self, rays: &Bvh, pixel: u32, number: u32) -> f32 {
        let drawn = Drawn::new(number, pixel);
        let in_pixel = pair(number, pixel.wrapping_mul(Drawn::DIMENSIONS) + Drawn::DIMENSIONS - 1);
        let ((view, shift), light) = (self.view(&drawn), self.light(&drawn));
        let width = self.shot.view.width;
        let sample = Sample { offset_pixels: in_pixel + shift, ..Sample::MIDDLE };
        let ray = sample.ray(&view, pixel % width, pixel / width);
        let Some(hit) = rays.nearest(self.triangles(), &ray, &|_| true) else { return 0.0 };
        let point = HitPoint::new(&ray, hit.t);
        let shadow = ShadowRay::new(&light, point);
        if rays.blocked(self.triangles(), &shadow, hit.triangle, &|_, _| true) {
            return 0.0;
        }
        self.shaded(hit.triangle, point.position, &light)
    }
}

/// Cost and error of pictures with one number of samples.
#[derive(Clone, Copy, Debug)]
struct Point {
    ms: f64,
    error: f64,
}

/// A row for each number of samples.
fn rows(setting: &Setting<'_>, flags: &EffectsFlags) -> Result<Vec<crate::table::Row>> {
    let reference = setting.by_frames(flags.reference, 1)?;
    let mut found = Vec::new();
    for &samples in &flags.samples {
        let mut times = [Vec::new(), Vec::new()];
        let mut errors = [0.0; 2];
        for _ in 0..flags.rounds {
            for (way, (times, error)) in times.iter_mut().zip(&mut errors).enumerate() {
                let start = Instant::now();
                let picture = if way == 0 { setting.by_frames(samples, 0)? } else { setting.by_pixels(samples) };
                times.push(1e3 * start.elapsed().as_secs_f64());
                *error = relative_error(&picture, &reference);
            }
        }
        let [frames, pixels] = times;
        found.push([(frames, errors[0]), (pixels, errors[1])].map(|(times, error)| Point { ms: median(times), error }));
    }
    let pixels: Vec<Point> = found.iter().map(|&[_, pixels]| pixels).collect();
    let rows = flags.samples.iter().zip(&found).map(|(&samples, &[of_frames, of_pixels])| {
        let then = error_after(&pixels, of_frames.ms);
        row![
            ("samples", samples),
            ("frames_ms", of_frames.ms),
            ("frames_error", of_frames.error),
            ("pixels_ms", of_pixels.ms),
            ("pixels_error", of_pixels.error),
            ("pixels_then", then),
            ("times", then.map_or(Cell::Nothing, |then| (then / of_frames.error).into())),
        ]
    });
    Ok(rows.collect())
}

/// Root of the mean squared difference, in percent of the reference's mean.
fn relative_error(picture: &Picture, reference: &Picture) -> f64 {
    let (squares, sum) = picture
        .iter()
        .zip(reference)
        .fold((0.0, 0.0), |(squares, sum), (&a, &b)| (squares + f64::from(a - b).powi(2), sum + f64::from(b)));
    let count = reference.len() as f64;
    100.0 * (squares / count).sqrt() / (sum / count)
}

/// The error after `ms` milliseconds, on the line of logarithms through two neighbours of the sorted `points`; `None`
/// before the first, or with fewer than two points.
fn error_after(points: &[Point], ms: f64) -> Option<f64> {
    let first = points.first()?;
    if points.len() < 2 || ms < first.ms {
        return None;
    }
    let second = points.iter().position(|point| point.ms >= ms).unwrap_or(points.len() - 1).max(1);
    let [from, to] = [points[second - 1], points[second]];
    let slope = (to.error / from.error).ln() / (to.ms / from.ms).ln();
    Some(from.error * (ms / from.ms).powf(slope))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways_have_one_limit() {
        let scene = umbrage::open("demo:gears?triangles=300").unwrap();
        let mut frame = Frame::default();
        scene.pose(0.0, &mut frame).unwrap();
        let shot = Shot::new(&frame, "demo:gears", [48, 40], 1, Lights::Count(1));
        for effect in [Effect::Lens, Effect::Light] {
            let setting = Setting::new(&shot, effect, 0.05);
            let reference = setting.by_frames(256, 1).unwrap();
            let errors = [setting.by_frames(256, 0).unwrap(), setting.by_pixels(256)];
            for error in errors.map(|picture| relative_error(&picture, &reference)) {
                assert!(error < 4.0, "{effect:?}: {error} %");
            }
        }
    }

    #[test]
    fn errors_lie_on_lines_of_logarithms() {
        let points = [(10.0, 8.0), (40.0, 4.0), (160.0, 2.0)].map(|(ms, error)| Point { ms, error });
        for (ms, error) in [(10.0, 8.0), (20.0, 8.0 / 2.0_f64.sqrt()), (160.0, 2.0), (640.0, 1.0)] {
            let found = error_after(&points, ms).unwrap();
            assert!((found - error).abs() < 1e-9, "{ms}: {found}");
        }
        assert_eq!(error_after(&points, 9.0), None);
        assert_eq!(error_after(&points[..1], 20.0), None);
    }
}
