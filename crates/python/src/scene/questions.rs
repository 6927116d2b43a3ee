//! Questions in pieces, between which a call checks for signals.

use glam::{DVec3, Vec3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;
use umbrage::rays::{Hit, LightSource, LitShare, Masks, RayMasks, Rays, Receivers};

use super::answers::{Answers, INVALID_ID};
use super::arguments::Pieces;
use super::facing::{self, Spots};
use super::keys::Keys;
use super::masks;
use super::rays::{self, Masked};
use super::state::State;
use crate::camera::PixelRays;
use crate::errors::exception;
use crate::threads::Call;

/// Rays of a piece.
const RAYS: usize = 1 << 20;

/// Lights of a piece: enough for each thread to have several.
const LIGHTS: usize = 64;

/// Rays, and their masks.
pub(super) type MaskedRays<'a> = (Rays<'a>, RayMasks<'a>);

/// The pieces of rays.
fn chunks<'a>((rays, masks): MaskedRays<'a>) -> impl Iterator<Item = MaskedRays<'a>> {
    let masks = (0..).map(move |number| masks::part(masks, number * RAYS, RAYS));
    rays.chunks(RAYS).zip(masks)
}

/// As `cast_rays`.
pub(super) fn cast(call: &Call, state: &mut State, rays: MaskedRays<'_>, keys: Keys) -> PyResult<Answers> {
    let (mut answers, mut answered) = (Answers::default(), Vec::new());
    for (chunk, masks) in chunks(rays) {
        let (traced, by) = call.piece(|| state.trace(chunk, masks, keys.wanted()))?;
        call.piece(|| answers.append(traced))?;
        answered.push(by);
    }
    state.answered = answered;
    completed(call, state, answers, keys)
}

/// As `test_occlusions`.
pub(super) fn any(call: &Call, state: &mut State, rays: MaskedRays<'_>, between: [f64; 2]) -> PyResult<Vec<bool>> {
    let mut hit = Vec::with_capacity(rays.0.len());
    for chunk in chunks(rays) {
        hit.append(&mut call.piece(|| state.hits_any(chunk, between))?);
    }
    Ok(hit)
}

/// As `count_intersections`.
pub(super) fn count(call: &Call, state: &mut State, rays: MaskedRays<'_>) -> PyResult<Vec<i32>> {
    let mut counts = Vec::with_capacity(rays.0.len());
    for chunk in chunks(rays) {
        let of_chunk = call.piece(|| state.count_hits(chunk))?;
        counts.extend(of_chunk.iter().map(|&count| count as i32));
    }
    Ok(counts)
}

/// All hits of all rays.
pub(super) struct Listed {
    /// The first hit of each ray, and the end.
    pub(super) splits: Vec<i64>,
    /// The ray of each hit.
    pub(super) rays: Vec<i64>,
    pub(super) hits: Answers,
}

/// As `list_intersections`.
pub(super) fn list(call: &Call, state: &mut State, rays: MaskedRays<'_>) -> PyResult<Listed> {
    let (bvh, triangles, masks) = call.piece(|| state.rays())?;
    let mut listed = Listed { splits: vec![0], rays: Vec::new(), hits: Answers::default() };
    for (chunk, of_rays) in chunks(rays) {
        let among = Masked { bvh, triangles, masks: masks.with(of_rays) };
        for (counts, hits) in call.piece(|| rays::list(among, chunk))? {
            listed.append(&counts, &hits);
        }
    }
    call.piece(|| listed.hits.complete_among(&state.instances, Keys::WITHOUT_NORMALS))?;
    Ok(listed)
}

impl Listed {
    fn append(&mut self, counts: &[u32], hits: &[Hit]) {
        for &count in counts {
            let ray = self.splits.len() as i64 - 1;
            self.rays.extend(std::iter::repeat_n(ray, count as usize));
            self.splits.push(self.rays.len() as i64);
        }
        self.hits.push(hits);
    }
}

/// As `scan`, with up to `returns` hits of each direction.
pub(super) fn scan(
    call: &Call,
    state: &mut State,
    pieces: Pieces<'_>,
    between: [f64; 2],
    returns: usize,
    keys: Keys,
) -> PyResult<Answers> {
    let mut answers = Answers::default();
    for sweep in pieces.sweeps() {
        let scanned = call.piece(|| state.scan(sweep, between, returns, keys.wanted()))?;
        call.piece(|| answers.append(scanned))?;
    }
    completed(call, state, answers, keys)
}

/// As `scan_any`.
pub(super) fn scan_any(call: &Call, state: &mut State, pieces: Pieces<'_>, between: [f64; 2]) -> PyResult<Vec<bool>> {
    let mut hit = Vec::new();
    for sweep in pieces.sweeps() {
        call.piece(|| state.scan_any(sweep, between, &mut hit))?;
    }
    Ok(hit)
}

