//! Nothing but a list of features, in `Cargo.toml`.
#![forbid(unsafe_code)]
