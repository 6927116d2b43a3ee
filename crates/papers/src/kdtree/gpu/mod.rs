//! Rays of any kind through a kd-tree: Horn et al., *Interactive k-D Tree GPU Raytracing* (2007).
//!
//! The tree is built on the CPU and uploaded (`tree`, as `words`). The tracer of [`rays`](umbrage_gpu::rays) takes rays
//! through it by `stack`, `trail` (restart, push-down, short stack) or `packet`. So answers are those of
//! [`KdTree`](crate::KdTree), bit for bit.
//!
//! `sight` answers for a whole image: `rays` makes the camera's rays, `seen` keeps their hits, and for each light `ask`
//! makes shadow questions, whose answers are the bits of `lit`. `fit` decides whether there was room for all of it.
//! `finder` implements the engine's [`Finder`](umbrage::gpu::Finder) with these.
//!
//! **Culling a cell.** Of the terms of a plane's t, as those of a [box](umbrage_gpu::rays), the factors are below 2·|i|. So
//! the error is below (6.5u + blur)·|i|; the doubt on an axis is (12u + 2 blur)·|i|, which leaves room for its own
//! roundings. A child gets the interval of t in which the ray may be in its cell, grown by the doubt, and is culled only if
//! that is empty. A ray that is parallel to a plane is on one side, or less than 12u + 2 blur beside it and then on both.

mod finder;
mod options;
mod sight;
mod tree;
mod words;

pub use options::KdTracerOptions;
pub use sight::KdSight;
pub use tree::KdNodes;

/// Every module's path and text; they import those of `umbrage-gpu` as well.
const MODULES: &[(&str, &str)] = &[
    ("kdtree::ask", include_str!("ask.wgsl")),
    ("kdtree::fit", include_str!("fit.wgsl")),
    ("kdtree::levels", include_str!("levels.wgsl")),
    ("kdtree::node", include_str!("node.wgsl")),
    ("kdtree::packet", include_str!("packet.wgsl")),
    ("kdtree::rays", include_str!("rays.wgsl")),
    ("kdtree::seen", include_str!("seen.wgsl")),
    ("kdtree::stack", include_str!("stack.wgsl")),
    ("kdtree::trail", include_str!("trail.wgsl")),
];

/// A stage's whole text.
#[cfg(test)]
fn link(path: &str) -> String {
    umbrage_gpu::internals::link_with(MODULES, path)
}

/// Checks a linked shader.
///
/// # Panics
/// If it isn't valid.
#[cfg(test)]
pub(crate) fn validate(path: &str, text: &str) {
    let module = crate::layout::module(text);
    let mut validator =
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
    validator.validate(&module).unwrap_or_else(|error| panic!("{path}: {}", error.emit_to_string(text)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stage_links_and_is_valid_wgsl() {
        let stages: Vec<_> = MODULES.iter().filter(|(_, text)| text.contains("@compute")).collect();
        assert_eq!(stages.len(), 7);
        for (path, _) in stages {
            validate(path, &link(path));
        }
    }
}
