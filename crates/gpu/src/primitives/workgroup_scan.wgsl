// Prefix sums over the invocations of a workgroup.

// Invocations of a workgroup.
const SCAN_WIDTH: u32 = 256u;

// After a scan, the sums up to and including each invocation.
var<workgroup> scan_shared: array<u32, SCAN_WIDTH>;

// The sum of the values of earlier invocations (Hillis and Steele).
fn scan_workgroup(lane: u32, value: u32) -> u32 {
    scan_shared[lane] = value;
    workgroupBarrier();
    for (var step = 1u; step < SCAN_WIDTH; step *= 2u) {
        var sum = scan_shared[lane];
        if lane >= step {
            sum += scan_shared[lane - step];
        }
        workgroupBarrier();
        scan_shared[lane] = sum;
        workgroupBarrier();
    }
    return scan_shared[lane] - value;
}
