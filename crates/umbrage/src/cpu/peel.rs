use rayon::prelude::*;
use umbrage_rays::{Hit, Ray, TileOrder, View};
use umbrage_scene::{Alpha, Frame};

use super::shadow::is_blocked;
use super::{Cpu, counts, hit_of};
use crate::sampling::Sample;

/// What the pixels of one sample show at one depth of layers, and which lights reach it, in [`TileOrder`].
#[derive(Clone, Debug, Default)]
pub(crate) struct PeeledLayer {
    /// What each place shows.
    pub(crate) hits: Vec<Option<Hit>>,
    /// Which places each light reaches: one bit each, the first place of a block in the lowest bit, light after light.
    pub(crate) lit: Vec<u16>,
}

impl PeeledLayer {
    /// Whether no pixel shows anything.
    pub(crate) fn is_empty(&self) -> bool {
        self.hits.iter().all(Option::is_none)
    }
}

impl Cpu {
    /// What is seen first, as the stages before have found it.
    pub(crate) fn first_layer(&self, frame: &Frame, view: &View, sample: &Sample) -> PeeledLayer {
        let order = self.seen.order();
        let hits = self.seen.triangle.par_iter().enumerate().map(|(place, &seen)| {
            let (x, y) = order.pixel(place)?;
            hit_of(frame, &sample.ray(view, x, y), seen)
        });
        let lit = self.lit.iter().flat_map(super::LightMask::blocks).copied();
        PeeledLayer { hits: hits.collect(), lit: lit.collect() }
    }

    /// What is seen behind a layer, where that lets some light through.
    pub(crate) fn layer_behind(&self, frame: &Frame, view: &View, sample: &Sample, layer: &PeeledLayer) -> PeeledLayer {
        let order = self.seen.order();
        let hits: Vec<Option<Hit>> = layer
            .hits
            .par_iter()
            .enumerate()
            .map(|(place, hit)| {
                let hit = (*hit).filter(|hit| is_seen_through(frame, hit.triangle))?;
                let (x, y) = order.pixel(place)?;
                let ray = sample.ray(view, x, y);
                let behind = Ray { t_min: hit.t, ..ray };
                let counts = |hit: &Hit| counts(frame, &ray, hit, self.culls_back_faces);
                self.bvh.nearest(frame.triangles(), &behind, counts)
            })
            .collect();
        let lit = frame.lights.iter().flat_map(|light| {
            let blocks = hits.par_chunks(TileOrder::BLOCK_PLACES).enumerate().map(|(block, hits)| {
                hits.iter().enumerate().fold(0_u16, |bits, (place, hit)| {
                    let Some(hit) = hit else { return bits };
                    let (x, y) = order.column_and_row(block * TileOrder::BLOCK_PLACES + place);
                    let is_lit = !is_blocked(&self.bvh, frame, light, &sample.ray(view, x, y), hit);
                    bits | u16::from(is_lit) << place
                })
            });
            blocks.collect::<Vec<u16>>()
        });
        let lit = lit.collect();
        PeeledLayer { hits, lit }
    }
}

fn is_seen_through(frame: &Frame, triangle: u32) -> bool {
    let material = frame.material(triangle);
    material.alpha == Alpha::Blend || material.transmission > 0.0
}
