// Counts of an invocation so far, in the order of `Counters`.
var<private> counted_floats: u32;
var<private> counted_integers: u32;
var<private> counted_accesses: u32;
var<private> counted_shared: u32;
var<private> counted_read: u32;
var<private> counted_written: u32;

// Sums over all invocations: two words for each counter, the lower first.
@group(1) @binding(0) var<storage, read_write> counted_sums: array<atomic<u32>, 16>;

// Arithmetic of the busiest invocation in each group of 32 that run together.
var<workgroup> counted_most: array<atomic<u32>, 32>;

fn add_counted(counter: u32, amount: u32) {
    let before = atomicAdd(&counted_sums[2u * counter], amount);
    if before + amount < before {
        atomicAdd(&counted_sums[2u * counter + 1u], 1u);
    }
}

// Adds an invocation's counts to the sums; every invocation calls it at its end.
fn sum_counted(lane: u32) {
    add_counted(0u, 1u);
    add_counted(1u, counted_floats);
    add_counted(2u, counted_integers);
    add_counted(3u, counted_accesses);
    add_counted(4u, counted_shared);
    add_counted(5u, counted_read);
    add_counted(6u, counted_written);
    atomicMax(&counted_most[lane / 32u], counted_floats + counted_integers);
    workgroupBarrier();
    if lane % 32u == 0u {
        add_counted(7u, 32u * atomicLoad(&counted_most[lane / 32u]));
    }
}
