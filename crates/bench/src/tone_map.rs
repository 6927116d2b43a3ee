use anyhow::Result;
use clap::Args;
use glam::Vec4;
use umbrage::rays::Choice as _;
use umbrage::{Film, Settings, ToneMap};

use crate::flags::OutputFlags;
use crate::plot::{LineChart, Scale, Series};
use crate::table::{Cell, row};

#[derive(Args, Debug)]
pub(crate) struct ToneMapFlags {
    #[command(flatten)]
    output: OutputFlags,
}

/// Maximum radiance, and number of steps.
const MOST: f32 = 3.0;
const STEPS: u32 = 60;

impl ToneMapFlags {
    pub(crate) fn run(&self) -> Result<()> {
        let mut table = self.output.start("grey, without exposure")?;
        let mut series = Vec::new();
        for step in 0..=STEPS {
            let radiance = MOST * step as f32 / STEPS as f32;
            for tone_map in ToneMap::all() {
                let level = level(radiance, tone_map);
                Series::add(&mut series, tone_map.name(), [f64::from(radiance), level]);
                if step % 4 == 0 {
                    table.push(row![
                        ("radiance", Cell::Number(f64::from(radiance), 2)),
                        ("tone map", tone_map.name()),
                        ("level", Cell::Number(level, 1)),
                    ])?;
                }
            }
        }
        let notes =
            ["Levels of 255 that a picture has of grey. Unlit materials and backgrounds of one colour keep theirs."];
        let (x_title, y_title, scales) = ("radiance", "level of 255, in sRGB", [Scale::Linear; 2]);
        let chart = LineChart { title: "Tone maps", x_title, y_title, scales, series };
        self.output.finish(table, &notes, &chart)
    }
}

/// Level of a grey pixel in a picture.
fn level(radiance: f32, tone_map: ToneMap) -> f64 {
    let settings = Settings { tone_map, ..Settings::default() };
    let film = Film { width: 1, height: 1, color: vec![Vec4::splat(radiance)], ..Film::default() };
    f64::from(film.develop(&settings).pixels[0][0]) / 257.0
}
