/// A colour scale for counts of work: blue, pink, yellow, as in Guntury and Narayanan 2010, Figure 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeatScale {
    top: u32,
}

impl HeatScale {
    /// Goes up to `top`, or a little more so that it ends at a round number.
    #[must_use]
    pub fn up_to(top: u32) -> Self {
        const PARTS: u32 = 5;
        let step = round_step(top.div_ceil(PARTS));
        Self { top: top.div_ceil(step).max(1).saturating_mul(step) }
    }

    /// A scale that at most one in a thousand of `counts` exceeds.
    #[must_use]
    pub fn of(counts: &[u32]) -> Self {
        Self::up_to(exceeded_by_few(counts))
    }

    /// The count that has the last colour; higher ones are white.
    #[must_use]
    pub fn top(self) -> u32 {
        self.top
    }

    /// The colour of a count, sRGB-encoded: black for zero, then dark blue to yellow.
    #[must_use]
    pub fn color(self, count: u32) -> [u8; 3] {
        const STOPS: [[u8; 3]; 5] = [[24, 16, 88], [48, 64, 224], [208, 56, 176], [255, 128, 112], [255, 240, 72]];
        match count {
            0 => [0; 3],
            count if count > self.top => [255; 3],
            count => {
                let along = f64::from(count) / f64::from(self.top) * (STOPS.len() - 1) as f64;
                let first = (along as usize).min(STOPS.len() - 2);
                let part = along - first as f64;
                let mix = |from: u8, to: u8| (f64::from(from) * (1.0 - part) + f64::from(to) * part).round() as u8;
                std::array::from_fn(|channel| mix(STOPS[first][channel], STOPS[first + 1][channel]))
            }
        }
    }

    /// Counts to write beside the colours, with at least `room` of the `length` for each.
    pub fn ticks(self, length: u32, room: u32) -> impl Iterator<Item = u32> {
        let step = round_step((u64::from(self.top) * u64::from(room) / u64::from(length.max(1))) as u32 + 1);
        (0..=self.top / step).map(move |tick| tick * step)
    }
}

/// The lowest count that at most one in a thousand exceeds.
fn exceeded_by_few(counts: &[u32]) -> u32 {
    let mut sorted = counts.to_vec();
    let rank = (sorted.len() - sorted.len() / 1000).saturating_sub(1);
    if sorted.is_empty() { 0 } else { *sorted.select_nth_unstable(rank).1 }
}

/// 1, 2 or 5 times a power of ten that is at least `least`.
fn round_step(least: u32) -> u32 {
    let powers = (0..10).map(|power| 10_u32.pow(power));
    let steps = powers.flat_map(|power| [1, 2, 5].into_iter().filter_map(move |step| power.checked_mul(step)));
    steps.into_iter().find(|&step| step >= least).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_end_at_round_numbers() {
        for (top, expected) in [(0, 1), (1, 1), (4, 4), (37, 40), (99, 100), (101, 150), (1234, 1500)] {
            assert_eq!(HeatScale::up_to(top).top, expected, "{top}");
        }
        for top in (0..3000).chain([u32::MAX]) {
            assert!(HeatScale::up_to(top).top >= top);
        }
    }

    #[test]
    fn colours_grow_lighter() {
        let scale = HeatScale::up_to(200);
        let lightness = |count: u32| {
            let [red, green, blue] = scale.color(count).map(f64::from);
            0.2126 * red + 0.7152 * green + 0.0722 * blue
        };
        assert!(lightness(0) < lightness(1) && lightness(200) < lightness(201));
        // Levels are rounded, so not every step is one up.
        assert!((1..=190).all(|count| lightness(count) < lightness(count + 10)));
        assert_eq!((scale.color(0), scale.color(201)), ([0; 3], [255; 3]));
    }

    #[test]
    fn ticks_have_room() {
        for (top, length, room) in [(1, 100, 20), (40, 1000, 30), (1500, 500, 60), (7, 3, 50)] {
            let ticks: Vec<u32> = HeatScale { top }.ticks(length, room).collect();
            assert!(ticks[0] == 0 && ticks.iter().all(|&tick| tick <= top));
            assert!(ticks.windows(2).all(|pair| (pair[1] - pair[0]) * length >= room * top), "{ticks:?}");
        }
    }

    #[test]
    fn few_outliers_are_left_out_of_the_scale() {
        let mut counts = vec![3; 1998];
        counts.extend([7, 900]);
        assert_eq!(exceeded_by_few(&counts), 3);
        counts.truncate(1500);
        counts.push(5);
        counts.push(6);
        assert_eq!(exceeded_by_few(&counts), 5);
        assert_eq!((exceeded_by_few(&[8]), exceeded_by_few(&[])), (8, 0));
    }
}
