//! Bounds, objects and floor of a scene, found by posing it at a few moments.

use std::sync::Arc;

use umbrage_rays::Bounds;

use crate::scene::diagonal;
use crate::{Animated, Error, Frame, ground};

/// Facts about a scene that don't change.
pub(crate) struct Survey {
    /// Bounds over a few moments, enough for a view that doesn't cut much off.
    pub(crate) bounds: Bounds,
    /// The diagonal of the bounds of the first of these moments that has any.
    pub(crate) size: f32,
    /// The names of the first moment's objects.
    pub(crate) objects: Vec<Arc<str>>,
    /// Whether the first moment has neither lights nor a floor.
    pub(crate) lacks_floor: bool,
    /// Whether the first moment has points or lines.
    pub(crate) has_marks: bool,
}

impl Survey {
    pub(crate) fn of(source: &dyn Animated) -> Result<Self, Error> {
        const MOMENTS: u32 = 5;
        let duration = source.duration_seconds();
        let moments = if duration > 0.0 { MOMENTS } else { 1 };
        let mut frame = Frame::default();
        let mut survey =
            Self { bounds: Bounds::EMPTY, size: 0.0, objects: Vec::new(), lacks_floor: false, has_marks: false };
        for moment in 0..moments {
            begin(&mut frame);
            source.pose(duration * f64::from(moment) / f64::from(moments), &mut frame)?;
            let bounds = frame.bounds();
            survey.bounds = survey.bounds.union(bounds);
            if survey.size == 0.0 && !bounds.is_empty() {
                survey.size = diagonal(bounds);
            }
            if moment == 0 {
                survey.objects = frame.mesh.objects.names().to_vec();
                survey.lacks_floor = ground::lacks_floor(&frame);
                survey.has_marks = !frame.mesh.marks.is_empty();
            }
        }
        Ok(survey)
    }
}

/// Removes lights and cameras, which sources add.
pub(crate) fn begin(frame: &mut Frame) {
    frame.lights.clear();
    frame.cameras.clear();
}
