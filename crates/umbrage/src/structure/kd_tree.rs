use umbrage_rays::{
    BackgroundKdTree, HierarchyKdTree, KdMoved, KdRebuild, KdTree, KdTreeOptions, SimdLevel, TwoLevelKdTree,
};

use crate::Error;

/// Checks the options: a tree that outlives its frame can't be lazy, since triangles may have moved before a node is built.
/// Rays go through such trees one by one.
pub(super) fn check(options: KdTreeOptions, rebuild: KdRebuild) -> Result<(), Error> {
    options.check()?;
    match rebuild {
        KdRebuild::Whole | KdRebuild::Hierarchy => Ok(()),
        _ if options.lazy_below > 0 => Err(Error::KdOptionOfRebuild("kd-lazy", rebuild)),
        _ => Ok(()),
    }
}

/// A kd-tree that is updated as `rebuild` says.
pub(super) fn make(
    level: SimdLevel,
    options: KdTreeOptions,
    rebuild: KdRebuild,
) -> Result<Box<dyn umbrage_rays::Structure>, Error> {
    let two_level = |moved| -> Result<Box<dyn umbrage_rays::Structure>, Error> {
        let mut trees = TwoLevelKdTree::with_level(level, moved);
        trees.set_options(options)?;
        Ok(Box::new(trees))
    };
    match rebuild {
        KdRebuild::Whole => {
            let mut tree = KdTree::with_level(level);
            tree.set_options(options)?;
            Ok(Box::new(tree))
        }
        KdRebuild::Hierarchy => {
            let mut tree = HierarchyKdTree::with_level(level);
            tree.set_options(options)?;
            Ok(Box::new(tree))
        }
        KdRebuild::Background => {
            let mut tree = BackgroundKdTree::new(rayon::current_num_threads())?.at_level(level);
            tree.set_options(options)?;
            Ok(Box::new(tree))
        }
        KdRebuild::TwoLevel => two_level(KdMoved::Transform),
        KdRebuild::Groups => two_level(KdMoved::Rebuild),
        KdRebuild::Fuzzy => two_level(KdMoved::Enclose),
    }
}
