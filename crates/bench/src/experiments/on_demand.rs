//! A scene in more or less memory than it takes: rays one by one, in queues, and in generations.

use anyhow::{Result, ensure};
use bytesize::ByteSize;
use clap::Args;
use glam::Vec3;
use umbrage::rays::{Hit, Ray};
use umbrage_papers::on_demand::{Answers, Costs, Order, Question, Scene};

use super::kd_tree::frame;
use crate::flags::ImageFlags;
use crate::grids::time;
use crate::measure::median;
use crate::rays::{of_camera, scattered_ray};
use crate::shot::{Lights, Shot, name};
use crate::table::{Cell, Row, row};

#[derive(Args, Debug)]
pub(crate) struct OnDemandFlags {
    /// Files, sequences or demo:NAME
    #[arg(default_values = ["demo:forest", "demo:hall"])]
    scenes: Vec<String>,
    /// The most that a part may take, one ray after the other and in queues
    #[arg(long, value_name = "SIZE", default_value = "64KiB")]
    part: ByteSize,
    /// The most that a part may take in generations: less than a processor's L2 cache
    #[arg(long, value_name = "SIZE", default_value = "512KiB")]
    cached_part: ByteSize,
    /// Which shares of all parts fit into memory: one half is 2
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [1, 2, 4, 8])]
    shares: Vec<u64>,
    #[command(flatten)]
    common: ImageFlags,
}

/// A scene's parts, and the order of its rays.
struct Trial<'a> {
    scene: &'a Scene,
    part: ByteSize,
    order: Order,
    share: u64,
}

impl OnDemandFlags {
    pub(crate) fn run(&self) -> Result<()> {
        ensure!(!self.shares.contains(&0), "a share of the scene is one part of some");
        let mut table = self.common.start_without_chart()?;
        for address in &self.scenes {
            let frame = frame(address)?;
            let mut shot = Shot::new(&frame, address, self.common.size, 1, Lights::First);
            shot.make_lights(1);
            let rays = of_camera(&shot);
            let scatter = |number: usize, ray: &Ray, hit: &Hit, corners: [Vec3; 3]| {
                Some(scattered_ray(number, ray, hit, corners))
            };
            let question = Question { rays: &rays, light: shot.lights[0], scatter: &scatter };
            let [small, large] = [self.part, self.cached_part].map(|part| {
                Ok::<_, std::io::Error>((
                    Scene::write(frame.triangles(), usize::try_from(part.as_u64()).unwrap_or(usize::MAX))?,
                    part,
                ))
            });
            let (small, large) = (small?, large?);
            let mut first: Option<Answers> = None;
            for &share in &self.shares {
                for order in Order::ALL {
                    let (scene, part) = if order == Order::Generations { &large } else { &small };
                    let trial = Trial { scene, part: *part, order, share };
                    table.push(trial.run(name(address), &question, self.common.animation.frames, &mut first)?)?;
                }
            }
        }
        table.finish(&[
            "Camera rays, one diffuse bounce, and a shadow ray from each hit, on one thread; all triangles opaque. share: of the",
            "parts' bytes in memory. loads, read: how often parts were read, and MiB of them, from a file that the system has in",
            "memory. resident: the most MiB of parts at any time; waiting: the most rays, in thousands; visits: of rays to parts.",
            "differ: rays whose answer isn't that of the first row.",
        ])?;
        Ok(())
    }
}

impl Trial<'_> {
    fn run(&self, name: &str, question: &Question<'_>, rounds: u32, first: &mut Option<Answers>) -> Result<Row> {
        let budget = (self.scene.bytes() / self.share).max(self.scene.largest());
        let (mut spent, mut costs, mut differ) = (Vec::new(), Costs::default(), 0);
        for _ in 0..rounds {
            let mut milliseconds = 0.0;
            let (answers, taken) = time(&mut milliseconds, || self.scene.trace(question, budget, self.order))?;
            let first = first.get_or_insert_with(|| answers.clone());
            differ = difference(first, &answers);
            spent.push(milliseconds);
            costs = taken;
        }
        const MIB: f64 = (1 << 20) as f64;
        Ok(row![
            ("scene", name),
            ("order", self.order.name()),
            ("share", if self.share == 1 { "1".to_owned() } else { format!("1/{}", self.share) }),
            ("part", self.part.to_string()),
            ("parts", self.scene.parts()),
            ("MiB", self.scene.bytes() as f64 / MIB),
            ("loads", costs.loads),
            ("read", Cell::Number(costs.bytes_read as f64 / MIB, 1)),
            ("resident", costs.most_resident_bytes as f64 / MIB),
            ("waiting", Cell::Number(costs.most_waiting as f64 / 1e3, 1)),
            ("visits", costs.visits),
            ("ms", Cell::Number(median(spent), 0)),
            ("differ", differ),
        ])
    }
}

/// Number of differing answers.
fn difference(a: &Answers, b: &Answers) -> usize {
    let of_hits =
        [0, 1].map(|bounce: usize| a.hits[bounce].iter().zip(&b.hits[bounce]).filter(|(a, b)| a != b).count());
    let of_lit = [0, 1].map(|bounce: usize| a.lit[bounce].iter().zip(&b.lit[bounce]).filter(|(a, b)| a != b).count());
    of_hits.into_iter().chain(of_lit).sum()
}
