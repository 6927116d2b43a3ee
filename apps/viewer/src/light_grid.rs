//! A light's grid: its cells as colours on surfaces, and its faces as frames in the view.

use eframe::egui::Color32;
use glam::Vec3;
use umbrage::rays::{LightCell, LightCells, LightFace, LightSource};

/// The drawing of a light's grid over a picture.
pub(crate) struct LightGridPicture {
    /// The light's index in the list.
    pub(crate) light: usize,
    /// The light's position; `None` for a sun.
    pub(crate) origin: Option<Vec3>,
    /// A tint for each pixel, in rows from the upper left corner; transparent for pixels without a surface.
    pub(crate) tints: Vec<Color32>,
    pub(crate) faces: Vec<LightFace>,
    /// The structure with these cells, where another one rendered.
    pub(crate) note: Option<&'static str>,
}

/// The colours of a cube's six faces.
const FACES: [[u8; 3]; 6] =
    [[40, 150, 255], [255, 150, 40], [90, 200, 90], [230, 90, 200], [60, 200, 200], [220, 200, 60]];

impl LightGridPicture {
    pub(crate) fn new(
        cells: &LightCells,
        [width, height]: [u32; 2],
        light: usize,
        source: &LightSource,
        note: Option<&'static str>,
    ) -> Self {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let tints = pixels.map(|(x, y)| {
            let left = x.checked_sub(1).and_then(|x| cells.at(x, y));
            let above = y.checked_sub(1).and_then(|y| cells.at(x, y));
            cells.at(x, y).map_or(Color32::TRANSPARENT, |cell| tint(cell, [left, above]))
        });
        let origin = match *source {
            LightSource::Point { position } | LightSource::Spot { position, .. } => Some(position),
            LightSource::Directional { .. } => None,
        };
        Self { light, origin, tints: tints.collect(), faces: cells.faces().to_vec(), note }
    }

    /// The title: the light and its faces' numbers of cells.
    pub(crate) fn title(&self) -> String {
        let faces: Vec<String> =
            self.faces.iter().map(|LightFace { columns, rows, .. }| format!("{columns} × {rows}")).collect();
        let faces = if faces.is_empty() { "no".to_owned() } else { faces.join(", ") };
        let note = self.note.map(|note| format!(", {note}")).unwrap_or_default();
        format!("Light {}: {faces} cells{note}", self.light + 1)
    }

    /// The colour of a face's cells and of its frame.
    pub(crate) fn color(face: usize) -> Color32 {
        let [red, green, blue] = FACES[face % FACES.len()];
        Color32::from_rgb(red, green, blue)
    }
}

/// The tint of a pixel in a cell, given the cells of neighbouring pixels: a chessboard with bright borders.
fn tint(cell: LightCell, beside: [Option<LightCell>; 2]) -> Color32 {
    let color = LightGridPicture::color(usize::from(cell.face));
    let is_border = beside.into_iter().flatten().any(|other| other != cell);
    let is_odd = (cell.column ^ cell.row) & 1 == 1;
    match (is_border, is_odd) {
        (true, _) => Color32::from_rgba_unmultiplied(255, 255, 255, 110),
        (false, true) => Color32::from_rgba_unmultiplied(color.r(), color.g(), color.b(), 130),
        (false, false) => Color32::from_black_alpha(110),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_cells_differ_and_borders_are_brighter() {
        let cell = LightCell { face: 0, column: 4, row: 7 };
        let right = LightCell { column: 5, ..cell };
        let [below, other] = [LightCell { row: 8, ..cell }, LightCell { face: 1, ..cell }];
        let inside = |cell| tint(cell, [Some(cell); 2]);
        for neighbour in [right, below, other] {
            assert_ne!(inside(cell), inside(neighbour));
            let border = tint(neighbour, [Some(cell), Some(neighbour)]);
            assert_eq!(border, tint(neighbour, [None, Some(cell)]));
            let sum = |color: Color32| u32::from(color.r()) + u32::from(color.g()) + u32::from(color.b());
            assert!(sum(border) > sum(inside(cell)) && sum(border) > sum(inside(neighbour)));
        }
        // The borders of the picture and of surfaces aren't borders of cells.
        assert_eq!(tint(cell, [None, None]), inside(cell));
        assert_eq!(inside(cell), inside(LightCell { column: 6, ..cell }));
    }
}
