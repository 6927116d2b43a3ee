//! Scheduling of rays and parts.

use std::collections::VecDeque;

use umbrage_rays::predicate::{HitPoint, ShadowRay};

use super::parts::{Cache, Scene};
use super::rays::{Asks, Traveller};
use super::{Answers, Costs, Error, Order, Question};

impl Scene {
    /// Traces a question with no more than `budget` bytes of parts in memory, on one thread.
    ///
    /// # Errors
    /// If `budget` is less than [`Scene::largest`], or the file can't be read.
    pub fn trace(&self, question: &Question<'_>, budget: u64, order: Order) -> Result<(Answers, Costs), Error> {
        let count = question.rays.len();
        let answers =
            Answers { hits: [vec![None; count], vec![None; count]], lit: [vec![false; count], vec![false; count]] };
        let mut tracer =
            Tracer { scene: self, question, cache: Cache::new(self, budget)?, answers, costs: Costs::default() };
        match order {
            Order::RayByRay => tracer.ray_by_ray()?,
            Order::FirstCome | Order::BenefitOverCost => tracer.in_queues(order)?,
            Order::Generations => tracer.in_generations()?,
        }
        Ok((tracer.answers, tracer.costs))
    }
}

struct Tracer<'a> {
    scene: &'a Scene,
    question: &'a Question<'a>,
    cache: Cache<'a>,
    answers: Answers,
    costs: Costs,
}

/// Rays waiting for a part.
#[derive(Clone, Debug, Default)]
struct Queue {
    rays: Vec<Traveller>,
    weight: f64,
    /// Arrival time of the first of them.
    since: u64,
}

