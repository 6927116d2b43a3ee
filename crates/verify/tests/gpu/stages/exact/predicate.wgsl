// The predicate's functions, each on a list of cases.

import package::exact::camera::{ExactView, exact_pixel_ray};
import package::exact::expansion::{ExpansionTerms};
import package::exact::predicate::{
    CornerBits, ExactEdges, ExactRay, exact_barycentric, exact_edges, exact_is_front, exact_is_front_along,
    exact_is_front_from, exact_t,
};
import package::exact::shadow::{exact_blocked_by, exact_point, exact_shadow};
import package::exact::vector::{F64Vector};

const CASE_WORDS = 32u;
const ANSWER_WORDS = 16u;

fn case_vector(word: u32) -> F64Vector {
    return F64Vector(case_pair(word), case_pair(word + 2u), case_pair(word + 4u));
}

fn case_corners(word: u32) -> CornerBits {
    return CornerBits(case_triple(word), case_triple(word + 3u), case_triple(word + 6u));
}

fn answer_vector(word: u32, vector: F64Vector) {
    answer_number(word, vector[0]);
    answer_number(word + 2u, vector[1]);
    answer_number(word + 4u, vector[2]);
}

@compute @workgroup_size(64)
fn crossings(at: Invocation) {
    let start = case_number_of(at) * CASE_WORDS;
    if start >= arrayLength(&inputs) {
        return;
    }
    let ray = ExactRay(case_vector(start), case_vector(start + 6u));
    let corners = case_corners(start + 12u);
    let answer = start / CASE_WORDS * ANSWER_WORDS;
    var terms: ExpansionTerms;
    let edges = exact_edges(&terms, ray, corners);
    outputs[answer] = u32(edges.side != 0);
    if edges.side != 0 {
        outputs[answer + 1u] = u32(exact_is_front(edges));
        answer_number(answer + 2u, exact_t(&terms, ray, edges));
        let barycentric = exact_barycentric(edges);
        outputs[answer + 4u] = barycentric.x;
        outputs[answer + 5u] = barycentric.y;
    }
}

@compute @workgroup_size(64)
fn fronts(at: Invocation) {
    let start = case_number_of(at) * CASE_WORDS;
    if start >= arrayLength(&inputs) {
        return;
    }
    let corners = case_corners(start + 12u);
    let answer = start / CASE_WORDS * ANSWER_WORDS;
    var terms: ExpansionTerms;
    outputs[answer] = u32(exact_is_front_from(&terms, case_vector(start), corners));
    outputs[answer + 1u] = u32(exact_is_front_along(&terms, case_vector(start + 6u), corners));
}

@compute @workgroup_size(64)
fn shadows(at: Invocation) {
    let start = case_number_of(at) * CASE_WORDS;
    if start >= arrayLength(&inputs) {
        return;
    }
    let ray = ExactRay(case_vector(start), case_vector(start + 6u));
    let point = exact_point(ray, case_pair(start + 22u));
    let shadow = exact_shadow(inputs[start + 24u] != 0u, case_triple(start + 25u), point);
    let answer = start / CASE_WORDS * ANSWER_WORDS;
    var terms: ExpansionTerms;
    var edges: ExactEdges;
    let blocked = exact_blocked_by(&terms, shadow, case_corners(start + 12u), &edges);
    outputs[answer] = u32(blocked);
    answer_vector(answer + 4u, point.position);
    answer_number(answer + 10u, point.error);
    if blocked {
        let barycentric = exact_barycentric(edges);
        outputs[answer + 1u] = barycentric.x;
        outputs[answer + 2u] = barycentric.y;
    }
}

@compute @workgroup_size(64)
fn rays(at: Invocation) {
    let start = case_number_of(at) * CASE_WORDS;
    if start >= arrayLength(&inputs) {
        return;
    }
    let view = ExactView(
        case_triple(start), inputs[start + 3u], case_triple(start + 4u), inputs[start + 7u],
        case_triple(start + 8u), inputs[start + 11u], case_triple(start + 12u), inputs[start + 15u],
    );
    let ray = exact_pixel_ray(
        view, inputs[start + 16u], inputs[start + 17u], case_pair(start + 18u), case_pair(start + 20u),
    );
    let answer = start / CASE_WORDS * ANSWER_WORDS;
    answer_vector(answer, ray.origin);
    answer_vector(answer + 6u, ray.direction);
}
