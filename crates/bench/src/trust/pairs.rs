//! Options of structures, two at a time.

use anyhow::Result;
use umbrage::{OptionValues, Structure, StructureOption};
use umbrage_verify::referee::{self, KeptRenderers, random_case};

use super::rays::number;
use super::{Effort, Finding};

/// Values of an option that its structure can have: all names, or a few numbers.
fn values(structure: &Structure, option: &StructureOption) -> Vec<String> {
    let words = |words: &[&str]| words.iter().map(ToString::to_string).collect();
    let numbers = |first: u32, last: u32| {
        let numbers = [first, first.saturating_add(2), 16, 64].map(|number| number.clamp(first, last).to_string());
        Vec::from(numbers)
    };
    let mut values = match &option.values {
        OptionValues::Names(names) => names().into_iter().map(|(name, _)| name.to_owned()).collect(),
        OptionValues::Whole(range) => numbers(*range.start(), *range.end()),
        OptionValues::WholeOrAuto(range) => [numbers(*range.start(), *range.end()), words(&["auto"])].concat(),
        OptionValues::Rectangle => words(&["auto", "-30:30:-20:20.5", "100:180:-180:-100"]),
        OptionValues::Positive => words(&["0.001", "0.25", "3", "40"]),
        OptionValues::Share => words(&["0", "0.3", "1"]),
        OptionValues::Switch => words(&["false", "true"]),
    };
    values.extend(structure.option(option.name));
    values.sort_unstable();
    values.dedup();
    values.retain(|value| structure.clone().set_option(option.name, value).is_ok());
    values
}

/// Every structure with every pair of values of two of its options, the others being the defaults; `None` for a pair that
/// can't be set.
fn pairs() -> Vec<Option<Structure>> {
    let mut pairs = Vec::new();
    for structure in umbrage_papers::structures().iter() {
        let options: Vec<_> = structure.options().map(|option| (option.name, values(structure, option))).collect();
        for (at, (later, later_values)) in options.iter().enumerate() {
            for (earlier, value) in
                options[..at].iter().flat_map(|(name, values)| values.iter().map(move |value| (name, value)))
            {
                pairs.extend(later_values.iter().map(|later_value| {
                    let mut structure = structure.clone();
                    structure.set_option(earlier, value).ok()?;
                    structure.set_option(later, later_value).ok()?;
                    Some(structure)
                }));
            }
        }
    }
    pairs
}

pub(super) fn of_options(effort: &Effort) -> Result<Finding> {
    const CASES: usize = 16;
    let (mut random, mut kept) = (effort.random(), KeptRenderers::new());
    let mut cases = Vec::with_capacity(CASES);
    for case in (effort.seed..).map(random_case) {
        let (truth, refused) = (referee::truth(&case), kept.refused);
        kept.disagreements(&Structure::default(), &case, &truth);
        // A camera or a light that isn't finite says nothing of options.
        if kept.refused == refused {
            cases.push((case, truth));
        }
        if cases.len() == CASES {
            break;
        }
    }
    kept.answers = 0;
    let mut pairs = pairs();
    let all = pairs.len();
    let asked = (effort.of(all as u64) as usize).clamp(40, all);
    // In any order, so that structures take turns.
    (0..asked).for_each(|at| pairs.swap(at, at + random.below(all - at)));
    let (mut refused, mut wrong) = (0, Vec::new());
    for (at, structure) in pairs[..asked].iter().enumerate() {
        let before = kept.refused;
        for (case, truth) in [at, at + 5].map(|at| &cases[at % CASES]) {
            wrong.extend(structure.iter().flat_map(|structure| kept.disagreements(structure, case, truth)));
        }
        refused += u64::from(structure.is_none() || kept.refused > before);
    }
    let first = wrong.first().map_or_else(String::new, |first| format!(" The first: {first}."));
    let text = format!(
        "{} disagreements with the referee in {} answers: {} of {} pairs of values of two options of a structure, all names and \
         a few numbers of each, in two of {CASES} scenes each, by every instruction set. {} pairs exclude each other and are \
         refused.{first}",
        wrong.len(),
        number(kept.answers),
        number(asked as u64),
        number(all as u64),
        number(refused),
    );
    Ok(Finding::new(wrong.is_empty(), text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_have_all_names() {
        let texts: Vec<_> = pairs().iter().flatten().map(ToString::to_string).collect();
        for (a, b) in [("layout=subtrees", "packet=4"), ("light-map=spherical", "sorting-tile=8")] {
            assert!(texts.iter().any(|text| text.contains(a) && text.contains(b)), "{a} and {b}");
        }
        assert!(texts.contains(&"grid:density=0.25,packet=8".to_owned()));
        assert!(pairs().contains(&None), "tiles of 64 pixels, eight a side");
    }
}
