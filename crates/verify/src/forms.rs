use glam::DVec2;
use rayon::prelude::*;
use umbrage_rays::predicate::{HitPoint, ShadowRay};
use umbrage_rays::{
    Cells, Insertion, KdBuilder, KdLayout, KdTraversal, KdTree, KdTreeOptions, LightGrid, LightSource, ListedGrid,
    ListedLightGrid, ListedLightOptions, ListedOptions, PacketSide, PerspectiveGrid, SeenImage, SeenPixels, TileOrder,
    Triangles, UniformGrid, UniformOptions, Unmasked, View,
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
        let Comparison { name, validates, .. } = comparison;
        let mut seen = SeenPixels::default();
        let mut grid = PerspectiveGrid::default();
        grid.build(self.triangles, &self.view, self.offset_pixels, |_| false).expect("a small image");
        if *validates {
            grid.validate(self.triangles).unwrap_or_else(|broken| panic!("{name}: {broken}"));
        }
        grid.trace(self.triangles, Unmasked, &mut seen);
        comparison.seen(&seen, "directly");
        let outliers = self.run_lights(comparison, &seen);

        let small_cells = ListedOptions { cells: Cells::new(8, 2, 7).expect("possible"), ..ListedOptions::DEFAULT };
        for options in [ListedOptions::DEFAULT, small_cells] {
            let mut grid = ListedGrid::default();
            grid.build(self.triangles, &self.view, self.offset_pixels, options, |_| false).expect("a small image");
            if *validates {
                grid.validate(self.triangles).unwrap_or_else(|broken| panic!("{name}, {options:?}: {broken}"));
            }
            grid.trace(self.triangles, Unmasked, &mut seen);
            comparison.seen(&seen, &format!("{options:?}"));
        }
        self.run_listed_lights(comparison, &seen);
        self.run_uniform(comparison);
        self.run_kd_trees(comparison);
        outliers
    }

    /// Every kind of builder, layout and traversal once; of what takes long, the fastest alone.
    fn run_kd_trees(&self, comparison: &Comparison<'_>) {
        let KdTreeOptions { lazy_below, .. } = KdTreeOptions::DEFAULT;
        let thorough = [
            (KdBuilder::Presorted, KdLayout::DepthFirst, KdTraversal::Restart, lazy_below),
            (KdBuilder::Presorted, KdLayout::Subtrees, KdTraversal::Stack, 40),
            (KdBuilder::Streaming, KdLayout::DepthFirst, KdTraversal::PushDown, lazy_below),
            (KdBuilder::Adaptive, KdLayout::Subtrees, KdTraversal::ShortStack(2), lazy_below),
        ];
        let fast = (KdBuilder::Binned, KdLayout::DepthFirst, KdTraversal::Stack, lazy_below);
        let thorough = thorough.into_iter().filter(|_| comparison.validates);
        for (builder, layout, traversal, lazy_below) in thorough.chain([fast]) {
            let options = KdTreeOptions { builder, layout, traversal, lazy_below, ..KdTreeOptions::DEFAULT };
            let mut tree = KdTree::default();
            tree.set_options(options).expect("possible");
            tree.build(self.triangles);
            if comparison.validates {
                let valid = tree.validate(self.triangles);
                valid.unwrap_or_else(|broken| panic!("{}, {options:?}: {broken}", comparison.name));
            }
            let truth = comparison.truth;
            let pixels = (0..self.view.width * self.view.height).into_par_iter().step_by(comparison.every);
            pixels.zip(&truth.triangle).enumerate().for_each(|(place, (pixel, &triangle))| {
                let (x, y) = (pixel % self.view.width, pixel / self.view.width);
                let at = || format!("{}, {options:?}: pixel ({x}, {y})", comparison.name);
                let ray = self.view.ray(f64::from(x) + self.offset_pixels.x, f64::from(y) + self.offset_pixels.y);
                let hit = tree.nearest(self.triangles, &ray, |_| true);
                assert_eq!(hit.map_or(SeenPixels::NONE, |hit| hit.triangle), triangle, "{}", at());
                let Some(hit) = hit else { return };
                for (light, lit) in self.lights.iter().zip(&truth.lit) {
                    let shadow_ray = ShadowRay::new(light, HitPoint::new(&ray, hit.t));
                    let blocked = tree.blocked(self.triangles, &shadow_ray, hit.triangle, |_, _| true);
                    assert_eq!(!blocked, lit[place], "{}, {light:?}", at());
                }
            });
        }
    }

    fn run_uniform(&self, comparison: &Comparison<'_>) {
        let mut seen = SeenPixels::default();
        let mut lit = Vec::new();
        let other = UniformOptions { packet: PacketSide::Four, insertion: Insertion::Exact, ..UniformOptions::DEFAULT };
        let nested = UniformOptions { packet: PacketSide::Eight, nested_above: Some(16), ..UniformOptions::DEFAULT };
        for options in [UniformOptions::DEFAULT, other, nested] {
            let mut grid = UniformGrid::default();
            grid.set_options(options).expect("possible");
            grid.build(self.triangles);
            if comparison.validates {
                let valid = grid.validate(self.triangles);
                valid.unwrap_or_else(|broken| panic!("{}, {options:?}: {broken}", comparison.name));
            }
            grid.see(self.triangles, &self.view, self.offset_pixels, |_| true, Unmasked, &mut seen);
            comparison.seen(&seen, &format!("{options:?}"));
            lit.resize(seen.order().places() / TileOrder::BLOCK_PLACES, 0);
            for (number, light) in self.lights.iter().enumerate() {
                grid.shadow(&self.image(&seen), light, |_| true, &Unmasked, &mut lit);
                comparison.lit(number, &seen, &lit, &format!("{light:?}, {options:?}"));
            }
        }
    }

    fn run_lights(&self, comparison: &Comparison<'_>, seen: &SeenPixels) -> Vec<u64> {
        let image = self.image(seen);
        let mut grid = LightGrid::default();
        grid.survey(&image);
        let mut lit = vec![0; seen.order().places() / TileOrder::BLOCK_PLACES];
        let outliers = self.lights.iter().enumerate().map(|(number, light)| {
            grid.shadow(&image, light, |_| true, &Unmasked, &mut lit);
            comparison.lit(number, seen, &lit, &format!("{light:?} directly"));
            let outliers = grid.counts().outliers;
            if comparison.validates {
                let valid = grid.validate(&image, light);
                valid.unwrap_or_else(|broken| panic!("{}, {light:?}: {broken}", comparison.name));
            }
            outliers
        });
        outliers.collect()
    }

    fn run_listed_lights(&self, comparison: &Comparison<'_>, seen: &SeenPixels) {
        let image = self.image(seen);
        let mut grid = ListedLightGrid::default();
        grid.survey(&image);
        let mut lit = vec![0; seen.order().places() / TileOrder::BLOCK_PLACES];
        let few_cells = ListedLightOptions::new(5, 16, 7).expect("possible");
        for (number, light) in self.lights.iter().enumerate() {
            for options in [ListedLightOptions::DEFAULT, few_cells] {
                grid.set_options(options);
                grid.shadow(&image, light, |_| true, &Unmasked, &mut lit);
                comparison.lit(number, seen, &lit, &format!("{light:?}, {options:?}"));
                if comparison.validates {
                    let valid = grid.validate(&image, light);
                    valid.unwrap_or_else(|broken| panic!("{}, {light:?}, {options:?}: {broken}", comparison.name));
                }
            }
        }
    }

    fn image<'a>(&'a self, seen: &'a SeenPixels) -> SeenImage<'a> {
        SeenImage { triangles: self.triangles, view: self.view, offset_pixels: self.offset_pixels, seen }
    }
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
        for ((x, y), &truth) in self.pixels(seen).zip(&self.truth.triangle) {
            assert_eq!(seen.triangle_at(x, y), truth, "{}, {how}: pixel ({x}, {y})", self.name);
        }
    }

    fn lit(&self, light: usize, seen: &SeenPixels, lit: &[u16], how: &str) {
        for ((x, y), &truth) in self.pixels(seen).zip(&self.truth.lit[light]) {
            let place = seen.order().place(x, y);
            let bit = lit[place / TileOrder::BLOCK_PLACES] >> (place % TileOrder::BLOCK_PLACES) & 1 == 1;
            assert_eq!(bit, truth, "{}, {how}: pixel ({x}, {y})", self.name);
        }
    }

    /// Columns and rows, row by row.
    fn pixels(&self, seen: &SeenPixels) -> impl Iterator<Item = (u32, u32)> + use<> {
        let (width, height) = seen.order().size();
        (0..height).flat_map(move |y| (0..width).map(move |x| (x, y))).step_by(self.every)
    }
}
