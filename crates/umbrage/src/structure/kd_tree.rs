use umbrage_rays::{
    BackgroundKdTree, HierarchyKdTree, KdMoved, KdRebuild, KdTree, KdTreeOptions, SimdLevel, TwoLevelKdTree,
};

use crate::Error;

/// Whether there is such a kd-tree: nothing is left to be built where triangles may have moved, and rays go one by one then.
pub(super) fn check(options: KdTreeOptions, rebuild: KdRebuild) -> Result<(), Error> {
    options.check()?;
    match rebuild {
        KdRebuild::Whole | KdRebuild::Hierarchy => Ok(()),
        _ if options.lazy_below > 0 => Err(Error::KdOptionOfRebuild("kd-lazy", rebuild)),
        _ => Ok(()),
    }
}

/// A kd-tree that outlives its frame as `rebuild` says, or none that does.
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
