//! A light's grid, rebuilt for every frame and light: `survey` for all lights, then for each one `cone`, `choose`,
//! `map`, `spread`, `sort`, `project`, `count`, `scan`, `scatter`, `balance`, `trace`, `settle`. Lights that see by
//! angles replace some of these ([`Sphere`]).

mod parameters;
mod points;
mod shadows;
mod sphere;

use glam::DVec2;
use umbrage_rays::{Cone, LightSource};

use crate::fit::{NEEDS_PAIRS, NEEDS_UNDECIDED, NEEDS_WORDS, Needs, Room};
use crate::grid::header::{HEADER_TRIANGLE_GROUPS, HEADER_VERTEX_GROUPS, HEADER_WORDS};
use crate::grid::{List, ListBuffers, Project, Space};
use crate::view::PointView;
use crate::{Band, Buffer, Done, Fetch, Geometry, Gpu, GpuError, Groups, Recorder};
use parameters::LightParameters;
use points::Points;
use shadows::{Shadows, UNDECIDED_FIRST};
use sphere::Sphere;

/// Options of the lights' grids: they change the work, not the result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightOptions {
    /// Whether lights see by two angles around them, instead of through faces; directional lights always have a face.
    pub is_spherical: bool,
    /// The angles that get cells of their own, for lights that see by angles: the lowest and highest α, and β, in degrees
    /// from −180 to 180. By default the range of the points' angles.
    pub clamp: Option<[f32; 4]>,
    /// Depth slices of a tile, 1 or more: points are tested against triangles in their slice and in those before it.
    pub slices: u32,
}

impl Default for LightOptions {
    fn default() -> Self {
        Self { is_spherical: false, clamp: None, slices: 1 }
    }
}

/// Counts of a light's work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LightWork {
    /// Faces of its grid: 1 or 6, or 0 if no point is seen.
    pub faces: u32,
    /// Pairs of a triangle and a cell.
    pub pairs: u32,
    /// Chunks of triangles over many cells.
    pub large: u32,
    /// Blocks of points and triangles.
    pub blocks: u32,
    /// Pairs of a point and a triangle that the predicate had to decide.
    pub undecided: u32,
}

/// Masks of the pixels' points that each light reaches, found through grids made for its rays.
#[derive(Debug)]
pub struct LightGrid {
    options: LightOptions,
    /// Compiled at its first use.
    sphere: Option<Sphere>,
    points: Points,
    project: Project,
    list: List,
    shadows: Shadows,
    point_view: Buffer,
    /// A buffer for each light: all are in use in one submission.
    parameters: Vec<Buffer>,
    /// For each light whether triangles shadow it.
    casts_shadow: Vec<bool>,
    /// For each light whether it has a cone.
    have_cones: Vec<bool>,
    /// For each light whether it sees by angles.
    have_angles: Vec<bool>,
    spaces: Buffer,
    header: Buffer,
    sizes: Buffer,
    /// Counts, then ends, of the cells' lists of triangles.
    cells: Buffer,
    /// For each light one bit for each slot.
    lit: Buffer,
    /// Needs of each light: its header, and the numbers of pairs and of undecided pairs.
    needs: Buffer,
    fetch: Fetch,
    tile_count: u32,
    cell_count: u32,
    mask_words: u32,
    work: Vec<LightWork>,
}

/// Pixels for each tile of a light: points are spread unevenly, so some tiles have many more.
const PIXELS_PER_TILE: f64 = 24.0;
/// Maximum number of tiles on a side of a face with one slice; the square root of its number of cells.
const MOST_CELLS: f64 = 1024.0;

impl LightGrid {
    /// Compiles the stages; those for angles at their first use.
    #[must_use]
    pub fn new(gpu: &Gpu) -> Self {
        let ((shadows, points), (project, list)) = rayon::join(
            || rayon::join(|| Shadows::new(gpu), || Points::new(gpu)),
            || rayon::join(|| Project::new(gpu), || List::new(gpu, true)),
        );
        Self {
            options: LightOptions::default(),
            sphere: None,
            points,
            project,
            list,
            shadows,
            point_view: Buffer::uniform(gpu, "view of points"),
            parameters: Vec::new(),
            casts_shadow: Vec::new(),
            have_cones: Vec::new(),
            have_angles: Vec::new(),
            spaces: Buffer::storage(gpu, "light spaces"),
            header: Buffer::storage(gpu, "light header"),
            sizes: Buffer::sizes(gpu, "light dispatch sizes"),
            cells: Buffer::storage(gpu, "light cells"),
            lit: Buffer::storage(gpu, "lit"),
            needs: Buffer::storage(gpu, "light needs"),
            fetch: Fetch::default(),
            tile_count: 0,
            cell_count: 0,
            mask_words: 0,
            work: Vec::new(),
        }
    }

    /// Sets the options for the next frames.
    pub fn set_options(&mut self, gpu: &Gpu, options: LightOptions) {
        self.options = options;
        if options.is_spherical && self.sphere.is_none() {
            self.sphere = Some(Sphere::new(gpu));
        }
    }

