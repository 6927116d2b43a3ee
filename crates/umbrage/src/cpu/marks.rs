//! Points and lines: disks and ribbons of some pixels, before and behind triangles.
//!
//! A pixel's sample shows a point that projects to within half of its size from it, and a line likewise. Of several, the
//! nearest counts, and of equally near ones the first. They are as thick as they are wide, so that those on a surface
//! aren't hidden by it.

use std::array;

use glam::{DVec2, DVec3, UVec2, Vec2, Vec3};
use rayon::prelude::*;
use umbrage_rays::{Hit, Projection, TileOrder, View};
use umbrage_scene::{Frame, MarkRun};

use super::hit_of;
use super::onward::{Onward, Queue};
use super::strip::{Flat, Shaded, Strip};
use crate::engine::Staged;
use crate::motion::{along_axes, in_image};
use crate::sampling::{Sample, Samples};
use crate::shade::Block;
use crate::shade::lanes::{Each, LANES, at_most_brightest, lanes_of, put};

/// A projected vertex of a point or a line.
#[derive(Clone, Copy, Debug)]
struct End {
    /// In pixels from the image's upper left corner.
    position: Vec2,
    /// Linear along a line in the image: 1/t for a perspective camera, t for a parallel one.
    depth: f32,
    color: Vec3,
}

/// The points and lines of a frame that may be seen, for the samples that are traced together.
#[derive(Debug)]
pub(super) struct Marks {
    points: Vec<End>,
    lines: Vec<[End; 2]>,
    /// Half of the size of points, and of the width of lines, in pixels.
    radii: [f32; 2],
    is_perspective: bool,
    /// A pixel's width, in world units; before a perspective camera, at t = 1.
    pixel: f64,
    /// The first of `in_order` that begins in each strip of rows, and the end of the last one's.
    first_of_strip: Vec<u32>,
    /// Indices of marks, points before lines, by the strip that they begin in: marks that end within
    /// [`REACH`](Self::REACH).
    in_order: Vec<u32>,
    /// Indices of all other marks.
    long: Vec<u32>,
}

/// Marks nearest the camera at one sample of each pixel of a strip.
#[derive(Debug, Default)]
pub(super) struct MarkStrip {
    nearest: Vec<Option<Drawn>>,
    is_empty: bool,
}

/// A point or line at a sample.
#[derive(Clone, Copy, Debug)]
struct Drawn {
    t: f32,
    number: u32,
    color: Vec3,
}

impl Marks {
    /// Maximum number of strips after its first one that a mark in `in_order` may reach into.
    const REACH: u32 = 2;
    /// Near plane of a line, relative to its largest depth.
    const NEAR: f64 = 1e-6;

    /// Projects a frame's points and lines; `None` where it has none.
    pub(super) fn new(staged: &Staged<'_>) -> Option<Self> {
        let Staged { frame, ref view, settings, ref samples, .. } = *staged;
        if frame.mesh.marks.is_empty() {
            return None;
        }
        let radii = [settings.point_size, settings.line_width].map(|size| 0.5 * size);
        let projector = Projector { frame, view, margins: radii.map(|radius| f64::from(radius) + 2.0) };
        let (mut points, mut lines) = (Vec::new(), Vec::new());
        for run in frame.mesh.marks.runs() {
            let color = frame.materials.materials[run.material as usize].base_color.truncate();
            let MarkRun { points: of_run, lines: lines_of_run, .. } = run;
            points.par_extend(of_run.par_iter().filter_map(|&vertex| projector.point(vertex, color)));
            lines.par_extend(lines_of_run.par_iter().filter_map(|&line| projector.line(line, color)));
        }
        let half_height = match view.camera.projection {
            Projection::Perspective { tan_half_height } => tan_half_height,
            Projection::Orthographic { half_height } => half_height,
        };
        let mut marks = Self {
            points,
            lines,
            radii,
            is_perspective: matches!(view.camera.projection, Projection::Perspective { .. }),
            pixel: 2.0 * f64::from(half_height) / f64::from(view.height),
            first_of_strip: Vec::new(),
            in_order: Vec::new(),
            long: Vec::new(),
        };
        marks.sort(view.height.div_ceil(TileOrder::BLOCK), samples);
        Some(marks)
    }

    fn len(&self) -> u32 {
        (self.points.len() + self.lines.len()) as u32
    }

