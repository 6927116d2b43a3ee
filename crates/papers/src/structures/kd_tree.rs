use crate::{
    BackgroundKdTree, Clipping, HierarchyKdTree, ImpossibleKdTreeOptions, KdBuilder, KdLayout, KdMailbox, KdMoved,
    KdPacketWidth, KdRebuild, KdTraversal, KdTree, KdTreeOptions, SahCosts, TwoLevelKdTree,
};
use umbrage::rays::{self, Choice, SimdLevel};
use umbrage::{Error, GpuStructure, KindOption, OptionValues, StructureKind};

use super::{choice, option, parsed};

/// One kd-tree for all rays, and the way it is updated when triangles have moved.
#[derive(Clone, Debug, PartialEq)]
pub struct KdTrees {
    /// Planes, layout and traversal.
    pub options: KdTreeOptions,
    /// The treatment of moved triangles.
    pub rebuild: KdRebuild,
}

/// The kd-tree that is built fastest.
impl Default for KdTrees {
    fn default() -> Self {
        Self { options: KdTreeOptions::FAST, rebuild: KdRebuild::Whole }
    }
}

impl StructureKind for KdTrees {
    const NAME: &'static str = "kdtree";
    const ABOUT: &'static str = "a kd-tree for all rays";
    const PAPER: Option<&'static str> = Some(
        "Horn, Sugerman, Houston and Hanrahan, Interactive k-D Tree GPU Raytracing, 2007; Rahikainen, thesis, 2013",
    );
    const OPTIONS: &'static [KindOption<Self>] = &[
        option!("builder", gpu; "How planes are found"; OptionValues::Names(KdBuilder::names);
            |tree| tree.options.builder;
            |tree, value| tree.options.builder = choice(value)?),
        option!("clipping", gpu; "The part that is kept of a triangle across a plane"; OptionValues::Names(Clipping::names);
            |tree| tree.options.clipping;
            |tree, value| tree.options.clipping = choice(value)?),
        option!("step-cost", gpu; "Cost of a step to a child in the surface area heuristic"; OptionValues::Positive;
            |tree| tree.options.costs.step;
            |tree, value| tree.options.costs.step = parsed(value)?),
        option!("test-cost", gpu; "Cost of the test of a triangle"; OptionValues::Positive;
            |tree| tree.options.costs.test;
            |tree, value| tree.options.costs.test = parsed(value)?),
        option!("empty-cost", gpu; "Factor for the costs of a plane that cuts off empty space"; OptionValues::Share;
            |tree| tree.options.costs.empty;
            |tree, value| tree.options.costs.empty = parsed(value)?),
        option!("charge-twice", gpu;
            "Charge for two tests of a triangle on both sides of a plane, although rays remember the first";
            OptionValues::Switch;
            |tree| !tree.options.costs.mailbox;
            |tree, value| tree.options.costs.mailbox = value != "true"),
        option!("failures", gpu; "How many planes on the way to a leaf may cost more than they save";
            OptionValues::Whole(0..=SahCosts::MOST_FAILURES);
            |tree| tree.options.costs.failures;
            |tree, value| tree.options.costs.failures = parsed(value)?),
        option!("layout", gpu; "How nodes lie in memory"; OptionValues::Names(KdLayout::names);
            |tree| tree.options.layout;
            |tree, value| tree.options.layout = choice(value)?),
        option!("traversal", gpu; "How rays are led to leaves, alone and in packets"; OptionValues::Names(KdTraversal::names);
            |tree| tree.options.traversal;
            |tree, value| tree.options.traversal = value.parse().map_err(|unknown: rays::UnknownChoice| {
                format!("choose one of {}", unknown.known)
            })?),
        option!("packet", gpu; "Camera and shadow rays of a packet"; OptionValues::Names(KdPacketWidth::names);
            |tree| tree.options.packets.width;
            |tree, value| tree.options.packets.width = choice(value)?),
        option!("mailbox"; "Which triangles packets remember to have tested"; OptionValues::Names(KdMailbox::names);
            |tree| tree.options.packets.mailbox;
            |tree, value| tree.options.packets.mailbox = choice(value)?),
        option!("rebuild"; "How the tree is updated when triangles are elsewhere in the next frame";
            OptionValues::Names(KdRebuild::names);
            |tree| tree.rebuild;
            |tree, value| tree.rebuild = choice(value)?),
        option!("lazy"; "Build nodes of fewer triangles than this when rays first reach them; 0 builds all at once";
            OptionValues::Whole(0..=KdTreeOptions::MOST_LAZY);
            |tree| tree.options.lazy_below;
            |tree, value| tree.options.lazy_below = parsed(value)?),
    ];

    fn make(&self, level: SimdLevel, _sends_rays_onward: bool) -> Result<Box<dyn rays::Structure>, Error> {
        let Self { options, rebuild } = *self;
        let two_level = |moved| -> Result<Box<dyn rays::Structure>, Error> {
            let mut trees = TwoLevelKdTree::with_level(level, moved);
            trees.set_options(options).map_err(impossible)?;
            Ok(Box::new(trees))
        };
        match rebuild {
            KdRebuild::Whole => {
                let mut tree = KdTree::with_level(level);
                tree.set_options(options).map_err(impossible)?;
                Ok(Box::new(tree))
            }
            KdRebuild::Hierarchy => {
                let mut tree = HierarchyKdTree::with_level(level);
                tree.set_options(options).map_err(impossible)?;
                Ok(Box::new(tree))
            }
            KdRebuild::Background => {
                let tree = BackgroundKdTree::new(rayon::current_num_threads());
                let mut tree = tree.map_err(|error| Error::Structure(error.into()))?.at_level(level);
                tree.set_options(options).map_err(impossible)?;
                Ok(Box::new(tree))
            }
            KdRebuild::TwoLevel => two_level(KdMoved::Transform),
            KdRebuild::Groups => two_level(KdMoved::Rebuild),
            KdRebuild::Fuzzy => two_level(KdMoved::Enclose),
        }
    }

    /// A tree that outlives its frame can't be lazy, since triangles may have moved before a node is built. Rays go through
    /// such trees one by one.
    fn check(&self) -> Result<(), Error> {
        self.options.check().map_err(impossible)?;
        match self.rebuild {
            KdRebuild::Whole | KdRebuild::Hierarchy => Ok(()),
            rebuild if self.options.lazy_below > 0 => {
                let why = format!("a kd-tree has no option `lazy` with `rebuild={rebuild}`");
                Err(Error::StructureOptions(why.into()))
            }
            _ => Ok(()),
        }
    }

    fn on_gpu(&self) -> Result<Option<GpuStructure>, Error> {
        #[cfg(feature = "gpu")]
        let counterpart = GpuStructure::with_finder(self.options);
        // Programs without this feature have no engine on a GPU.
        #[cfg(not(feature = "gpu"))]
        let counterpart = GpuStructure::grids();
        Ok(Some(counterpart))
    }
}

fn impossible(options: ImpossibleKdTreeOptions) -> Error {
    Error::StructureOptions(options.into())
}
