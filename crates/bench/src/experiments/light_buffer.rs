//! Shadow rays from points that a diffuse bounce has hit, through a light buffer and through structures for all rays.

use anyhow::Result;
use clap::Args;
use rayon::prelude::*;
use umbrage::rays::predicate::{HitPoint, ShadowRay};
use umbrage::rays::{Bvh, KdTree, KdTreeOptions, LightSource, SingleRays, Structure as _};
use umbrage_papers::light_buffer::LightBuffer;

use super::kd_tree::frame;
use crate::flags::ImageFlags;
use crate::grids::time;
use crate::measure::median;
use crate::rays::{hits_of, of_camera, scattered};
use crate::shot::{Lights, Shot, name};
use crate::table::{Cell, row};

#[derive(Args, Debug)]
pub(crate) struct LightBufferFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:cloth", "demo:hall", "demo:forest", "demo:statue"])]
    scenes: Vec<String>,
    /// Cells along an edge of the cube
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [32, 128, 512])]
    cells: Vec<u32>,
    #[command(flatten)]
    common: ImageFlags,
}

impl LightBufferFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let mut table = self.common.start_without_chart()?;
        for address in &self.scenes {
            let frame = frame(address)?;
            let triangles = frame.triangles();
            let mut shot = Shot::new(&frame, address, self.common.size, 1, Lights::First);
            shot.make_lights(1);
            let middle = shot.bounds.center() + shot.bounds.size();
            let position = match shot.lights[0] {
                LightSource::Point { position } | LightSource::Spot { position, .. } => position,
                LightSource::Directional { .. } => middle,
            };
            let light = LightSource::Point { position };
            let mut milliseconds = [0.0; 2];
            let mut tree = KdTree::default();
            tree.set_options(KdTreeOptions::FAST)?;
            time(&mut milliseconds[0], || tree.build(triangles));
            let mut hierarchy = Bvh::default();
            time(&mut milliseconds[1], || hierarchy.build(triangles));
            let camera = of_camera(&shot);
            let bounced = scattered(triangles, &camera, &hits_of(&tree, triangles, &camera));
            let hits = hits_of(&tree, triangles, &bounced);
            let shadow_rays: Vec<(ShadowRay, u32)> = bounced
                .iter()
                .zip(&hits)
                .filter_map(|(ray, hit)| {
                    let hit = hit.as_ref()?;
                    Some((ShadowRay::new(&light, HitPoint::new(ray, hit.t)), hit.triangle))
                })
                .collect();
            let mut contestants: Vec<(String, f64, f64, Box<dyn SingleRays>)> = vec![
                ("kd-tree".to_owned(), milliseconds[0], tree.bytes().triangles as f64, Box::new(tree)),
                ("hierarchy".to_owned(), milliseconds[1], hierarchy.bytes().triangles as f64, Box::new(hierarchy)),
            ];
            for &cells in &self.cells {
                let mut milliseconds = 0.0;
                let buffer = time(&mut milliseconds, || LightBuffer::new(triangles, position, cells, &|_| true));
                contestants.push((
                    format!("buffer of 6·{cells}²"),
                    milliseconds,
                    buffer.bytes() as f64,
                    Box::new(buffer),
                ));
            }
            for (title, build, bytes, structure) in contestants {
                let mut shadowed = 0;
                let spent = (0..self.common.animation.frames).map(|_| {
                    let mut milliseconds = 0.0;
                    let is_blocked =
                        |(ray, own): &&(ShadowRay, u32)| structure.blocked(triangles, ray, *own, &|_, _| true);
                    shadowed =
                        time(&mut milliseconds, || shadow_rays.par_iter().with_min_len(256).filter(is_blocked).count());
                    milliseconds
                });
                let spent = median(spent);
                table.push(row![
                    ("scene", name(address)),
                    ("structure", title),
                    ("rays", shadow_rays.len()),
                    ("shadowed", shadowed),
                    ("build", build),
                    ("trace", spent),
                    ("rays_us", Cell::Number(shadow_rays.len() as f64 / (1e3 * spent), 2)),
                    ("bytes_triangle", Cell::Number(bytes / triangles.len().max(1) as f64, 1)),
                ])?;
            }
        }
        table.finish(&[
            "Shadow rays from what a diffuse bounce hits to one point light, one at a time; all triangles opaque.",
        ])?;
        Ok(())
    }
}