    /// Both ends of a mark, and its half width in pixels.
    fn mark(&self, number: u32) -> ([End; 2], f32) {
        match self.points.get(number as usize) {
            Some(&point) => ([point; 2], self.radii[0]),
            None => (self.lines[number as usize - self.points.len()], self.radii[1]),
        }
    }

    /// Puts marks in the order of the strips that they begin in.
    fn sort(&mut self, strips: u32, samples: &Samples) {
        let offsets = samples.as_slice().iter().map(|sample| sample.offset_pixels.y as f32);
        let (least, most) = offsets.fold((f32::MAX, f32::MIN), |(least, most), y| (least.min(y), most.max(y)));
        let rows = TileOrder::BLOCK as f32;
        let strips_of = |number: u32| {
            let ([a, b], radius) = self.mark(number);
            let (top, bottom) = (a.position.y.min(b.position.y), a.position.y.max(b.position.y));
            let strip = |y: f32| ((y / rows) as u32).min(strips - 1);
            // Casts to whole numbers give 0 for negative ones, above the image.
            (strip(top - radius - most), strip(bottom + radius - least))
        };
        let spans: Vec<(u32, u32)> = (0..self.len()).into_par_iter().map(strips_of).collect();
        let is_long = |&(first, last): &(u32, u32)| last - first > Self::REACH;
        let mut ends = vec![0_u32; strips as usize + 1];
        for (first, _) in spans.iter().filter(|span| !is_long(span)) {
            ends[*first as usize + 1] += 1;
        }
        for strip in 1..ends.len() {
            ends[strip] += ends[strip - 1];
        }
        let mut next = ends.clone();
        let mut in_order = vec![0; ends.last().copied().unwrap_or(0) as usize];
        for (number, span) in (0..).zip(&spans) {
            if is_long(span) {
                self.long.push(number);
            } else {
                let slot = &mut next[span.0 as usize];
                in_order[*slot as usize] = number;
                *slot += 1;
            }
        }
        (self.first_of_strip, self.in_order) = (ends, in_order);
    }

    /// The t of an [`End::depth`].
    fn t(&self, depth: f32) -> f32 {
        if self.is_perspective { 1.0 / depth } else { depth }
    }

    /// Whether a mark is before the nearest hit of its ray, if there is one.
    fn covers(&self, drawn: &Drawn, hit: Option<&Hit>) -> bool {
        let radius = self.radii[usize::from(drawn.number as usize >= self.points.len())];
        let t = f64::from(drawn.t);
        let thickness = f64::from(radius) * self.pixel * if self.is_perspective { t } else { 1.0 };
        hit.is_none_or(|hit| t - thickness <= hit.t)
    }
}

/// Projects a frame's vertices to an image.
struct Projector<'a> {
    frame: &'a Frame,
    view: &'a View,
    /// Margins around the image, in pixels, within which points, and lines, are seen.
    margins: [f64; 2],
}

/// A vertex before the camera.
#[derive(Clone, Copy)]
struct Vertex {
    /// Along the camera's axes; z is t.
    position: DVec3,
    color: Vec3,
}

impl Vertex {
    fn lerp(self, other: Self, part: f64) -> Self {
        let position = self.position.lerp(other.position, part);
        Self { position, color: self.color.lerp(other.color, part as f32) }
    }
}

