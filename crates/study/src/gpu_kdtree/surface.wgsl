// Stage `surface`: makes hits from rasterised triangles. t at the triangle's plane is the predicate's own, so if the
// rasteriser shows the triangle that the ray hits, all later results are as if the ray had been traced.

import package::dispatch::{Invocation, flat_index};
import package::exact::corners::{corner_bits};
import package::exact::double::{f64_is_above_zero, f64_is_finite};
import package::exact::expansion::{ExpansionTerms};
import package::exact::predicate::{ExactEdges, exact_from_corners, exact_sorted, exact_t};
import package::rays::read::{read_ray};
import package::rays::records::{HIT_WORDS, NO_TRIANGLE, RECORDS_COUNT, RECORD_LANES, RECORD_TAG, record_start};

struct KdSurface {
    width: u32,
    // Words of a row of `seen`.
    row_words: u32,
    unused: vec2<u32>,
}

@group(0) @binding(0) var<uniform> kd_surface: KdSurface;
@group(0) @binding(1) var<storage, read> records: array<u32>;
@group(0) @binding(2) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> positions: array<u32>;
// Each pixel's triangle plus one, row after row; zero for none.
@group(0) @binding(4) var<storage, read> seen: array<u32>;
@group(0) @binding(5) var<storage, read_write> hits: array<u32>;

@compute @workgroup_size(64)
fn surface(at: Invocation) {
    let number = flat_index(at, RECORD_LANES);
    if number >= records[RECORDS_COUNT] {
        return;
    }
    let word = record_start(number);
    let pixel = records[word + RECORD_TAG];
    var id = NO_TRIANGLE;
    if pixel != NO_TRIANGLE {
        id = seen[pixel / kd_surface.width * kd_surface.row_words + pixel % kd_surface.width] - 1u;
    }
    let base = number * HIT_WORDS;
    hits[base] = id;
    if id == NO_TRIANGLE {
        return;
    }
    let ray = read_ray(word);
    var edges: ExactEdges;
    edges.corners = exact_from_corners(exact_sorted(corner_bits(id)).corners);
    var terms: ExpansionTerms;
    let t = exact_t(&terms, ray, edges);
    // A triangle seen from its edge has no such point.
    if !f64_is_finite(t) || !f64_is_above_zero(t) {
        hits[base] = NO_TRIANGLE;
    }
    hits[base + 2u] = t.x;
    hits[base + 3u] = t.y;
}
