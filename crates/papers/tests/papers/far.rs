//! Scenes that one far vertex stretches, or that one triangle covers, through the papers' structures.

use umbrage_papers::UniformGrid;

use crate::support::far::check_answers;

#[test]
fn answers_are_the_predicates() {
    check_answers(UniformGrid::default());
}