/// As `see`. Grids have square pixels, so images of other pixels are traced as arbitrary rays.
pub(super) fn see(call: &Call, state: &mut State, image: &PixelRays, mask: u32, keys: Keys) -> PyResult<Answers> {
    if !image.are_square() {
        let rays = call.piece(|| image.rays(DVec3::ZERO))?;
        let answered = std::mem::take(&mut state.answered);
        let answers = cast(call, state, (Rays::Double(&rays), RayMasks::All(mask)), keys);
        state.answered = answered;
        return answers;
    }
    let answers = call.piece(|| state.see(image, mask, keys))?.map_err(exception)?;
    completed(call, state, answers, keys)
}

/// Points, or the centroids of all triangles where there are none, with geometry and number of each point's triangle.
#[derive(Clone, Copy)]
pub(super) struct Receiving<'a> {
    pub(super) points: Option<&'a [Vec3]>,
    pub(super) own: Option<[&'a [u32]; 2]>,
}

impl Receiving<'_> {
    /// The points' triangles by their ids among all.
    fn ids(self, state: &State) -> PyResult<Vec<u32>> {
        let ids = self.own.map_or(Ok(Vec::new()), |[geometries, triangles]| state.ids(geometries, triangles));
        ids.map_err(PyValueError::new_err)
    }
}

/// As `lit`, and the number of triangles.
pub(super) fn lit(
    call: &Call,
    state: &mut State,
    receiving: Receiving<'_>,
    facing: bool,
    lights: &[LightSource],
    masks: RayMasks<'_>,
) -> PyResult<(Vec<bool>, usize)> {
    let own = receiving.ids(state)?;
    let receivers = receiving.points.map_or(Receivers::Faces, |positions| Receivers::Points { positions, own: &own });
    let spots = receiving.points.map_or(Spots::Faces, |positions| Spots::Points(positions, &own));
    let mut lit = Vec::new();
    for (number, lights) in lights.chunks(LIGHTS).enumerate() {
        let (first, masks) = (lit.len(), masks::part(masks, number * LIGHTS, LIGHTS));
        call.piece(|| state.lit(receivers, lights, masks, &mut lit))?;
        if facing {
            let triangles = state.instances.triangles();
            call.piece(|| facing::keep_facing(triangles, spots, lights, &mut lit[first..]))?;
        }
    }
    Ok((lit, state.instances.triangles().len()))
}

/// As `incidence`, and the number of triangles.
pub(super) fn incidence(
    call: &Call,
    state: &State,
    receiving: Receiving<'_>,
    lights: &[LightSource],
) -> PyResult<(Vec<f32>, usize)> {
    let own = receiving.ids(state)?;
    let spots = receiving.points.map_or(Spots::Faces, |positions| Spots::Points(positions, &own));
    let triangles = state.instances.triangles();
    let mut cosines = Vec::new();
    for lights in lights.chunks(LIGHTS) {
        call.piece(|| facing::cosines(triangles, spots, lights, &mut cosines))?;
    }
    Ok((cosines, triangles.len()))
}

/// As `lit_areas`.
pub(super) fn lit_areas(
    call: &Call,
    state: &mut State,
    lights: &[LightSource],
    masks: RayMasks<'_>,
    samples: u32,
) -> PyResult<(Vec<LitShare>, usize)> {
    let (mut all, mut shares) = (Vec::new(), Vec::new());
    let masks = Masks { rays: masks, ..Masks::default() };
    for (number, light) in lights.iter().enumerate() {
        call.piece(|| state.lit_areas(light, masks.of_ray(number), samples, &mut shares))?;
        all.append(&mut shares);
    }
    Ok((all, state.instances.triangles().len()))
}

/// As `object_positions`.
pub(super) fn object_positions(
    call: &Call,
    state: &State,
    [geometries, triangles]: [&[u32]; 2],
    weights: &[[f32; 2]],
) -> PyResult<Vec<[f64; 3]>> {
    let ids = state.ids(geometries, triangles).map_err(PyValueError::new_err)?;
    let position = |(&triangle, &barycentric): (&u32, &[f32; 2])| {
        let is_some = triangle != INVALID_ID;
        is_some.then(|| state.instances.hit(&Hit { t: 0.0, triangle, barycentric }).position.to_array())
    };
    call.piece(|| ids.par_iter().zip(weights).map(|of| position(of).unwrap_or([f64::NAN; 3])).collect())
}

fn completed(call: &Call, state: &State, mut answers: Answers, keys: Keys) -> PyResult<Answers> {
    call.piece(|| answers.complete_among(&state.instances, keys))?;
    Ok(answers)
}