    /// Prepares a frame of some or all rows of an image: parameters and room. `None` stands for a light without shadows.
    ///
    /// # Errors
    /// If a stage needs more bytes than one buffer of the device can have.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        geometry: &Geometry,
        band: impl Into<Band>,
        offset_pixels: DVec2,
        lights: &[Option<LightSource>],
    ) -> Result<(), GpuError> {
        let band = band.into();
        let slots = band.order().slots() as u32;
        let pixels = f64::from(band.size()[0]) * f64::from(band.size()[1]);
        let most = (MOST_CELLS / f64::from(self.options.slices).sqrt()).max(4.0);
        let side_of_one = (pixels / PIXELS_PER_TILE).sqrt().clamp(4.0, most) as u32;
        let side_of_six = side_of_one.div_ceil(2);
        self.tile_count = (side_of_one * side_of_one).max(6 * side_of_six * side_of_six);
        self.cell_count = self.tile_count * self.options.slices;
        self.mask_words = slots / 32;
        self.point_view.write(gpu, &[PointView::new(&band, offset_pixels)])?;
        self.parameters.truncate(lights.len());
        while self.parameters.len() < lights.len() {
            self.parameters.push(Buffer::uniform(gpu, "light"));
        }
        self.casts_shadow.clear();
        self.casts_shadow.extend(lights.iter().map(Option::is_some));
        self.have_cones.clear();
        self.have_cones.extend(lights.iter().map(|light| light.as_ref().and_then(Cone::of).is_some()));
        let is_spherical = self.options.is_spherical;
        let has_angles = |light: &LightSource| is_spherical && !matches!(light, LightSource::Directional { .. });
        self.have_angles.clear();
        self.have_angles.extend(lights.iter().map(|light| light.as_ref().is_some_and(has_angles)));
        for ((buffer, light), number) in self.parameters.iter_mut().zip(lights).zip(0..) {
            let Some(light) = light else { continue };
            let sides = [side_of_one, side_of_six];
            let mask = number * self.mask_words;
            let parameters = LightParameters::new(light, sides, geometry, mask, slots, &band.view, self.options);
            buffer.write(gpu, &[parameters])?;
        }
        self.spaces.reserve(gpu, 6 * Space::BYTES)?;
        self.header.reserve(gpu, 4 * HEADER_WORDS)?;
        self.sizes.reserve(gpu, 4 * HEADER_WORDS)?;
        self.cells.reserve(gpu, 4 * u64::from(self.cell_count))?;
        self.lit.reserve(gpu, (4 * u64::from(self.mask_words) * lights.len() as u64).max(16))?;
        self.needs.reserve(gpu, (4 * NEEDS_WORDS * lights.len() as u64).max(16))?;
        self.points.prepare(gpu, slots, self.cell_count)?;
        let records = if self.have_angles.contains(&true) { Sphere::VERTEX_RECORDS } else { 1 };
        self.project.prepare(gpu, geometry.vertex_count(), records)?;
        self.list.prepare(gpu, geometry.triangle_count(), geometry.vertex_count(), self.cell_count)?;
        self.shadows.prepare(gpu, slots, self.cell_count)
    }

    /// Records all stages of all lights.
    pub fn record(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, geometry: &Geometry, seen: &Buffer) {
        self.fetch = Fetch::default();
        if self.parameters.is_empty() {
            return;
        }
        self.points.record_survey(gpu, recorder, &self.point_view, geometry, seen);
        let mask_words = u64::from(self.mask_words);
        let kinds = self.casts_shadow.iter().zip(&self.have_cones);
        for ((light, (casts_shadow, has_cone)), number) in self.parameters.iter().zip(kinds).zip(0..) {
            // Points are lit until a stage finds them shadowed.
            recorder.copy_range((self.points.bits(), 0), (&self.lit, number * mask_words), mask_words);
            if *has_cone {
                let lit = (&self.lit, self.mask_words * 32);
                self.shadows.record_cone(gpu, recorder, [light, &self.point_view], geometry, seen, lit);
            }
            if *casts_shadow {
                self.record_light(gpu, recorder, geometry, seen, light, number);
            } else {
                recorder.clear_range(&self.needs, number * NEEDS_WORDS, NEEDS_WORDS);
            }
        }
        self.fetch = recorder.fetch(&self.needs, NEEDS_WORDS * self.parameters.len() as u64);
    }

    fn record_light(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        geometry: &Geometry,
        seen: &Buffer,
        light: &Buffer,
        number: u64,
    ) {
        let Self { points, project, list, shadows, spaces, header, sizes, cells, lit, needs, .. } = self;
        let sphere = self.sphere.as_ref().filter(|_| self.have_angles[number as usize]);
        recorder.clear(header);
        recorder.clear_words(cells, u64::from(self.cell_count));
        shadows.record_clear(recorder);
        points.record_choose(gpu, recorder, light, spaces, header, sphere);
        recorder.copy_words(header, sizes, HEADER_WORDS);
        points.record_sort(gpu, recorder, [light, spaces, header], [seen, lit, shadows.undecided()], sphere);

        recorder.stage("light project", |pass| {
            let groups = Groups::Indirect(sizes, HEADER_VERTEX_GROUPS);
            let kernel = sphere.map(|sphere| &sphere.project);
            project.record(gpu, pass, kernel, [spaces, geometry.positions(), header], groups);
        });
        let buffers = ListBuffers {
            spaces,
            triangles: geometry.triangles(),
            vertices: project.vertices(),
            cells,
            header,
            sizes,
            farthest_point: points.farthest(),
            spread: points.spread(),
        };
        list.record(
            gpu,
            recorder,
            sphere.map(|sphere| &sphere.list),
            buffers,
            Groups::Indirect(sizes, HEADER_TRIANGLE_GROUPS),
            ["light count", "light scan", "light scatter"],
        );
        recorder.stage("light balance", |pass| {
            shadows.record_balance(gpu, pass, [light, cells, points.cells(), header, points.spread()], self.tile_count);
        });
        recorder.copy_words(header, sizes, HEADER_WORDS);
        recorder.stage("light trace", |pass| {
            let read = [light, spaces, geometry.triangles(), project.vertices(), points.sorted(), list.pairs()];
            shadows.record_trace(gpu, pass, read, [lit, geometry.masks().buffer(), sizes], sphere);
        });
        shadows.record_settle(gpu, recorder, [light, &self.point_view], geometry, seen, lit);

        let first = number * NEEDS_WORDS;
        recorder.copy_range((header, 0), (needs, first), HEADER_WORDS);
        let (pair_counts, word) = list.pair_counts();
        recorder.copy_range((pair_counts, u64::from(word)), (needs, first + NEEDS_PAIRS), 1);
        recorder.copy_range((shadows.undecided(), 0), (needs, first + NEEDS_UNDECIDED), 1);
    }

    /// Reads the needs of a frame that is done. If they exceed the room there was, makes more and returns `false`: the
    /// frame has to be rendered again.
    ///
    /// # Errors
    /// If the device is lost, or a buffer would need more bytes than the device allows.
    pub fn finish(&mut self, gpu: &Gpu, done: &Done) -> Result<bool, GpuError> {
        self.work.clear();
        let mut fits = true;
        let room = self.room();
        let words = done.read::<u32>(self.fetch)?;
        for needs in words.chunks_exact(NEEDS_WORDS as usize).map(Needs::from_words) {
            let Needs { large, pairs, blocks, faces, undecided, .. } = needs;
            self.work.push(LightWork { faces, pairs, large, blocks, undecided });
            if !room.holds(&needs) {
                fits = false;
                self.project.grow(gpu, faces)?;
                self.list.grow(gpu, large, pairs)?;
                self.shadows.grow(gpu, blocks, undecided)?;
            }
        }
        Ok(fits)
    }

    /// Needs of each light, on the GPU.
    pub(crate) fn needs(&self) -> &Buffer {
        &self.needs
    }

    /// Number of lights of the last prepared frame.
    #[must_use]
    pub fn light_count(&self) -> u32 {
        self.parameters.len() as u32
    }

    /// Capacities of the buffers, the same for each light.
    pub(crate) fn room(&self) -> Room {
        let at_most = |room: u64| room.min(u64::from(u32::MAX)) as u32;
        let (blocks, undecided_words) = self.shadows.room();
        Room {
            large: at_most(self.list.large_room()),
            pairs: at_most(self.list.pair_room()),
            blocks: at_most(blocks),
            faces: self.project.face_room(),
            undecided_words: at_most(undecided_words),
            words_per_undecided: 2,
            words_per_pixel: 0,
            undecided_header: UNDECIDED_FIRST as u32,
        }
    }

    /// Work of each light of the last finished frame.
    #[must_use]
    pub fn work(&self) -> &[LightWork] {
        &self.work
    }

    /// For each light one bit for each slot, in [`TileOrder`](umbrage_rays::TileOrder), 32 in a word from the lowest
    /// bit up: set if no triangle is between the light and the pixel's point.
    #[must_use]
    pub fn lit(&self) -> &Buffer {
        &self.lit
    }

    /// Words of each light in [`LightGrid::lit`].
    #[must_use]
    pub fn mask_words(&self) -> u32 {
        self.mask_words
    }

    /// Bytes on the GPU for triangles.
    #[must_use]
    pub fn structure_bytes(&self) -> u64 {
        self.project.vertices().bytes() + self.list.bytes() + self.cells.bytes() + self.shadows.block_bytes()
    }

    /// Bytes on the GPU for the pixels' points.
    #[must_use]
    pub fn point_bytes(&self) -> u64 {
        self.points.bytes() + self.shadows.undecided().bytes() + self.lit.bytes()
    }
}
