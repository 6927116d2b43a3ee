//! A structure of your own, by name and with an option, in one file: all triangles are tested on every ray.
//!
//! `cargo run --release -p umbrage --example own_structure`

use umbrage::rays::predicate::{ShadowRay, hit};
use umbrage::rays::{
    self, Bytes, Hit, ImageTooLarge, LightMask, LightSource, Omitted, Ray, SeenPixels, Shot, SimdLevel, SingleRays,
    Triangles, Work, ray_by_ray,
};
use umbrage::{Error, KindOption, OptionValues, Renderer, Settings, StructureKind, StructureOption, Structures};

/// The kind, with its options.
#[derive(Clone, Debug, Default, PartialEq)]
struct BruteForce {
    /// Whether triangles are tested from the last to the first.
    from_last: bool,
}

impl StructureKind for BruteForce {
    const NAME: &'static str = "brute-force";
    const ABOUT: &'static str = "no structure: every ray is tested on all triangles";
    const OPTIONS: &'static [KindOption<Self>] = &[KindOption {
        option: StructureOption {
            name: "from-last",
            about: "Test triangles from the last to the first",
            values: OptionValues::Switch,
            is_on_gpu: false,
        },
        get: |kind| kind.from_last.to_string(),
        set: |kind, value| {
            kind.from_last = value == "true";
            Ok(())
        },
    }];

    fn make(&self, _level: SimdLevel, _sends_rays_onward: bool) -> Result<Box<dyn rays::Structure>, Error> {
        Ok(Box::new(AllTriangles { from_last: self.from_last, ..AllTriangles::default() }))
    }
}

/// The structure: ids of the triangles that rays can hit.
#[derive(Debug, Default)]
struct AllTriangles {
    from_last: bool,
    ids: Vec<u32>,
    omitted: Omitted,
}

/// Asks the exact predicate about every triangle but the one that a ray starts on.
impl SingleRays for AllTriangles {
    fn nearest_from(&self, triangles: Triangles<'_>, ray: &Ray, own: u32, stops: &dyn Fn(&Hit) -> bool) -> Option<Hit> {
        let others = self.ids.iter().filter(|&&id| id != own);
        let hits = others.filter_map(|&id| hit(ray, triangles, id)).filter(|hit| stops(hit));
        hits.min_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)))
    }

    fn blocked(
        &self,
        triangles: Triangles<'_>,
        shadow_ray: &ShadowRay,
        own: u32,
        stops: &dyn Fn(u32, [f32; 2]) -> bool,
    ) -> bool {
        let mut others = self.ids.iter().filter(|&&id| id != own);
        others.any(|&id| shadow_ray.blocked_by(triangles.corners(id)).is_some_and(|weights| stops(id, weights)))
    }
}

impl rays::Structure for AllTriangles {
    fn build(&mut self, triangles: Triangles<'_>) {
        self.ids.clear();
        self.ids.extend((0..triangles.len() as u32).filter(|&id| triangles.usable_corners(id).is_ok()));
        if self.from_last {
            self.ids.reverse();
        }
        self.omitted = triangles.omitted();
    }

    fn see(&mut self, shot: &Shot<'_>, seen: &mut SeenPixels) -> Result<Work, ImageTooLarge> {
        ray_by_ray::see(self, shot, seen);
        Ok(Work::default())
    }

    fn shadow(&mut self, shot: &Shot<'_>, seen: &SeenPixels, lights: &[LightSource], masks: &mut [LightMask]) -> Work {
        ray_by_ray::shadow(self, shot, seen, lights, masks);
        Work::default()
    }

    fn omitted(&self) -> &Omitted {
        &self.omitted
    }

    fn bytes(&self) -> Bytes {
        Bytes { triangles: self.ids.capacity() * size_of::<u32>(), points: 0 }
    }

    fn validate(&mut self, shot: &Shot<'_>, _: &SeenPixels, _: &[LightSource]) -> Result<(), String> {
        let expected = shot.triangles.len() - shot.triangles.omitted().total() as usize;
        if self.ids.len() == expected { Ok(()) } else { Err(format!("{} of {expected} triangles", self.ids.len())) }
    }

    fn single_rays(&self) -> Option<&dyn SingleRays> {
        Some(self)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let structures = Structures::default().with::<BruteForce>();
    let scene = umbrage::open("demo:cloth?triangles=500")?;
    let mut pictures = Vec::new();
    for text in ["perspective", "bvh", "brute-force", "brute-force:from-last=true"] {
        let structure = structures.parse(text)?;
        let settings = Settings { width: 160, height: 90, structure, ..Settings::default() };
        let mut renderer = Renderer::default();
        let film = renderer.render(&scene, 0.5, &settings)?;
        pictures.push((film.triangle.clone(), film.color.clone()));
        let milliseconds: f64 = renderer.stats().stages.iter().map(|stage| stage.milliseconds).sum();
        println!("{text:<28} {milliseconds:8.1} ms");
    }
    assert!(pictures.iter().all(|picture| *picture == pictures[0]), "every structure gives the same picture");
    Ok(())
}
