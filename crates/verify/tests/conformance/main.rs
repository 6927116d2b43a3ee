//! What every structure has to say, whatever its kind, options, SIMD level and number of threads: what the oracle says.
//!
//! `structures` is the table of them, a line each; each line is tested with every group of `cases` and with `single_rays`, and
//! as `frames` says. What only structures promise that are made for a shot is in `specialised`, and what only one kind of
//! structure does in the tests of `umbrage-rays`. The questions without a camera are in `scan`, `lit` and `trace`.

mod cases;
mod check;
mod frames;
mod lit;
mod scan;
mod single_rays;
mod specialised;
mod structures;
mod trace;