impl Projector<'_> {
    fn point(&self, vertex: u32, color: Vec3) -> Option<End> {
        let end = self.end(self.vertex(vertex, color)?)?;
        let Range { min, max } = self.range(self.margins[0]);
        let position = end.position.as_dvec2();
        (position.cmpge(min) & position.cmple(max)).all().then_some(end)
    }

    /// The part of a line that is before the camera and in the image, or near it.
    fn line(&self, line: [u32; 2], color: Vec3) -> Option<[End; 2]> {
        let [a, b] = line.map(|vertex| self.vertex(vertex, color));
        let (mut a, mut b) = (a?, b?);
        let least = Marks::NEAR * a.position.z.max(b.position.z);
        if least <= 0.0 {
            return None;
        }
        let cut = |from: Vertex, to: Vertex| {
            let (z, to_z) = (from.position.z, to.position.z);
            if z < least { from.lerp(to, (least - z) / (to_z - z)) } else { from }
        };
        (a, b) = (cut(a, b), cut(b, a));
        let [from, to] = [a, b].map(|vertex| in_image(self.view, vertex.position));
        let [first, last] = self.range(self.margins[1]).clip(from, to - from)?;
        let z = [a.position.z, b.position.z];
        // Parameters along the line differ between the image and space.
        let part = |part: f64| match self.view.camera.projection {
            Projection::Perspective { .. } => part * z[0] / (z[1] + part * (z[0] - z[1])),
            Projection::Orthographic { .. } => part,
        };
        let end = |at: f64| {
            if at == 0.0 {
                a
            } else if at == 1.0 {
                b
            } else {
                a.lerp(b, part(at))
            }
        };
        Some([self.end(end(first))?, self.end(end(last))?])
    }

    /// The image with a margin around it, in pixels.
    fn range(&self, margin: f64) -> Range {
        let size = DVec2::new(self.view.width.into(), self.view.height.into());
        Range { min: DVec2::splat(-margin), max: size + margin }
    }

    fn vertex(&self, vertex: u32, material_color: Vec3) -> Option<Vertex> {
        let position = along_axes(self.view, self.frame.positions[vertex as usize].as_dvec3());
        let own = self.frame.mesh.colors.get(vertex as usize).map_or(Vec3::ONE, |color| color.truncate());
        // Overflow is as bright as films can be.
        let color = (material_color * own).map(|part| at_most_brightest(part).max(0.0));
        position.is_finite().then_some(Vertex { position, color })
    }

    fn end(&self, Vertex { position, color }: Vertex) -> Option<End> {
        let depth = match self.view.camera.projection {
            Projection::Perspective { .. } => 1.0 / position.z,
            Projection::Orthographic { .. } => position.z,
        } as f32;
        let at = in_image(self.view, position).as_vec2();
        (position.z > 0.0 && depth.is_finite() && depth > 0.0 && at.is_finite()).then_some(End {
            position: at,
            depth,
            color,
        })
    }
}

/// A box in the image.
struct Range {
    min: DVec2,
    max: DVec2,
}

impl Range {
    /// Parameters, 0 to 1, at which a segment enters and leaves the box; `None` if it misses.
    fn clip(&self, from: DVec2, along: DVec2) -> Option<[f64; 2]> {
        let (mut first, mut last) = (0.0_f64, 1.0_f64);
        for axis in 0..2 {
            let [low, high] = [self.min[axis] - from[axis], self.max[axis] - from[axis]];
            if along[axis] == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let [one, other] = [low / along[axis], high / along[axis]];
            (first, last) = (first.max(one.min(other)), last.min(one.max(other)));
        }
        (first <= last).then_some([first, last])
    }
}

impl MarkStrip {
    /// Finds the mark that one sample of each pixel of a strip, given by its first row, shows.
    pub(super) fn draw(&mut self, marks: &Marks, view: &View, sample: &Sample, first_row: u32) {
        let Self { nearest, is_empty } = self;
        nearest.clear();
        nearest.resize((view.width * TileOrder::BLOCK) as usize, None);
        *is_empty = true;
        let strip = first_row / TileOrder::BLOCK;
        let rows = first_row..(first_row + TileOrder::BLOCK).min(view.height);
        let begun = marks.first_of_strip[strip.saturating_sub(Marks::REACH) as usize] as usize;
        let end = marks.first_of_strip[strip as usize + 1] as usize;
        let offset = sample.offset_pixels.as_vec2();
        for &number in marks.in_order[begun..end].iter().chain(&marks.long) {
            let ([a, b], radius) = marks.mark(number);
            let along = b.position - a.position;
            let squared = along.length_squared();
            for row in rows.clone() {
                let y = row as f32 + offset.y;
                let Some([first, last]) = reach_in_row(&a, along, radius, y) else { continue };
                // Casts to whole numbers give 0 for negative ones, left of the image.
                let columns = (first - offset.x).ceil() as u32..((last - offset.x).floor() + 1.0) as u32;
                for column in columns.start..columns.end.min(view.width) {
                    let from_a = Vec2::new(column as f32 + offset.x, y) - a.position;
                    let part = if squared > 0.0 { (from_a.dot(along) / squared).clamp(0.0, 1.0) } else { 0.0 };
                    if (from_a - along * part).length_squared() > radius * radius {
                        continue;
                    }
                    let depth = a.depth + (b.depth - a.depth) * part;
                    let t = marks.t(depth);
                    let slot = &mut nearest[((row - first_row) * view.width + column) as usize];
                    if slot.is_none_or(|other| (t, number) < (other.t, other.number)) {
                        // Colours are linear in space, not in a perspective image.
                        let part = if marks.is_perspective { part * b.depth / depth } else { part };
                        *slot = Some(Drawn { t, number, color: a.color.lerp(b.color, part) });
                        *is_empty = false;
                    }
                }
            }
        }
    }

