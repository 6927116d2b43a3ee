use umbrage_rays::{
    Bvh, DirectGrids, KdTree, ListedGrids, SimdLevel, Structure as AnyStructure, UniformGrid, UniformOptions,
};

use crate::{Error, Structure};

/// An empty structure of the kind that was chosen. `sends_rays_onward` where single rays go through it as well.
pub(super) fn make(
    structure: Structure,
    level: SimdLevel,
    sends_rays_onward: bool,
) -> Result<Box<dyn AnyStructure>, Error> {
    Ok(match structure {
        Structure::Perspective => Box::new(DirectGrids::with_level(level)),
        Structure::Listed { camera, light } => Box::new(ListedGrids::with_options(level, camera, light)),
        Structure::Grid(mut options) => {
            if sends_rays_onward {
                // Rays that come one at a time need them where triangles crowd: a twelfth of the time for `demo:glass`.
                options.nested_above = options.nested_above.or(UniformOptions::NESTED.nested_above);
            }
            let mut grid = UniformGrid::with_level(level);
            grid.set_options(options)?;
            Box::new(grid)
        }
        Structure::KdTree(options) => {
            let mut tree = KdTree::with_level(level);
            tree.set_options(options)?;
            Box::new(tree)
        }
        Structure::Bvh => Box::new(Bvh::default()),
    })
}
