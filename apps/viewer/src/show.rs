//! The quantity that the picture shows.

use umbrage::rays::Choice;
use umbrage::{HeatKind, PixelView};

use crate::heat;

/// Light, another view of the pixels, or a heat map of their cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Show {
    #[default]
    Light,
    View(PixelView),
    Heat(HeatKind),
}

impl Show {
    pub(crate) fn views() -> impl Iterator<Item = Self> {
        PixelView::all().map(Self::View)
    }

    pub(crate) fn heats() -> impl Iterator<Item = Self> {
        HeatKind::all().map(Self::Heat)
    }

    pub(crate) fn view(self) -> Option<PixelView> {
        match self {
            Self::View(view) => Some(view),
            Self::Light | Self::Heat(_) => None,
        }
    }

    pub(crate) fn heat(self) -> Option<HeatKind> {
        match self {
            Self::Heat(heat) => Some(heat),
            Self::Light | Self::View(_) => None,
        }
    }

    pub(crate) fn title(self) -> String {
        match self {
            Self::Light => "Light".to_owned(),
            Self::View(PixelView::Uv) => "UV".to_owned(),
            Self::View(view) => heat::capitalised(view.name()),
            Self::Heat(heat) => heat::title(heat),
        }
    }

    /// A longer description.
    pub(crate) fn about(self) -> &'static str {
        match self {
            Self::Light => "the light that comes from what each pixel shows",
            Self::View(view) => view.about(),
            Self::Heat(heat) => heat.about(),
        }
    }

    /// The next of the views, and light after the last one.
    pub(crate) fn next_view(self) -> Self {
        self.next(&Self::views().collect::<Vec<_>>())
    }

    /// The next of the heat maps, and light after the last one.
    pub(crate) fn next_heat(self) -> Self {
        self.next(&Self::heats().collect::<Vec<_>>())
    }

    fn next(self, list: &[Self]) -> Self {
        let next = list.iter().position(|other| *other == self).map_or(0, |position| position + 1);
        list.get(next).copied().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_go_through_a_list_and_back_to_light() {
        let seen = std::iter::successors(Some(Show::Light), |shown| Some(shown.next_view()));
        let titles: Vec<String> = seen.take(6).map(Show::title).collect();
        assert_eq!(titles, ["Light", "Normals", "UV", "Depth", "Wireframe", "Light"]);
        let all = std::iter::successors(Some(Show::Light.next_heat()), |shown| Some(shown.next_heat()));
        assert!(all.take_while(|shown| *shown != Show::Light).eq(Show::heats()));
        // From the other list, the first entry of this one follows.
        assert_eq!(Show::View(PixelView::Depth).next_heat(), Show::Heat(HeatKind::Tested));
        assert_eq!(Show::Heat(HeatKind::Pairs).next_view(), Show::View(PixelView::Normals));
    }
}
