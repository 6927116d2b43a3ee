//! The rate of shown pictures.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Times at which the last pictures were shown, while pictures follow one another.
#[derive(Debug, Default)]
pub(crate) struct Pace {
    shown: VecDeque<Instant>,
}

impl Pace {
    /// Length of the averaging window; also the time for which the rate stays visible.
    pub(crate) const WINDOW: Duration = Duration::from_secs(1);
    /// Minimum number of pictures kept, even if they are older than the window.
    const FEWEST: usize = 4;

    pub(crate) fn add(&mut self, now: Instant) {
        self.shown.push_back(now);
        while self.shown.len() > Self::FEWEST
            && self.shown.front().is_some_and(|first| now.duration_since(*first) > Self::WINDOW)
        {
            self.shown.pop_front();
        }
    }

    /// Starts over, when a picture stays.
    pub(crate) fn clear(&mut self) {
        self.shown.clear();
    }

    /// Pictures per second, by the median interval; `None` where no picture has followed another lately.
    pub(crate) fn per_second(&self, now: Instant) -> Option<f64> {
        let pairs = self.shown.iter().zip(self.shown.iter().skip(1));
        let mut between: Vec<Duration> = pairs.map(|(one, next)| next.duration_since(*one)).collect();
        between.sort_unstable();
        let median = *between.get(between.len() / 2)?;
        let is_over = now.duration_since(*self.shown.back()?) > Self::WINDOW.max(2 * median);
        (!is_over && !median.is_zero()).then(|| 1.0 / median.as_secs_f64())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pace of pictures at these times in milliseconds.
    fn pace(start: Instant, shown: impl IntoIterator<Item = u64>) -> Pace {
        let mut pace = Pace::default();
        shown.into_iter().for_each(|milliseconds| pace.add(start + Duration::from_millis(milliseconds)));
        pace
    }

    #[test]
    fn it_is_the_median_of_the_last_second() {
        let start = Instant::now();
        let at = |milliseconds| start + Duration::from_millis(milliseconds);
        // A second of slow pictures, then pictures of 20 ms with a long one among them.
        let times =
            (0..10).map(|picture| 100 * picture).chain((0..60).map(|picture| 1000 + 20 * picture)).chain([2400]);
        let fast = pace(start, times);
        let said = fast.per_second(at(2400)).expect("a pace");
        assert!((said - 50.0).abs() < 1e-9, "{said}");
        assert_eq!(fast.per_second(at(3500)), None, "nothing was shown for more than a second");
    }

    #[test]
    fn slow_pictures_have_one_too() {
        let start = Instant::now();
        let at = |milliseconds| start + Duration::from_millis(milliseconds);
        assert_eq!(pace(start, [0]).per_second(at(1)), None, "one picture follows none");
        let mut slow = pace(start, [0, 4000, 8000, 12_000, 16_000]);
        assert_eq!(slow.per_second(at(18_000)), Some(0.25));
        slow.clear();
        assert_eq!(slow.per_second(at(18_000)), None);
    }
}
