// The points of triangles that pixels show, to the last bit.

import package::exact::corners::{corner_bits};
import package::exact::expansion::{ExpansionTerms};
import package::exact::predicate::{exact_edges, exact_t};
import package::exact::shadow::{ExactPoint, exact_point};
import package::point_view::{ray_of_slot};

// The point of triangle `id` that a slot's pixel shows.
fn seen_point(slot: u32, id: u32) -> ExactPoint {
    let ray = ray_of_slot(slot);
    var terms: ExpansionTerms;
    let edges = exact_edges(&terms, ray, corner_bits(id));
    return exact_point(ray, exact_t(&terms, ray, edges));
}
