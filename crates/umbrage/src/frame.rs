//! The spine: a frame from top to bottom.

use umbrage_scene::{Frame, Scene, check_lights};

use crate::background::Surroundings;
use crate::engine::{Engine, Output};
use crate::exposure::{Exposures, Spread};
use crate::motion::Next;
use crate::{Error, Layer, Renderer, Settings, Stats};

/// The subject of a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Subject<'a> {
    /// A scene at a moment, in seconds.
    Moment(&'a Scene, f64),
    /// A frame that the caller made.
    Frame(&'a Frame),
}

impl Renderer {
    /// Renders a frame to the film or to a texture: animate, build, see, shadow, shade, develop. With a wide lens, an
    /// open shutter or lights with a size it is the mean of exact frames, each at another point of these.
    pub(crate) async fn render_subject(
        &mut self,
        subject: Subject<'_>,
        settings: &Settings,
        output: Output,
    ) -> Result<(), Error> {
        let Self { engine, posed, next, view, film, last_sample, stats, progress, .. } = self;
        let engine = engine.as_mut();
        settings.check()?;
        subject.check(settings)?;
        engine.begin(settings, output)?;
        stats.start();
        last_sample.take();
        progress.set(0.0);

        let surroundings = Surroundings::new(&settings.background);
        let mut frame = animate(engine, subject, settings, posed, stats)?;
        let mut staged = settings.stage(frame, &surroundings)?;
        let spread = Spread::new(&staged, || engine.whole_frame(frame))?;
        *view = Some(staged.view);
        film.resize(output.fetched(&staged.view), &staged)?;
        film.clear_layers(&staged)?;
        let passes = stats.time("build", || engine.build(&staged, output))?;
        let mut exposures = Exposures::new(settings, spread, passes);
        while let Some(exposure) = exposures.next() {
            progress.go_on()?;
            if !exposure.is_posed {
                frame = animate(engine, subject.after(exposure.seconds), settings, posed, stats)?;
                staged = settings.stage(frame, &surroundings)?;
                stats.time("build", || engine.build(&staged, output))?;
            }
            let mut lights = Vec::new();
            let exposed = exposures.expose(&exposure, &staged, &mut lights);
            engine.see(&exposed, stats)?;
            engine.shadow(&exposed, stats)?;
            // Motion is that of the pixels' first samples.
            let next = if exposure.is_first() { Next::of(subject, exposure.seconds, &staged, next)? } else { None };
            engine.shade(&exposed, next.as_ref(), film, stats).await?;
            progress.set(exposures.part());
            if exposures.need_film() {
                engine.develop(&exposed, film, stats).await?;
                exposures.measure(film);
            }
        }
        film.average(exposures.samples());
        frame.materials.check_textures()?;

        stats.count(&staged, exposures.samples(), film, engine);
        Ok(())
    }
}

impl Subject<'_> {
    /// Checks a frame before anything of the last one is touched.
    fn check(self, settings: &Settings) -> Result<(), Error> {
        let Self::Frame(frame) = self else { return Ok(()) };
        frame.check_lit_by(settings.lights(frame))?;
        settings.view(frame)?;
        match () {
            () if settings.shutter_seconds > 0.0 => Err(Error::ShutterOfFrame),
            () if settings.layers.has(Layer::Motion) => Err(Error::MotionOfFrame),
            () => Ok(()),
        }
    }

    /// The same subject some seconds later, or before, but not beyond the animation's start and end.
    pub(crate) fn after(self, seconds: f64) -> Self {
        let Self::Moment(scene, moment) = self else { return self };
        let duration = scene.duration_seconds();
        if duration > 0.0 { Self::Moment(scene, (scene.looped(moment) + seconds).clamp(0.0, duration)) } else { self }
    }
}

/// Poses a scene at its moment, in memory that is used again, or takes a frame as it is.
fn animate<'a>(
    engine: &mut dyn Engine,
    subject: Subject<'a>,
    settings: &Settings,
    posed: &'a mut Frame,
    stats: &mut Stats,
) -> Result<&'a Frame, Error> {
    match subject {
        Subject::Moment(scene, _) => {
            stats.time("animate", || engine.animate(subject, settings, posed))?;
            if let Some(lights) = &settings.lights {
                posed.lights.clone_from(lights);
            } else if posed.light_is_made {
                let light = scene.made_light(settings.chosen_camera(posed));
                posed.lights.clear();
                posed.lights.push(light);
            }
            check_lights(&posed.lights)?;
            Ok(posed)
        }
        Subject::Frame(frame) => {
            engine.animate(subject, settings, posed)?;
            let Frame { mesh, lights, cameras, .. } = posed;
            // An empty frame would allocate anew.
            let is_blank = mesh.triangles.is_empty() && lights.is_empty() && cameras.is_empty();
            if !is_blank {
                *posed = Frame::default();
            }
            Ok(frame)
        }
    }
}
