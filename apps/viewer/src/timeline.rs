//! The shown time of the animation, and its progress.

/// A position in an animation.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Timeline {
    pub(crate) seconds: f64,
    /// Length of the animation in seconds; zero for a still scene.
    duration: f64,
    pub(crate) is_playing: bool,
    /// Seconds of the animation per second.
    pub(crate) speed: f64,
    /// Whether it starts again after its end.
    pub(crate) loops: bool,
}

impl Default for Timeline {
    fn default() -> Self {
        Self { seconds: 0.0, duration: 0.0, is_playing: false, speed: 1.0, loops: true }
    }
}

impl Timeline {
    /// Frames per second of steps and recordings.
    pub(crate) const FPS: u32 = 24;

    /// Sets the length. A later time starts over, and a still scene pauses.
    pub(crate) fn set_duration(&mut self, duration: f64) {
        self.duration = duration;
        self.seconds = if self.seconds <= duration { self.seconds } else { 0.0 };
        self.is_playing &= duration > 0.0;
    }

    pub(crate) fn duration(&self) -> f64 {
        self.duration
    }

    /// Whether there is anything to play.
    pub(crate) fn moves(&self) -> bool {
        self.duration > 0.0
    }

    /// Starts or pauses; at the end of an animation that doesn't loop, starts from the beginning.
    pub(crate) fn toggle(&mut self) {
        self.is_playing = !self.is_playing && self.moves();
        if self.is_playing && !self.loops && self.seconds >= self.duration {
            self.seconds = 0.0;
        }
    }

    /// Lets time pass.
    pub(crate) fn advance(&mut self, passed_seconds: f64) {
        if self.is_playing {
            self.go(passed_seconds * self.speed);
        }
    }

    /// Moves by some frames, forwards or back, and pauses.
    pub(crate) fn step(&mut self, frames: i32) {
        self.is_playing = false;
        let fps = f64::from(Self::FPS);
        // Steps between whole frames, even if paused between two.
        let frame = (self.seconds * fps).round() + f64::from(frames);
        self.go(frame / fps - self.seconds);
    }

    fn go(&mut self, seconds: f64) {
        if !self.moves() {
            return;
        }
        let next = self.seconds + seconds;
        if self.loops {
            self.seconds = next.rem_euclid(self.duration);
        } else {
            self.seconds = next.clamp(0.0, self.duration);
            let is_at_end = if self.speed < 0.0 { next <= 0.0 } else { next >= self.duration };
            self.is_playing &= !is_at_end;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn playing(loops: bool) -> Timeline {
        let mut timeline = Timeline { loops, ..Timeline::default() };
        timeline.set_duration(2.0);
        timeline.toggle();
        timeline
    }

    #[test]
    fn time_comes_round() {
        let mut timeline = playing(true);
        timeline.advance(1.5);
        timeline.advance(1.0);
        assert!((timeline.seconds - 0.5).abs() < 1e-12 && timeline.is_playing);
        timeline.speed = -2.0;
        timeline.advance(0.5);
        assert!((timeline.seconds - 1.5).abs() < 1e-12);
    }

    #[test]
    fn or_it_stops_at_the_end() {
        let mut timeline = playing(false);
        timeline.advance(2.5);
        assert!(timeline.seconds == 2.0 && !timeline.is_playing);
        timeline.toggle();
        assert!(timeline.seconds == 0.0 && timeline.is_playing);
    }

    #[test]
    fn steps_are_whole_frames() {
        let mut timeline = playing(true);
        timeline.advance(0.99 / 24.0);
        timeline.step(1);
        assert!((timeline.seconds - 2.0 / 24.0).abs() < 1e-12 && !timeline.is_playing);
        timeline.step(-3);
        assert!((timeline.seconds - (2.0 - 1.0 / 24.0)).abs() < 1e-12, "{}", timeline.seconds);
    }

    #[test]
    fn nothing_plays_where_nothing_moves() {
        let mut timeline = Timeline::default();
        timeline.toggle();
        timeline.advance(1.0);
        timeline.step(3);
        assert_eq!(timeline, Timeline::default());
        let mut longer = playing(true);
        longer.advance(1.5);
        longer.set_duration(1.0);
        assert!(longer.seconds == 0.0 && longer.is_playing);
    }
}
