use std::collections::TryReserveError;
use std::sync::Arc;

use glam::Vec2;
use umbrage_scene::{Light, Objects};

use super::coverage::Coverage;
use super::refill;
use crate::{Layer, Layers};

/// A film's layers beside its colours, in rows from the upper left corner. Layers that [`Settings::layers`](crate::Settings)
/// doesn't ask for are empty. All are of the camera rays' first hits, even of those that can be seen through.
#[derive(Clone, Debug, Default)]
pub struct FilmLayers {
    /// One for each light of the frame, in the lights' order.
    pub shadow: Vec<LightLayer>,
    /// Motion of the pixel's first hit until [`Settings::motion_seconds`](crate::Settings) later, in pixels to the right and
    /// downwards. Zero for a miss, for a point that will be behind the camera, and where the scene then has other triangles.
    pub motion: Vec<Vec2>,
    /// Weights of the second and the third corner of the triangle at the first sample; zero for a miss.
    pub barycentric: Vec<Vec2>,
    /// The object at the first sample, as an index into [`objects`](Self::objects);
    /// [`Film::NO_TRIANGLE`](crate::Film::NO_TRIANGLE) for a miss. The triangle is in [`Film::triangle`](crate::Film).
    pub object: Vec<u32>,
    /// The objects that all samples see.
    pub coverage: Coverage,
    /// The names of the objects, seen or not: no two are the same.
    pub objects: Vec<Arc<str>>,
}

/// The part of each pixel that a light reaches.
#[derive(Clone, Debug, Default)]
pub struct LightLayer {
    /// The light's name; may be empty, or another one's as well.
    pub name: Arc<str>,
    /// The part of each pixel's samples, from 0 to 1, that see a triangle on the side on which the light is, with nothing
    /// between them that stops light, and inside of a spot's cone; of lights that cast no shadow, the side alone
    /// counts. How bright the light is doesn't matter. Misses are 0.
    pub lit: Vec<f32>,
}

impl FilmLayers {
    /// Clears the chosen layers, and frees the rest.
    ///
    /// # Errors
    /// Where there is no memory for them.
    pub(super) fn clear(
        &mut self,
        [width, height]: [u32; 2],
        layers: Layers,
        lights: &[Light],
    ) -> Result<(), TryReserveError> {
        let all = width as usize * height as usize;
        let pixels_of = |layer: Layer| if layers.has(layer) { all } else { 0 };
        self.shadow.resize_with(if layers.has(Layer::Shadow) { lights.len() } else { 0 }, LightLayer::default);
        for (layer, light) in self.shadow.iter_mut().zip(lights) {
            layer.name.clone_from(&light.name);
            empty(&mut layer.lit, all, 0.0)?;
        }
        empty(&mut self.motion, pixels_of(Layer::Motion), Vec2::ZERO)?;
        empty(&mut self.barycentric, pixels_of(Layer::Barycentric), Vec2::ZERO)?;
        empty(&mut self.object, pixels_of(Layer::Ids), u32::MAX)?;
        let covered = pixels_of(Layer::Cryptomatte);
        self.coverage.reserve(covered)?;
        self.coverage.clear(covered, if covered == 0 { 0 } else { height as usize });
        self.objects.clear();
        Ok(())
    }

    /// Turns sums over `samples` samples into means.
    pub(super) fn average(&mut self, width: usize, samples: u32) {
        let weight = 1.0 / samples as f32;
        self.shadow.iter_mut().flat_map(|layer| &mut layer.lit).for_each(|sum| *sum *= weight);
        self.coverage.finish(width, weight);
    }

    /// The number of each object of a mesh in this film, and that of triangles without a name.
    pub(crate) fn numbers(&mut self, objects: &Objects) -> (Vec<u32>, u32) {
        let mut number_of = |expected: usize, name: &Arc<str>| {
            if self.objects.get(expected) == Some(name) {
                return expected as u32;
            }
            // Between two exposures of one frame, a scene may have other objects.
            let known = self.objects.iter().position(|known| known == name).unwrap_or(self.objects.len());
            if known == self.objects.len() {
                self.objects.push(Arc::clone(name));
            }
            known as u32
        };
        let numbers = objects.names().iter().enumerate().map(|(number, name)| number_of(number, name)).collect();
        let is_named = objects.of_triangle(0).is_some();
        let unnamed = if is_named { u32::MAX } else { number_of(usize::MAX, &Objects::WHOLE.into()) };
        (numbers, unnamed)
    }

    pub(super) fn bytes(&self) -> usize {
        self.shadow.iter().map(|layer| size_of_val(layer.lit.as_slice())).sum::<usize>()
            + size_of_val(self.motion.as_slice())
            + size_of_val(self.barycentric.as_slice())
            + size_of_val(self.object.as_slice())
            + self.coverage.bytes()
    }
}

fn empty<T: Copy + Send + Sync>(values: &mut Vec<T>, count: usize, value: T) -> Result<(), TryReserveError> {
    values.try_reserve_exact(count.saturating_sub(values.len()))?;
    refill(values, count, value);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_keep_their_numbers_from_exposure_to_exposure() {
        let objects = |names: &[&str]| {
            let mut objects = Objects::default();
            names.iter().enumerate().for_each(|(triangle, name)| objects.begin(triangle, name));
            objects
        };
        let mut layers = FilmLayers::default();
        assert_eq!(layers.numbers(&objects(&["a", "b"])), (vec![0, 1], u32::MAX));
        assert_eq!(layers.numbers(&objects(&["b", "c"])), (vec![1, 2], u32::MAX));
        assert_eq!(layers.numbers(&Objects::default()), (Vec::new(), 3));
        assert_eq!(layers.objects.iter().map(|name| &**name).collect::<Vec<_>>(), ["a", "b", "c", "scene"]);
    }
}
