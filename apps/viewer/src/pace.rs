//! How many pictures a second are shown.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// When the last pictures were shown, while one follows the other.
#[derive(Debug, Default)]
pub(crate) struct Pace {
    shown: VecDeque<Instant>,
}

impl Pace {
    /// How far back it looks, and how long it goes on being shown.
    pub(crate) const WINDOW: Duration = Duration::from_secs(1);
    /// The fewest pictures that are remembered, however long ago they were.
    const FEWEST: usize = 4;

    pub(crate) fn add(&mut self, now: Instant) {
        self.shown.push_back(now);
        while self.shown.len() > Self::FEWEST
            && self.shown.front().is_some_and(|first| now.duration_since(*first) > Self::WINDOW)
        {
            self.shown.pop_front();
        }
    }

    /// Starts over: what was shown is a picture that stays.
    pub(crate) fn clear(&mut self) {
        self.shown.clear();
    }

    /// Pictures a second, by the median of the times between them; `None` where none has followed another lately.
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

    /// Pictures at so many milliseconds.
    fn pace(start: Instant, shown: impl IntoIterator<Item = u64>) -> Pace {
        let mut pace = Pace::default();
        shown.into_iter().for_each(|milliseconds| pace.add(start + Duration::from_millis(milliseconds)));
        pace
    }

    #[test]
    fn it_is_the_median_of_the_last_second() {
        let start = Instant::now();
        let at = |milliseconds| start + Duration::from_millis(milliseconds);
        // One that took long among those of 20 ms, after a second of slow ones.
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
