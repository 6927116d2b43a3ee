// Writes rays and shadow questions to the buffer `records`, which a stage declares.

import package::dispatch::{groups_of};
import package::exact::double::{F64};
import package::exact::vector::{F64Vector};
import package::rays::records::{RECORDS_COUNT, RECORDS_GROUPS, RECORDS_PACKETS, RECORD_LANES};
import stage::{records};

// Writes the number of records, and the workgroups for them and for packets of `packet` records.
fn put_header(count: u32, packet: u32) {
    let groups = groups_of((count + RECORD_LANES - 1u) / RECORD_LANES);
    let packets = groups_of((count + packet - 1u) / packet);
    records[RECORDS_COUNT] = count;
    for (var axis = 0u; axis < 3u; axis++) {
        records[RECORDS_GROUPS + axis] = groups[axis];
        records[RECORDS_PACKETS + axis] = packets[axis];
    }
}

fn put_number(word: u32, number: F64) {
    records[word] = number.x;
    records[word + 1u] = number.y;
}

fn put_vector(word: u32, vector: F64Vector) {
    put_number(word, vector.x);
    put_number(word + 2u, vector.y);
    put_number(word + 4u, vector.z);
}
