#![allow(missing_docs)]
use std::sync::LazyLock;
static M: LazyLock<(u32, f32)> = LazyLock::new(|| (std::env::var("MUT").map_or(0, |m| m.parse().unwrap()), std::env::var("MUTF").map_or(0.0, |m| m.parse().unwrap())));
pub fn m(i: u32) -> f32 { if M.0 == i { M.1 } else { 1.0 } }
pub fn b(i: u32) -> bool { M.0 == i }