    /// Puts marks in place of the surfaces behind them, in a block whose rays have `seen` triangles.
    pub(super) fn cover(
        &self,
        marks: &Marks,
        frame: &Frame,
        block: &Block<'_>,
        seen: &Each<u32>,
        shaded: &mut Shaded,
    ) -> Covered {
        let mut covered = Covered { corner: block.corner, width: block.view.width, lanes: 0 };
        if self.is_empty {
            return covered;
        }
        for lane in lanes_of(block.pixels()) {
            let Some(drawn) = self.nearest[covered.index(lane)] else { continue };
            if !marks.covers(&drawn, hit_of(frame, &block.ray(lane), seen[lane]).as_ref()) {
                continue;
            }
            covered.lanes |= 1 << lane;
            put(lane, drawn.color, &mut shaded.color);
            shaded.coverage[lane] = 1.0;
            let flat = shaded.flat.get_or_insert(Flat { color: [[0.0; LANES]; 3], part: [0.0; LANES] });
            put(lane, drawn.color, &mut flat.color);
            flat.part[lane] = 1.0;
        }
        covered
    }

    /// Ends rays that go straight on, behind a surface, where they come to a mark, and adds its colour to the film.
    pub(super) fn stop(
        &self,
        marks: &Marks,
        onward: &mut Vec<Onward>,
        found: &mut Vec<Option<Hit>>,
        film: &mut Strip<'_>,
    ) {
        if self.is_empty {
            return;
        }
        let mut goes_on = onward.iter().zip(&*found).map(|(onward, found)| {
            let path = &onward.path;
            let drawn = self.nearest[path.pixel as usize].filter(|_| path.bounces == 0);
            let Some(drawn) = drawn.filter(|drawn| marks.covers(drawn, found.as_ref())) else { return true };
            let part = path.through.element_sum() / 3.0;
            let color = (drawn.color * path.through).map(at_most_brightest);
            film.add(path.pixel, color, part);
            film.add_flat(path.pixel, color.extend(part));
            false
        });
        let goes_on: Vec<bool> = goes_on.by_ref().collect();
        let mut flags = goes_on.iter();
        onward.retain(|_| flags.next() == Some(&true));
        let mut flags = goes_on.iter();
        found.retain(|_| flags.next() == Some(&true));
    }
}

/// Conservative range of x, in pixels, of the points within `radius` of the segment from `a` along `along`, in the row
/// at `y`.
fn reach_in_row(a: &End, along: Vec2, radius: f32, y: f32) -> Option<[f32; 2]> {
    let above = y - a.position.y;
    let (mut first, mut last) = (0.0, 1.0);
    if along.y == 0.0 {
        if above.abs() > radius {
            return None;
        }
    } else {
        let [one, other] = [(above - radius) / along.y, (above + radius) / along.y];
        (first, last) = (one.min(other).max(0.0), one.max(other).min(1.0));
        if first > last {
            return None;
        }
    }
    let [one, other] = [first, last].map(|part| a.position.x + along.x * part);
    Some([one.min(other) - radius, one.max(other) + radius])
}

/// The pixels of a block that show marks.
pub(super) struct Covered {
    corner: UVec2,
    width: u32,
    lanes: u16,
}

impl Covered {
    /// The index of a lane's pixel in its strip.
    fn index(&self, lane: usize) -> usize {
        let lane = lane as u32;
        (lane / TileOrder::BLOCK * self.width + self.corner.x + lane % TileOrder::BLOCK) as usize
    }

    /// Removes rays and shadows of these pixels from a queue, after the first `before` of each.
    pub(super) fn take_from(&self, queue: &mut Queue, before: [usize; 2]) {
        if self.lanes == 0 {
            return;
        }
        let pixels: Each<usize> = array::from_fn(|lane| self.index(lane));
        let waits = |pixel: u32| !lanes_of(self.lanes).any(|lane| pixels[lane] == pixel as usize);
        retain_from(&mut queue.next, before[0], |onward| waits(onward.path.pixel));
        retain_from(&mut queue.shadows, before[1], |shadow| waits(shadow.pixel));
    }
}

/// As [`Vec::retain`], from an index on.
fn retain_from<T>(list: &mut Vec<T>, first: usize, keeps: impl Fn(&T) -> bool) {
    let mut end = first;
    for index in first..list.len() {
        if keeps(&list[index]) {
            list.swap(end, index);
            end += 1;
        }
    }
    list.truncate(end);
}
