// Exclusive prefix sums of u32, in place: sums of pages, then a scan of those sums, then each page from its start.
// Reduce-then-scan needs no forward progress between workgroups, which WebGPU doesn't promise.

import package::dispatch::{Invocation, flat_group};
import package::primitives::workgroup_scan::{SCAN_WIDTH, scan_shared, scan_workgroup};

// Consecutive values of an invocation.
const SCAN_DEPTH: u32 = 8u;
const SCAN_PAGE: u32 = SCAN_WIDTH * SCAN_DEPTH;

struct ScanSize {
    // Number of values.
    count: u32,
}

@group(0) @binding(0) var<uniform> scan_size: ScanSize;
@group(0) @binding(1) var<storage, read_write> scan_values: array<u32>;
// The sum of each page, then its start; after the last page the sum of all.
@group(0) @binding(2) var<storage, read_write> scan_pages: array<u32>;

// Sums each page.
@compute @workgroup_size(256)
fn scan_reduce(at: Invocation) {
    let page = flat_group(at.group);
    var sum = 0u;
    for (var row = 0u; row < SCAN_DEPTH; row++) {
        let index = page * SCAN_PAGE + row * SCAN_WIDTH + at.lane;
        if index < scan_size.count {
            sum += scan_values[index];
        }
    }
    let before = scan_workgroup(at.lane, sum);
    if at.lane == SCAN_WIDTH - 1u && page * SCAN_PAGE < scan_size.count {
        scan_pages[page] = before + sum;
    }
}

// Turns the pages' sums into their starts: one workgroup, which takes SCAN_WIDTH pages at a time.
@compute @workgroup_size(256)
fn scan_starts(@builtin(local_invocation_index) lane: u32) {
    let pages = (scan_size.count + SCAN_PAGE - 1u) / SCAN_PAGE;
    var start = 0u;
    for (var first = 0u; first < pages; first += SCAN_WIDTH) {
        let page = first + lane;
        var sum = 0u;
        if page < pages {
            sum = scan_pages[page];
        }
        let before = scan_workgroup(lane, sum);
        if page < pages {
            scan_pages[page] = start + before;
        }
        start += scan_shared[SCAN_WIDTH - 1u];
        workgroupBarrier();
    }
    if lane == 0u {
        scan_pages[pages] = start;
    }
}

// Scans each page from its start on.
@compute @workgroup_size(256)
fn scan_spread(at: Invocation) {
    let page = flat_group(at.group);
    let first = page * SCAN_PAGE + at.lane * SCAN_DEPTH;
    var values: array<u32, SCAN_DEPTH>;
    var sum = 0u;
    for (var row = 0u; row < SCAN_DEPTH; row++) {
        if first + row < scan_size.count {
            values[row] = scan_values[first + row];
            sum += values[row];
        }
    }
    var before = scan_workgroup(at.lane, sum);
    if first < scan_size.count {
        before += scan_pages[page];
    }
    for (var row = 0u; row < SCAN_DEPTH; row++) {
        if first + row < scan_size.count {
            scan_values[first + row] = before;
            before += values[row];
        }
    }
}
