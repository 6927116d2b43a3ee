//! The spine: a frame from top to bottom.

use umbrage_scene::{Frame, Scene, check_lights};

use crate::background::Surroundings;
use crate::engine::{Engine, Output};
use crate::sampling::Samples;
use crate::{Error, Renderer, Settings, Stats};

/// What is rendered.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Subject<'a> {
    /// A scene at a moment, in seconds.
    Moment(&'a Scene, f64),
    /// A frame that somebody else has made.
    Frame(&'a Frame),
}

impl Renderer {
    /// Renders a frame to the film or to a texture: animate, build, see, shadow, shade, develop.
    pub(crate) fn render_subject(
        &mut self,
        subject: Subject<'_>,
        settings: &Settings,
        output: Output,
    ) -> Result<(), Error> {
        let Self { engine, posed, view, film, stats } = self;
        let engine = engine.as_mut();
        settings.check()?;
        engine.check(settings, output)?;
        let frame = animate(engine, subject, settings, posed, stats)?;
        let surroundings = Surroundings::new(&settings.background);
        let staged = settings.stage(frame, &surroundings)?;

        *view = Some(staged.view);
        film.clear(output.fetched(&staged.view))?;
        stats.time("build", || engine.build(&staged, output))?;
        for band in 0..engine.bands() {
            for samples in Samples::all(settings.samples, engine.traces_four(&staged.view)) {
                engine.see(&staged, &samples, stats)?;
                engine.shadow(&staged, &samples, stats)?;
                engine.shade(&staged, band, &samples, film, stats)?;
            }
            engine.develop(&staged, band, output, film, stats)?;
        }
        film.average(settings.samples);
        frame.materials.check_textures()?;

        stats.count(&staged, film, engine)
    }
}

/// Brings a scene to its moment, in memory that is used again, or takes over a frame as it is.
fn animate<'a>(
    engine: &mut dyn Engine,
    subject: Subject<'a>,
    settings: &Settings,
    posed: &'a mut Frame,
    stats: &mut Stats,
) -> Result<&'a Frame, Error> {
    match subject {
        Subject::Moment(scene, seconds) => {
            stats.start();
            stats.time("animate", || engine.animate(scene, seconds, settings, posed))?;
            if let Some(lights) = &settings.lights {
                posed.lights.clone_from(lights);
            }
            check_lights(&posed.lights)?;
            Ok(posed)
        }
        Subject::Frame(frame) => {
            // What is wrong with it is found before anything of the last frame is touched.
            frame.check_lit_by(settings.lights(frame))?;
            settings.view(frame)?;
            stats.start();
            engine.adopt();
            let Frame { mesh, lights, cameras, .. } = posed;
            // An empty one takes memory anew.
            let is_blank = mesh.triangles.is_empty() && lights.is_empty() && cameras.is_empty();
            if !is_blank {
                *posed = Frame::default();
            }
            Ok(frame)
        }
    }
}
