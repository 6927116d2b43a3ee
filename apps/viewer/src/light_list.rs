//! The user's list of lights.

use glam::Vec3;
use umbrage::rays::LightSource;
use umbrage::scene::{Light, LightShape};
use umbrage::spec::LightSpec;

use crate::focus::Focus;

/// The scene's own lights, until the first change; from then on those of this list.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LightList {
    lights: Vec<Light>,
    /// Whether the list stands in place of the scene's lights.
    pub(crate) is_changed: bool,
    pub(crate) selected: Option<usize>,
}

impl LightList {
    /// Maximum number of lights.
    pub(crate) const MOST: usize = 256;

    /// A list of these lights, in place of the scene's own.
    pub(crate) fn of(lights: Vec<Light>) -> Self {
        Self { lights, is_changed: true, selected: None }
    }

    pub(crate) fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// The lights for settings; `None` for the scene's own.
    pub(crate) fn chosen(&self) -> Option<Vec<Light>> {
        self.is_changed.then(|| self.lights.clone())
    }

    /// Takes over the scene's lights at a moment, unless the user has changed them.
    pub(crate) fn follow(&mut self, lights: &[Light]) {
        if !self.is_changed {
            self.lights.clear();
            self.lights.extend_from_slice(lights);
            self.selected = self.selected.filter(|&selected| selected < lights.len());
        }
    }

    /// Restores the scene's own lights.
    pub(crate) fn reset(&mut self) {
        *self = Self::default();
    }

    /// A light of the list, which counts as changed.
    pub(crate) fn change(&mut self, light: usize) -> Option<&mut Light> {
        self.is_changed |= light < self.lights.len();
        self.lights.get_mut(light)
    }

    pub(crate) fn remove(&mut self, light: usize) {
        if light < self.lights.len() {
            self.lights.remove(light);
            self.is_changed = true;
            self.selected = None;
        }
    }

    /// A light of each kind above the scene's subject: in view, beside lights that were added before, and as bright as
    /// full sunlight at the center.
    pub(crate) fn to_add(&self, Focus { center, size }: Focus) -> [Light; 4] {
        let turn = 2.4 * self.lights.len() as f32;
        let position = center + Vec3::new(0.25 * turn.cos(), 0.36, 0.25 * turn.sin()) * size;
        let direction = unit(center - position).unwrap_or(Vec3::NEG_Y);
        let outer_radians = 0.5;
        let inner_radians = LightSpec::INNER * outer_radians;
        [
            (LightSource::Point { position }, LightShape::POINT),
            (LightSource::Spot { position, direction, inner_radians, outer_radians }, LightShape::POINT),
            (
                LightSource::to_one_side(position, direction),
                LightShape::Rectangle { width: 0.2 * size, height: 0.1 * size },
            ),
            (LightSource::Directional { direction }, LightShape::POINT),
        ]
        .map(|(source, shape)| LightSpec::new(source).shaped(shape).light(center, size))
    }

    /// Adds a light and selects it.
    pub(crate) fn add(&mut self, light: Light) {
        if self.lights.len() < Self::MOST {
            self.lights.push(light);
            self.is_changed = true;
            self.selected = Some(self.lights.len() - 1);
        }
    }
}

/// Name of a light's kind.
pub(crate) fn kind(light: &Light) -> &'static str {
    match (light.shape, light.source) {
        (LightShape::Rectangle { .. }, _) => "rectangle",
        (LightShape::Disk(_), _) => "disk",
        (_, LightSource::Point { .. }) => "point",
        (_, LightSource::Spot { .. }) => "spot",
        (_, LightSource::Directional { .. }) => "sun",
    }
}

/// Normalizes a direction, as `umbrage render --light` does.
pub(crate) fn unit(way: Vec3) -> Option<Vec3> {
    let mut unit = way.as_dvec3().try_normalize()?.as_vec3();
    for _ in 0..8 {
        let again = unit.as_dvec3().normalize().as_vec3();
        if again == unit {
            break;
        }
        unit = again;
    }
    Some(unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOCUS: Focus = Focus { center: Vec3::ZERO, size: 3.0 };

    #[test]
    fn the_scenes_lights_are_followed_until_they_are_changed() {
        let mut list = LightList::default();
        let sun =
            |direction: Vec3| Light { name: "sun".into(), ..Light::new(LightSource::Directional { direction }, 1.0) };
        list.follow(&[sun(Vec3::NEG_Y)]);
        list.follow(&[sun(Vec3::NEG_X)]);
        assert_eq!((list.chosen(), list.lights()), (None, &[sun(Vec3::NEG_X)][..]));
        list.change(0).expect("a light").intensity = 2.0;
        list.follow(&[sun(Vec3::NEG_Z)]);
        assert_eq!(list.chosen().expect("changed lights"), [Light { intensity: 2.0, ..sun(Vec3::NEG_X) }]);
        list.remove(0);
        list.remove(0);
        // An empty list differs from the scene's own lights.
        assert_eq!(list.chosen(), Some(Vec::new()));
        list.reset();
        list.follow(&[sun(Vec3::NEG_Z)]);
        assert_eq!(list.lights().len(), 1);
    }

    #[test]
    fn added_lights_are_above_the_scene_and_apart() {
        let mut list = LightList::default();
        for kind in 0..4 {
            list.add(list.to_add(FOCUS)[kind].clone());
        }
        let [
            Light { source: LightSource::Point { position: one }, .. },
            Light { source: LightSource::Spot { position: other, .. }, shape: LightShape::POINT, .. },
            Light { source: LightSource::Spot { .. }, shape: LightShape::Rectangle { .. }, .. },
            Light { source: LightSource::Directional { direction }, .. },
        ] = list.lights()
        else {
            panic!("other kinds")
        };
        assert!(one.y > 1.0 && other.y > 1.0 && one.distance(*other) > 0.5 && direction.y < 0.0);
        assert_eq!(list.selected, Some(3));
        (0..2 * LightList::MOST).for_each(|_| list.add(list.to_add(FOCUS)[0].clone()));
        assert_eq!(list.lights().len(), LightList::MOST);
    }

    #[test]
    fn units_are_units_of_themselves() {
        for way in [Vec3::new(1.0, 2.0, 3.0), Vec3::new(1e-30, 2e-30, 0.0), Vec3::new(1e20, -1.0, 1e19)] {
            let made = unit(way).expect("a direction");
            assert_eq!(made.as_dvec3().normalize().as_vec3(), made);
        }
        assert_eq!(unit(Vec3::ZERO), None);
    }
}
