//! Every structure against the referee, in random scenes of the kinds that have fooled ray tracers.

use umbrage_verify::referee::{self, Trial, random_case};

#[test]
fn structures_say_what_the_referee_says() {
    let mut trial = Trial::new();
    let wrong: Vec<String> = (1..=SCENES)
        .flat_map(|seed| {
            let case = random_case(seed);
            let wrong = trial.disagreements(&case, &referee::truth(&case));
            wrong.into_iter().map(move |how| format!("--seed {seed}: {}: {how}", case.name))
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Scenes from the first on; `referee` asks about as many as there is time for.
const SCENES: u64 = 40;