impl Tracer<'_> {
    /// Fraction of a ray's weight that the bounced ray gets: a surface that reflects half of the light.
    const ALBEDO: f32 = 0.5;

    /// The rays from the camera, at their first parts.
    fn first_rays(&mut self) -> Vec<Traveller> {
        let mut first = Vec::new();
        for (index, ray) in (0..).zip(self.question.rays) {
            self.start(Traveller::new(Asks::Nearest(*ray, None), index, 0, 1.0), &mut first);
        }
        first
    }

    /// Queues a ray at its next part, or finishes it if there is none.
    fn start(&mut self, mut ray: Traveller, onward: &mut Vec<Traveller>) {
        if ray.go_on(self.scene) { onward.push(ray) } else { self.finish(&ray, onward) }
    }

    /// Stores the answer of a finished ray, and queues the rays that it spawns.
    fn finish(&mut self, ray: &Traveller, onward: &mut Vec<Traveller>) {
        let &Traveller { asks, index, bounce, weight, .. } = ray;
        let (of_index, of_bounce) = (index as usize, usize::from(bounce));
        match asks {
            // A blocked shadow ray has ended before.
            Asks::Shadow(..) => self.answers.lit[of_bounce][of_index] = true,
            Asks::Nearest(_, None) => {}
            Asks::Nearest(ray, Some((hit, corners))) => {
                self.answers.hits[of_bounce][of_index] = Some(hit);
                let shadow = ShadowRay::new(&self.question.light, HitPoint::new(&ray, hit.t));
                self.start(Traveller::new(Asks::Shadow(shadow, hit.triangle), index, bounce, weight), onward);
                let scattered = (bounce == 0).then(|| (self.question.scatter)(of_index, &ray, &hit, corners)).flatten();
                if let Some(ray) = scattered {
                    self.start(Traveller::new(Asks::Nearest(ray, None), index, 1, weight * Self::ALBEDO), onward);
                }
            }
        }
    }

    /// Traces the rays that wait for a part through it; queues the survivors in `onward`, and the rays that they spawn
    /// in `new`.
    fn go_through(
        &mut self,
        part: usize,
        rays: Vec<Traveller>,
        onward: &mut Vec<Traveller>,
        new: &mut Vec<Traveller>,
    ) -> Result<(), Error> {
        let loaded = self.cache.get(part, &mut self.costs)?;
        self.costs.visits += rays.len() as u64;
        let mut done = Vec::new();
        for mut ray in rays {
            if ray.visit(loaded).is_break() {
                continue;
            }
            if ray.go_on(self.scene) { onward.push(ray) } else { done.push(ray) }
        }
        done.iter().for_each(|ray| self.finish(ray, new));
        Ok(())
    }

    fn ray_by_ray(&mut self) -> Result<(), Error> {
        for (index, ray) in (0..).zip(self.question.rays) {
            let mut waiting = Vec::new();
            self.start(Traveller::new(Asks::Nearest(*ray, None), index, 0, 1.0), &mut waiting);
            while let Some(ray) = waiting.pop() {
                self.costs.most_waiting = self.costs.most_waiting.max(1 + waiting.len() as u64);
                let mut new = Vec::new();
                self.go_through(ray.part(), vec![ray], &mut waiting, &mut new)?;
                waiting.append(&mut new);
            }
        }
        Ok(())
    }

    fn in_queues(&mut self, order: Order) -> Result<(), Error> {
        let mut queues = Queues::new(self.scene.parts());
        queues.add(self.first_rays());
        while let Some(part) = queues.choose(|part, queue| match order {
            Order::BenefitOverCost => queue.weight / self.cost(part),
            _ => -(queue.since as f64),
        }) {
            let (mut onward, mut new) = (Vec::new(), Vec::new());
            self.costs.most_waiting = self.costs.most_waiting.max(queues.waiting);
            self.go_through(part, queues.take(part), &mut onward, &mut new)?;
            queues.add(onward);
            queues.add(new);
        }
        Ok(())
    }

    /// Cost of a part: the bytes to read, or a small fraction if it is in memory.
    fn cost(&self, part: usize) -> f64 {
        const OF_RESIDENT: f64 = 1.0 / 16.0;
        let bytes = self.scene.parts[part].bytes() as f64;
        if self.cache.holds(part) { bytes * OF_RESIDENT } else { bytes }
    }

    /// Of the spawned rays, shadow rays come a generation before bounced rays.
    fn in_generations(&mut self) -> Result<(), Error> {
        let mut queues = Queues::new(self.scene.parts());
        let mut generations = VecDeque::from([self.first_rays()]);
        while let Some(generation) = generations.pop_front() {
            let mut new = Vec::new();
            let later: usize = generations.iter().map(Vec::len).sum();
            queues.add(generation);
            // Sweeps over the parts in the order of the hierarchy, until no ray waits.
            while queues.waiting > 0 {
                for part in 0..self.scene.parts() {
                    self.costs.most_waiting = self.costs.most_waiting.max(queues.waiting + (later + new.len()) as u64);
                    let rays = queues.take(part);
                    if rays.is_empty() {
                        continue;
                    }
                    let mut onward = Vec::new();
                    self.go_through(part, rays, &mut onward, &mut new)?;
                    queues.add(onward);
                }
            }
            let (to_light, others): (Vec<_>, Vec<_>) =
                new.into_iter().partition(|ray| matches!(ray.asks, Asks::Shadow(..)));
            generations.extend([to_light, others].into_iter().filter(|generation| !generation.is_empty()));
        }
        Ok(())
    }
}

/// A queue for each part.
struct Queues {
    queues: Vec<Queue>,
    waiting: u64,
    /// Number of rays that have arrived.
    came: u64,
}

impl Queues {
    fn new(parts: usize) -> Self {
        Self { queues: vec![Queue::default(); parts], waiting: 0, came: 0 }
    }

    fn add(&mut self, rays: Vec<Traveller>) {
        self.waiting += rays.len() as u64;
        for ray in rays {
            self.came += 1;
            let queue = &mut self.queues[ray.part()];
            if queue.rays.is_empty() {
                queue.since = self.came;
            }
            queue.weight += f64::from(ray.weight);
            queue.rays.push(ray);
        }
    }

    fn take(&mut self, part: usize) -> Vec<Traveller> {
        let rays = std::mem::take(&mut self.queues[part]).rays;
        self.waiting -= rays.len() as u64;
        rays
    }

    /// The first part of greatest worth among those with waiting rays; `None` if no ray waits.
    fn choose(&self, worth: impl Fn(usize, &Queue) -> f64) -> Option<usize> {
        let waited_for = self.queues.iter().enumerate().filter(|(_, queue)| !queue.rays.is_empty());
        let worths = waited_for.map(|(part, queue)| (part, worth(part, queue)));
        worths.reduce(|best, other| if other.1 > best.1 { other } else { best }).map(|(part, _)| part)
    }
}
