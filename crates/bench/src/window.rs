//! The window without a screen: its rate of pictures, and the cost of the interface itself.

use std::io::{self, Write};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use clap::Args;
use eframe::egui::{Context, Pos2, RawInput, Rect, vec2};
use umbrage_viewer::{App, EngineChoice, Start};

use crate::flags;
use crate::measure::median;

#[derive(Args, Debug)]
pub(crate) struct WindowFlags {
    /// Scenes to play
    #[arg(default_values_t = ["demo:forest".to_owned(), "demo:cloth".to_owned(), "demo:marbles".to_owned()])]
    scenes: Vec<String>,
    /// Width and height of pictures in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x1024", value_parser = flags::size)]
    size: [u32; 2],
    /// How many of the scene's lights shine [default: all]
    #[arg(long, value_name = "N")]
    lights: Option<usize>,
    /// Pictures to play
    #[arg(long, value_name = "N", default_value = "100")]
    pictures: u64,
}

/// Long enough for any picture.
const A_HANG: Duration = Duration::from_secs(120);

/// The simulated screen shows 60 pictures a second. Without this limit the interface would take a core from the renderer.
const REFRESH: Duration = Duration::from_nanos(1_000_000_000 / 60);

pub(crate) fn run(flags: &WindowFlags) -> Result<()> {
    let mut out = io::stdout();
    let [width, height] = flags.size;
    writeln!(out, "{width}x{height} on the CPU, {} pictures; medians in milliseconds", flags.pictures)?;
    writeln!(out, "{:<28}{:>8}{:>12}{:>14}{:>14}", "scene", "lights", "pictures/s", "a new picture", "other passes")?;
    for name in &flags.scenes {
        let own = umbrage::open(name)?.at(0.0)?.lights;
        let lights = flags.lights.map(|most| own.iter().take(most).cloned().collect());
        let count = flags.lights.map_or(own.len(), |most| most.min(own.len()));
        let start = Start {
            scene: Some(name.into()),
            engine: Some(EngineChoice::Cpu),
            size: Some(flags.size),
            lights,
            forgets: true,
            ..Start::default()
        };
        let Played { pictures_per_second, with_picture, without } = play(start, flags.pictures)?;
        let [with_picture, without] = [with_picture, without].map(median);
        writeln!(out, "{name:<28}{count:>8}{pictures_per_second:>12.1}{with_picture:>14.3}{without:>14.3}")?;
    }
    writeln!(out, "A pass is all that the interface does, but for drawing its triangles on the GPU.")?;
    Ok(())
}

/// Results of playing a scene.
struct Played {
    pictures_per_second: f64,
    /// Milliseconds of passes of the interface that had a new picture to show, and of the others.
    with_picture: Vec<f64>,
    without: Vec<f64>,
}

fn play(start: Start, pictures: u64) -> Result<Played> {
    let (woken, repaints) = channel();
    let context = Context::default();
    context.set_request_repaint_callback(move |_| {
        // Nobody waits any more once the window is gone.
        let _ = woken.send(());
    });
    let mut app = App::new(&context, start, None, None);
    let mut pass = Pass { context, repaints, next: Instant::now() };
    // The first pictures make room for themselves.
    while app.pictures() < 3 {
        pass.run(&mut app)?;
    }
    let (first, began) = (app.pictures(), Instant::now());
    let mut played = Played { pictures_per_second: 0.0, with_picture: Vec::new(), without: Vec::new() };
    while app.pictures() < first + pictures {
        let before = app.pictures();
        let milliseconds = pass.run(&mut app)?;
        let times = if app.pictures() > before { &mut played.with_picture } else { &mut played.without };
        times.push(milliseconds);
    }
    played.pictures_per_second = (app.pictures() - first) as f64 / began.elapsed().as_secs_f64();
    Ok(played)
}

struct Pass {
    context: Context,
    repaints: Receiver<()>,
    /// Time at which the screen shows the next picture.
    next: Instant,
}

impl Pass {
    /// Waits until there is a picture to show, then runs the interface, and returns its milliseconds.
    fn run(&mut self, app: &mut App) -> Result<f64> {
        if self.repaints.recv_timeout(A_HANG).is_err() {
            bail!("the window had nothing to show for {} seconds", A_HANG.as_secs());
        }
        std::thread::sleep(self.next.saturating_duration_since(Instant::now()));
        self.next = Instant::now() + REFRESH;
        while self.repaints.try_recv().is_ok() {}
        let screen = Rect::from_min_size(Pos2::ZERO, vec2(1500.0, 1200.0));
        let input = RawInput { screen_rect: Some(screen), ..RawInput::default() };
        let start = Instant::now();
        let output = self.context.run_ui(input, |ui| app.show(ui));
        drop(self.context.tessellate(output.shapes, output.pixels_per_point));
        Ok(start.elapsed().as_secs_f64() * 1e3)
    }
}
