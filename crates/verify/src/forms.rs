use glam::DVec2;
use rayon::prelude::*;
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{
    Bvh, Cells, DirectGrids, Insertion, KdBuilder, KdLayout, KdTraversal, KdTree, KdTreeOptions, LightMask,
    LightSource, ListedGrids, ListedLightOptions, ListedOptions, PacketSide, SeenPixels, SimdLevel, Structure,
    TileOrder, Triangles, UniformGrid, UniformOptions, View,
};

use crate::Oracle;

/// What a camera and lights see of triangles: every form of all grids and of the kd-tree must say what the oracle says.
#[derive(Clone, Copy, Debug)]
pub struct Shot<'a> {
    /// What there is.
    pub triangles: Triangles<'a>,
    /// The camera.
    pub view: View,
    /// Where in each pixel its ray goes through.
    pub offset_pixels: DVec2,
    /// Each with shadows.
    pub lights: &'a [LightSource],
}

/// What is true of each pixel of a [`Shot`], or of one in so many, row by row.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Truth {
    /// What it shows; [`SeenPixels::NONE`] for nothing.
    pub triangle: Vec<u32>,
    /// For each light, whether it reaches that; false for nothing.
    pub lit: Vec<Vec<bool>>,
}

impl Shot<'_> {
    /// The truth, by asking the oracle about each pixel.
    #[must_use]
    pub fn truth(&self) -> Truth {
        self.truth_of_some(1)
    }

    /// The truth about the first of each `every` pixels.
    #[must_use]
    pub fn truth_of_some(&self, every: u32) -> Truth {
        let oracle = Oracle::new(self.triangles);
        let of_pixel = |pixel: u32| {
            let (x, y) = (pixel % self.view.width, pixel / self.view.width);
            let ray = self.view.ray(f64::from(x) + self.offset_pixels.x, f64::from(y) + self.offset_pixels.y);
            let hit = oracle.nearest(&ray, |_| true);
            let lit = self.lights.iter().map(|light| {
                hit.is_some_and(|hit| {
                    let shadow_ray = ShadowRay::new(light, HitPoint::new(&ray, hit.t));
                    !oracle.blocked(&shadow_ray, hit.triangle, |_, _| true)
                })
            });
            (hit.map_or(SeenPixels::NONE, |hit| hit.triangle), lit.collect::<Vec<bool>>())
        };
        let pixels = (0..self.view.width * self.view.height).into_par_iter().step_by(every as usize);
        let (triangle, lit): (Vec<u32>, Vec<Vec<bool>>) = pixels.map(of_pixel).unzip();
        let of_light = |light: usize| lit.iter().map(|lit| lit[light]).collect();
        Truth { triangle, lit: (0..self.lights.len()).map(of_light).collect() }
    }

    /// Compares every form of all grids and of the kd-tree with the oracle, and validates them. Returns how many points of each light no
    /// face could hold, which are tested against all triangles.
    ///
    /// # Panics
    /// Where one of them says something else.
    pub fn check(&self, name: &str) -> Vec<u64> {
        self.check_against(&self.truth(), name)
    }

    /// As [`check`](Self::check), against a truth that is known.
    ///
    /// # Panics
    /// Where a grid says something else.
    pub fn check_against(&self, truth: &Truth, name: &str) -> Vec<u64> {
        self.run(&Comparison { truth, every: 1, validates: true, name })
    }

    /// As [`check_against`](Self::check_against), where the truth is that of the first of each `every` pixels, and without
    /// validating, which takes long for large images and many triangles.
    ///
    /// # Panics
    /// Where a grid says something else.
    pub fn compare(&self, truth: &Truth, every: u32, name: &str) -> Vec<u64> {
        self.run(&Comparison { truth, every: every as usize, validates: false, name })
    }

    fn run(&self, comparison: &Comparison<'_>) -> Vec<u64> {
        let shot = umbrage_rays::Shot {
            offset_pixels: self.offset_pixels,
            ..umbrage_rays::Shot::new(self.triangles, self.view)
        };
        let (mut seen, mut masks) = (SeenPixels::default(), vec![LightMask::default(); self.lights.len()]);
        let mut outliers = Vec::new();
        for (structure, is_fast, mut of) in structures() {
            if !(is_fast || comparison.validates) {
                continue;
            }
            of.build(self.triangles);
            of.see(&shot, &mut seen).expect("a small image");
            comparison.seen(&seen, structure);
            of.shadow(&shot, &seen, self.lights, &mut masks.iter_mut().collect::<Vec<_>>());
            masks.iter().enumerate().for_each(|(light, mask)| comparison.lit(light, mask, structure));
            if outliers.is_empty() {
                outliers = of.work_of_lights().iter().map(|work| work.counts.outliers).collect();
            }
            if comparison.validates {
                let valid = of.validate(&shot, &seen, self.lights);
                valid.unwrap_or_else(|broken| panic!("{}, {structure}: {broken}", comparison.name));
            }
        }
        outliers
    }
}

