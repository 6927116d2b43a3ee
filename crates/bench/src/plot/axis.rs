/// How values are spread along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scale {
    /// With zero on the axis.
    Linear,
    /// By orders of magnitude; all values are above zero.
    Logarithmic,
    /// The same, with ticks at powers of two.
    Doubling,
}

/// What a value may be beyond the last tick, in steps between ticks: less than one can see.
const SLACK: f64 = 1e-6;

/// An axis from one round number to another.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    scale: Scale,
    first: f64,
    last: f64,
    ticks: Vec<f64>,
}

impl Axis {
    /// An axis that `values` fit on; those that a logarithmic one can't show don't count.
    pub(super) fn new(scale: Scale, values: impl Iterator<Item = f64>) -> Self {
        let shown = values.filter(|value| value.is_finite() && (scale == Scale::Linear || *value > 0.0));
        let (low, high) =
            shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        let (low, high) = if low <= high { (low, high) } else { (1.0, 10.0) };
        match scale {
            Scale::Linear if low == 0.0 && high == 0.0 => Self::linear(0.0, 1.0),
            Scale::Linear => Self::linear(low.min(0.0), high.max(0.0)),
            Scale::Logarithmic => Self::logarithmic(low, high),
            Scale::Doubling => Self::doubling(low, high),
        }
    }

    fn linear(low: f64, high: f64) -> Self {
        const MOST_STEPS: f64 = 8.0;
        let size = high - low;
        let power = 10.0_f64.powf((size / MOST_STEPS).log10().floor());
        let fits = |factor: &f64| size / (factor * power) <= MOST_STEPS;
        let step = power * [1.0, 2.0, 5.0].into_iter().find(fits).unwrap_or(10.0);
        let (first, last) = ((low / step + SLACK).floor(), (high / step - SLACK).ceil());
        let ticks: Vec<f64> = (first as i64..=last as i64).map(|tick| tick as f64 * step).collect();
        Self { scale: Scale::Linear, first: first * step, last: last * step, ticks }
    }

    fn doubling(low: f64, high: f64) -> Self {
        let (first, last) = ((low.log2() + SLACK).floor() as i32, (high.log2() - SLACK).ceil() as i32);
        let ticks: Vec<f64> = (first..=last.max(first + 1)).map(|power| 2.0_f64.powi(power)).collect();
        Self { scale: Scale::Doubling, first: ticks[0], last: ticks[ticks.len() - 1], ticks }
    }

    /// Ticks are powers of ten; where there are few of them, also two and five times each.
    fn logarithmic(low: f64, high: f64) -> Self {
        let decades = low.log10().floor() as i32..=high.log10().ceil() as i32;
        let factors: &[f64] = if high / low < 500.0 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let round: Vec<f64> =
            decades.flat_map(|power| factors.iter().map(move |factor| factor * 10.0_f64.powi(power))).collect();
        let first = round.iter().rposition(|&tick| tick <= low * (1.0 + SLACK)).unwrap_or(0);
        let last =
            round.iter().position(|&tick| tick >= high * (1.0 - SLACK)).unwrap_or(round.len() - 1).max(first + 1);
        let ticks = round[first..=last.min(round.len() - 1)].to_vec();
        Self { scale: Scale::Logarithmic, first: ticks[0], last: ticks[ticks.len() - 1], ticks }
    }

    /// Where a value is: 0 for the axis' first, 1 for its last; `None` if it can't be shown.
    pub(super) fn position(&self, value: f64) -> Option<f64> {
        let position = match self.scale {
            Scale::Linear => (value - self.first) / (self.last - self.first),
            Scale::Logarithmic | Scale::Doubling => (value / self.first).ln() / (self.last / self.first).ln(),
        };
        position.is_finite().then_some(position)
    }

    /// Positions and labels.
    pub(super) fn ticks(&self) -> impl Iterator<Item = (f64, String)> {
        self.ticks.iter().filter_map(|&tick| Some((self.position(tick)?, label(tick))))
    }
}

/// A round number in few characters: thousands and millions are `K` and `M`.
fn label(value: f64) -> String {
    let (scaled, unit) = match value.abs() {
        large if large >= 0.9995e6 => (value / 1e6, "M"),
        large if large >= 0.9995e4 => (value / 1e3, "K"),
        _ => (value, ""),
    };
    let rounded = format!("{scaled:.6}");
    let short = rounded.trim_end_matches('0').trim_end_matches('.');
    format!("{short}{unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<String> {
        axis.ticks().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round_and_hold_all_values() {
        let axis = Axis::new(Scale::Linear, [3.0, 17.0].into_iter());
        assert_eq!(labels(&axis), ["0", "5", "10", "15", "20"]);
        assert_eq!(axis.position(5.0), Some(0.25));
        let axis = Axis::new(Scale::Linear, [-0.13, 0.3].into_iter());
        assert_eq!(labels(&axis)[..2], ["-0.2", "-0.1"]);
        let axis = Axis::new(Scale::Logarithmic, [1e4, 1e7].into_iter());
        assert_eq!(labels(&axis), ["10K", "100K", "1M", "10M"]);
        assert!((axis.position(1e6).unwrap() - 2.0 / 3.0).abs() < 1e-12);
        let axis = Axis::new(Scale::Logarithmic, [3.0, 45.0].into_iter());
        assert_eq!(labels(&axis), ["2", "5", "10", "20", "50"]);
        let axis = Axis::new(Scale::Doubling, [0.25, 3.0].into_iter());
        assert_eq!(labels(&axis), ["0.25", "0.5", "1", "2", "4"]);
        let axis = Axis::new(Scale::Linear, [100.0 + 1e-9].into_iter());
        assert_eq!(labels(&axis).last().map(String::as_str), Some("100"));
    }

    #[test]
    fn odd_values_still_make_an_axis() {
        for values in [vec![], vec![f64::NAN], vec![0.0], vec![5.0], vec![-1.0], vec![1e-9, 1e9], vec![1.0; 3]] {
            for scale in [Scale::Linear, Scale::Logarithmic, Scale::Doubling] {
                let axis = Axis::new(scale, values.iter().copied());
                assert!(axis.ticks().count() >= 2, "{values:?} {axis:?}");
                assert!(
                    axis.ticks().all(|(position, _)| (-1e-9..=1.0 + 1e-9).contains(&position)),
                    "{values:?} {axis:?}"
                );
            }
        }
        assert_eq!(Axis::new(Scale::Logarithmic, [1.0, 10.0].into_iter()).position(0.0), None);
    }
}
