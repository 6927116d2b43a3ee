//! What can be chosen of a kd-tree.

use clap::Args;
use umbrage::rays::{KdBuilder, KdLayout, KdTraversal, KdTreeOptions};

use crate::failure::Failure;

#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct KdTreeFlags {
    /// How the kd-tree's planes are found: naive, resorting, presorted, nested or in-place (all exact), binned, streaming or
    /// adaptive [default: binned]
    #[arg(long, value_name = "NAME")]
    pub(crate) kd_builder: Option<KdBuilder>,
    /// How its nodes lie in memory: depth-first or subtrees [default: depth-first]
    #[arg(long, value_name = "NAME")]
    pub(crate) kd_layout: Option<KdLayout>,
    /// How rays go through it: stack, restart, push-down, or short-stack:N with a stack of N entries, 1 to 48
    /// [default: stack]
    #[arg(long, value_name = "NAME")]
    pub(crate) kd_traversal: Option<KdTraversal>,
    /// Build its nodes of fewer than N triangles when a ray first reaches them, 0 to 4096 [default: 0, all at once]
    #[arg(long, value_name = "N")]
    pub(crate) kd_lazy: Option<u32>,
}

impl KdTreeFlags {
    pub(crate) fn is_any_given(&self) -> bool {
        let Self { kd_builder, kd_layout, kd_traversal, kd_lazy } = self;
        kd_builder.is_some() || kd_layout.is_some() || kd_traversal.is_some() || kd_lazy.is_some()
    }

    pub(crate) fn options(&self) -> Result<KdTreeOptions, Failure> {
        let default = KdTreeOptions::FAST;
        let lazy_below = self.kd_lazy.unwrap_or(default.lazy_below);
        if lazy_below > KdTreeOptions::MOST_LAZY {
            let most = KdTreeOptions::MOST_LAZY;
            return Err(Failure::input(format!("--kd-lazy {lazy_below}"), format!("it is at most {most}")));
        }
        Ok(KdTreeOptions {
            builder: self.kd_builder.unwrap_or(default.builder),
            layout: self.kd_layout.unwrap_or(default.layout),
            traversal: self.kd_traversal.unwrap_or(default.traversal),
            lazy_below,
            ..default
        })
    }
}
