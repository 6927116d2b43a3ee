//! The visible side panels and their widths.

use eframe::egui::Rangef;

use crate::app::Kept;

/// Panels that leave at least half of the window's width to the picture. Without room for two, the times replace
/// the controls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Panels {
    pub(super) has_work: bool,
    pub(super) has_controls: bool,
    /// Range of each panel's width, in points.
    pub(super) widths: Rangef,
}

impl Panels {
    /// Minimum width of a panel in points.
    const NARROWEST: f32 = 220.0;

    /// The wanted panels that fit into a window of this width, in points.
    pub(super) fn fit(kept: &Kept, window_width: f32) -> Self {
        let room = 0.5 * window_width;
        let most = (room / Self::NARROWEST) as u32;
        let has_work = kept.shows_work && most > 0;
        let has_controls = !kept.hides_controls && most > u32::from(has_work);
        let count = u32::from(has_work) + u32::from(has_controls);
        Self { has_work, has_controls, widths: Rangef::new(Self::NARROWEST, room / count.max(1) as f32) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_the_window_is_the_pictures() {
        for shows_work in [false, true] {
            for hides_controls in [false, true] {
                let kept = Kept { shows_work, hides_controls, ..Kept::default() };
                for width in [0.0, 100.0, 480.0, 640.0, 879.0, 880.0, 1000.0, 3000.0] {
                    let panels = Panels::fit(&kept, width);
                    let count = [panels.has_work, panels.has_controls].into_iter().filter(|shown| *shown).count();
                    assert!(count as f32 * panels.widths.max <= 0.5 * width, "{width}: {panels:?}");
                    assert!(count == 0 || panels.widths.min <= panels.widths.max, "{width}: {panels:?}");
                }
            }
        }
    }

    #[test]
    fn times_take_the_place_of_controls_where_only_one_has_room() {
        let shown = |kept: &Kept, width: f32| {
            let panels = Panels::fit(kept, width);
            (panels.has_work, panels.has_controls)
        };
        let both = Kept { shows_work: true, ..Kept::default() };
        assert_eq!(
            [300.0, 640.0, 1000.0].map(|width| shown(&both, width)),
            [(false, false), (true, false), (true, true)]
        );
        assert_eq!(shown(&Kept::default(), 640.0), (false, true));
    }
}