/// Every structure with options that lead different ways: its name, and whether it is fast enough for many triangles.
fn structures() -> Vec<(&'static str, bool, Box<dyn Structure>)> {
    let level = SimdLevel::default();
    let small_cells = ListedOptions { cells: Cells::new(8, 2, 7).expect("possible"), ..ListedOptions::DEFAULT };
    let few_cells = ListedLightOptions::new(5, 16, 7).expect("possible");
    let exact = UniformOptions { packet: PacketSide::Four, insertion: Insertion::Exact, ..UniformOptions::DEFAULT };
    let nested = UniformOptions { packet: PacketSide::Eight, nested_above: Some(16), ..UniformOptions::DEFAULT };
    let grid = |options| {
        let mut grid = Box::<UniformGrid>::default();
        grid.set_options(options).expect("possible");
        grid
    };
    let tree = |builder, layout, traversal, lazy_below| {
        let mut tree = Box::<KdTree>::default();
        let options = KdTreeOptions { builder, layout, traversal, lazy_below, ..KdTreeOptions::DEFAULT };
        tree.set_options(options).expect("possible");
        tree
    };
    let (depth_first, subtrees) = (KdLayout::DepthFirst, KdLayout::Subtrees);
    vec![
        ("direct", true, Box::new(DirectGrids::with_level(level))),
        ("listed", true, Box::<ListedGrids>::default()),
        ("listed, small cells", true, Box::new(ListedGrids::with_options(level, small_cells, few_cells))),
        ("uniform", true, grid(UniformOptions::DEFAULT)),
        ("uniform, exact", true, grid(exact)),
        ("uniform, nested", true, grid(nested)),
        ("kd, binned", true, tree(KdBuilder::Binned, depth_first, KdTraversal::Stack, 0)),
        ("kd, restart", false, tree(KdBuilder::Presorted, depth_first, KdTraversal::Restart, 0)),
        ("kd, lazy", false, tree(KdBuilder::Presorted, subtrees, KdTraversal::Stack, 40)),
        ("kd, push-down", false, tree(KdBuilder::Streaming, depth_first, KdTraversal::PushDown, 0)),
        ("kd, short stack", false, tree(KdBuilder::Adaptive, subtrees, KdTraversal::ShortStack(2), 0)),
        ("bvh", true, Box::<Bvh>::default()),
    ]
}

/// What the grids are held against.
struct Comparison<'a> {
    truth: &'a Truth,
    /// Of how many pixels the first is asked about.
    every: usize,
    validates: bool,
    name: &'a str,
}

impl Comparison<'_> {
    fn seen(&self, seen: &SeenPixels, how: &str) {
        for ((x, y), &truth) in self.pixels(seen.order()).zip(&self.truth.triangle) {
            assert_eq!(seen.triangle_at(x, y), truth, "{}, {how}: pixel ({x}, {y})", self.name);
        }
    }

    fn lit(&self, light: usize, mask: &LightMask, how: &str) {
        for ((x, y), &truth) in self.pixels(mask.order()).zip(&self.truth.lit[light]) {
            assert_eq!(mask.is_lit(x, y), truth, "{}, {how}, light {light}: pixel ({x}, {y})", self.name);
        }
    }

    /// Columns and rows, row by row.
    fn pixels(&self, order: TileOrder) -> impl Iterator<Item = (u32, u32)> + use<> {
        let (width, height) = order.size();
        (0..height).flat_map(move |y| (0..width).map(move |x| (x, y))).step_by(self.every)
    }
}
