//! Every structure against the referee, in random scenes of the kinds that have fooled ray tracers.

use umbrage_verify::referee::{self, DistanceTrial, KeptRenderers, Trial, random_case, random_points, random_sequence};

#[test]
fn structures_say_what_the_referee_says() {
    let mut trial = Trial::new();
    let wrong: Vec<String> = (1..=FIRST_SCENES)
        .chain(TELLING_SCENES)
        .flat_map(|seed| {
            let case = random_case(seed);
            let wrong = trial.disagreements(&case, &referee::truth(&case));
            wrong.into_iter().map(move |how| format!("--seed {seed}: {}: {how}", case.name))
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The program `referee` takes as many as its time allows.
const FIRST_SCENES: u64 = 20;

/// Those of the first 1,250 in which structures disagree if the predicate takes the sides of planes from f64 alone:
/// triangles that reach far, slivers, scales from 10⁻³⁷ to 10²¹.
const TELLING_SCENES: [u64; 11] = [10, 90, 259, 424, 517, 717, 841, 1128, 1185, 1217, 1248];

#[test]
fn kept_renderers_say_what_the_referee_says() {
    let mut kept = KeptRenderers::new();
    let wrong: Vec<String> = (1..=12)
        .flat_map(|seed| random_sequence(seed).into_iter().enumerate().map(move |frame| (seed, frame)))
        .flat_map(|(seed, (number, (structure, case)))| {
            let wrong = kept.disagreements(&structure, &case, &referee::truth(&case));
            wrong.into_iter().map(move |how| format!("--seed {seed}, frame {number}: {}: {how}", case.name))
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(kept.refused < kept.answers / 100, "{} frames were refused", kept.refused);
}

#[test]
fn distances_are_those_of_the_referee() {
    let mut trial = DistanceTrial::new();
    let wrong: Vec<String> = (1..=120)
        .flat_map(|seed| {
            let case = random_case(seed);
            let points = random_points(seed, &case);
            let wrong = trial.disagreements(&case, &points, &referee::distances(case.mesh.triangles(), &points));
            wrong.into_iter().map(move |how| format!("--seed {seed}: {}: {how}", case.name))
        })
        .collect();
    assert!(wrong.is_empty(), "{} disagreements\n{}", wrong.len(), wrong[..wrong.len().min(20)].join("\n"));
}
