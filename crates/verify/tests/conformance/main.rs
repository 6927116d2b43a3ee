//! The answers of every structure, for any kind, options, SIMD level and number of threads, are the oracle's.
//!
//! `structures` is their table; each line is tested with every group of `cases`, with `single_rays` and with `frames`.
//! Promises of structures that are made for a shot are in `specialised`, those of one kind of structure in the tests of
//! `umbrage-rays`. Questions without a camera are in `scan`, `lit` and `trace`.

mod cases;
mod check;
mod frames;
mod instances;
mod lit;
mod motion;
mod scan;
mod single_rays;
mod specialised;
mod structures;
mod trace;
