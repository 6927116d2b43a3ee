//! The structures to choose from: their construction, their names, and a table of their options for command lines, windows
//! and files.

mod kd_tree;

use std::fmt;
use std::mem::discriminant;
use std::num::NonZeroU32;
use std::ops::RangeInclusive;
use std::str::FromStr;

use umbrage_rays::{
    Bvh, Cells, Choice, Clipping, DirectGrids, Insertion, KdBuilder, KdLayout, KdMailbox, KdPacketWidth, KdRebuild,
    KdTraversal, KdTreeOptions, LightClamp, LightMapping, ListedGrids, ListedLightOptions, ListedOptions, PacketSide,
    SahCosts, SimdLevel, UniformGrid, UniformOptions, UnknownChoice,
};

use crate::Error;

/// A structure that finds the triangles hit by camera rays and shadow rays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Structure {
    /// Grids made for the rays: a perspective grid for the camera.
    #[default]
    Perspective,
    /// Grids as their paper describes them, with triangles listed by cell, for the camera and for each light.
    Listed {
        /// Cells of the camera's grid.
        camera: ListedOptions,
        /// Cells of each light's grid, and their blocks of work.
        light: ListedLightOptions,
    },
    /// One uniform grid for all rays, traced in packets. Where the frame has see-through surfaces, crowded cells hold grids
    /// of their own even if the options don't ask for that.
    Grid(UniformOptions),
    /// One kd-tree for all rays, and the way it is updated when triangles have moved.
    KdTree(KdTreeOptions, KdRebuild),
    /// One bounding volume hierarchy for all rays.
    Bvh,
}

impl Structure {
    /// The grids of the paper with their default options.
    pub const LISTED: Self = Self::Listed { camera: ListedOptions::DEFAULT, light: ListedLightOptions::DEFAULT };
    /// The uniform grid with its default options.
    pub const GRID: Self = Self::Grid(UniformOptions::DEFAULT);

    /// Whether structures other than the default and the hierarchy are compiled in: small builds leave them out.
    pub(crate) const HAS_ALL: bool = cfg!(feature = "structures");

    /// The kd-tree that is built fastest.
    pub const KD_TREE: Self = Self::KdTree(KdTreeOptions::FAST, KdRebuild::Whole);

    /// Whether it is made for the rays of one camera and each light, whose cells and work can be shown.
    #[must_use]
    pub fn is_specialised(&self) -> bool {
        matches!(self, Self::Perspective | Self::Listed { .. })
    }

    /// Checks that the options go together.
    pub(crate) fn check(&self) -> Result<(), Error> {
        match *self {
            Self::Grid(options) => Ok(options.check()?),
            Self::KdTree(options, rebuild) => kd_tree::check(options, rebuild),
            Self::Listed { light: ListedLightOptions { map: LightMapping::Faces, clamp: Some(_), .. }, .. } => {
                Err(Error::LightClampOfFaces)
            }
            _ => Ok(()),
        }
    }

    /// Checks that a GPU has this structure, with all its options.
    ///
    /// # Errors
    /// If it hasn't, or would ignore an option.
    pub fn check_on_gpu(&self) -> Result<(), Error> {
        let is_taken = |name: &str| match self {
            Self::KdTree(..) => !["kd-rebuild", "kd-lazy", "kd-mailbox"].contains(&name),
            _ => {
                ["sorting-tile", "tracing-tiles", "slices", "light-map", "light-clamp", "light-slices"].contains(&name)
            }
        };
        if !matches!(self, Self::Perspective | Self::Listed { .. } | Self::KdTree(..)) {
            return Err(Error::StructureOnGpu(self.name()));
        }
        if let Some((option, _)) = self.changed_options().find(|(option, _)| !is_taken(option.name)) {
            return Err(Error::OptionOnGpu(self.name(), option.name));
        }
        let Self::Listed { camera: ListedOptions { cells, .. }, .. } = self else { return Ok(()) };
        let (tile, tiles) = (cells.sorting_tile(), cells.tracing_tiles());
        let by_default = with_sorting_tile(Cells::DEFAULT, tile).map(|cells| cells.tracing_tiles());
        let is_traced = matches!(tile, 8 | 16) && (tile * tiles == 16 || Some(tiles) == by_default);
        if is_traced { Ok(()) } else { Err(Error::TilesOnGpu) }
    }

    /// An empty structure of this kind that uses the instructions of `level`; with `sends_rays_onward` for single rays as
    /// well as the camera's and the lights'.
    pub(crate) fn make(
        &self,
        level: SimdLevel,
        sends_rays_onward: bool,
    ) -> Result<Box<dyn umbrage_rays::Structure>, Error> {
        Ok(match *self {
            Self::Perspective => Box::new(DirectGrids::with_level(level)),
            Self::Bvh => Box::new(Bvh::with_level(level)),
            _ if !Self::HAS_ALL => return Err(Error::StructureLeftOut(self.name())),
            Self::Listed { camera, light } => Box::new(ListedGrids::with_options(level, camera, light)),
            Self::Grid(mut options) => {
                if sends_rays_onward {
                    // Single rays need nested grids where triangles crowd: a twelfth of the time for `demo:glass`.
                    options.nested_above = options.nested_above.or(UniformOptions::NESTED.nested_above);
                }
                let mut grid = UniformGrid::with_level(level);
                grid.set_options(options)?;
                Box::new(grid)
            }
            Self::KdTree(options, rebuild) => kd_tree::make(level, options, rebuild)?,
        })
    }
}

/// An option of a structure, with a name for [`Structure::option`] and [`Structure::set_option`].
#[derive(Debug)]
pub struct StructureOption {
    /// The structure's name.
    pub structure: &'static str,
    /// Its own name, without spaces.
    pub name: &'static str,
    /// Its meaning, in a line that ends without a full stop.
    pub about: &'static str,
    /// The values that it can have.
    pub values: OptionValues,
    /// `None` for other structures.
    get: fn(&Structure) -> Option<String>,
    /// Sets it to one of `values`; `None` for other structures, and where the value doesn't go with the other options.
    set: fn(&mut Structure, &str) -> Option<()>,
}

/// An option of the structures that match a pattern, which binds the fields to read and set.
macro_rules! option {
    ($structure:literal, $name:literal, $about:literal, $values:expr, $of:pat => $get:expr, |$value:ident| $set:expr) => {
        StructureOption {
            structure: $structure,
            name: $name,
            about: $about,
            values: $values,
            get: |structure| {
                let $of = structure else { return None };
                Some($get.to_string())
            },
            set: |structure, $value| {
                let $of = structure else { return None };
                $set;
                Some(())
            },
        }
    };
}

/// The values that an option can have.
#[derive(Debug)]
pub enum OptionValues {
    /// One of a few names, each with its meaning.
    Names(fn() -> Vec<(&'static str, &'static str)>),
    /// A whole number.
    Whole(RangeInclusive<u32>),
    /// A whole number, or `auto`.
    WholeOrAuto(RangeInclusive<u32>),
    /// The four angles of a [`LightClamp`] in degrees, or `auto`.
    Rectangle,
    /// A finite number above 0.
    Positive,
    /// A number from 0 to 1.
    Share,
    /// `true` or `false`.
    Switch,
}

/// An option that a structure lacks, or a value that it can't have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{option} {value}: {why}")]
pub struct ImpossibleOption {
    /// The option's name.
    pub option: String,
    /// The refused value.
    pub value: String,
    /// The reason, with the possible values.
    pub why: String,
}

impl Structure {
    /// The options of all structures. Later ones may depend on earlier ones.
    pub const OPTIONS: &'static [StructureOption] = &[
        option!("listed", "sorting-tile", "Pixels a side of the tiles that triangles are listed in",
            OptionValues::Names(tiles),
            Self::Listed { camera: ListedOptions { cells, .. }, .. } => cells.sorting_tile(),
            |value| *cells = with_sorting_tile(*cells, whole(value)?)?),
        option!("listed", "tracing-tiles",
            "Sorting tiles a side of the tiles that are searched at once, of 64 pixels a side at most",
            OptionValues::Names(tiles_of_tiles),
            Self::Listed { camera: ListedOptions { cells, .. }, .. } => cells.tracing_tiles(),
            |value| *cells = Cells::new(cells.sorting_tile(), whole(value)?, cells.slices()).ok()?),
        option!("listed", "slices", "Depth slices of the camera's grid",
            OptionValues::Whole(1..=Cells::MOST_SLICES),
            Self::Listed { camera: ListedOptions { cells, .. }, .. } => cells.slices(),
            |value| *cells = Cells::new(cells.sorting_tile(), cells.tracing_tiles(), whole(value)?).ok()?),
        option!("listed", "whole-tiles",
            "Test all triangles of a cell on all pixels of its tile, as one GPU thread for each pixel does",
            OptionValues::Switch,
            Self::Listed { camera, .. } => !camera.skips_blocks,
            |value| camera.skips_blocks = value != "true"),
        option!("listed", "camera-triangles",
            "The most triangles that a thread searches in 64×64 pixels, where more are divided among threads; auto divides none",
            OptionValues::WholeOrAuto(1..=u32::MAX),
            Self::Listed { camera, .. } => camera.most_triangles.map_or_else(|| "auto".to_owned(), |most| most.to_string()),
            |value| camera.most_triangles = whole(value).and_then(NonZeroU32::new)),
        option!("listed", "light-cells", "Cells a side of the light grids",
            OptionValues::Whole(1..=ListedLightOptions::MOST_CELLS),
            Self::Listed { light, .. } => light.cells(),
            |value| *light = light.with_sizes(whole(value)?, light.points(), light.triangles()).ok()?),
        option!("listed", "light-rays",
            "The most shadow rays in a block of work of the light grids, the paper's r; a multiple of 16",
            OptionValues::Whole(1..=ListedLightOptions::LARGEST_BLOCK),
            Self::Listed { light, .. } => light.points(),
            |value| *light = light.with_sizes(light.cells(), whole(value)?, light.triangles()).ok()?),
        option!("listed", "light-triangles", "The most triangles in a block of work of the light grids",
            OptionValues::Whole(1..=ListedLightOptions::LARGEST_BLOCK),
            Self::Listed { light, .. } => light.triangles(),
            |value| *light = light.with_sizes(light.cells(), light.points(), whole(value)?).ok()?),
        option!("listed", "light-slices", "Depth slices of the light grids",
            OptionValues::Whole(1..=ListedLightOptions::MOST_SLICES),
            Self::Listed { light, .. } => light.slices(),
            |value| *light = light.with_slices(whole(value)?)?),
        option!("listed", "light-map", "How lights that are somewhere see points and triangles",
            OptionValues::Names(LightMapping::names),
            Self::Listed { light, .. } => light.map,
            |value| light.map = value.parse().ok()?),
        option!("listed", "light-clamp",
            "Angles that a spherical light map divides into cells: the lowest and highest α, and β, in degrees around the \
             light's forward direction, as -30:30:-20:20; what is outside is in the border cells, and auto: those at \
             which the camera sees something",
            OptionValues::Rectangle,
            Self::Listed { light, .. } => light.clamp.map_or_else(|| "auto".to_owned(), |clamp| clamp.to_string()),
            |value| light.clamp = value.parse().ok()),
        option!("grid", "grid-density", "Cells for each triangle, λ of the paper",
            OptionValues::Positive,
            Self::Grid(options) => options.cells_per_triangle,
            |value| options.cells_per_triangle = value.parse().ok()?),
        option!("grid", "grid-macrocell", "Cells a side of macrocells, by which empty space is skipped; 1 does without",
            OptionValues::Whole(1..=UniformOptions::LARGEST_MACROCELL),
            Self::Grid(options) => options.macrocell,
            |value| options.macrocell = whole(value)?),
        option!("grid", "grid-insertion", "Which cells list a triangle",
            OptionValues::Names(Insertion::names),
            Self::Grid(options) => options.insertion,
            |value| options.insertion = value.parse().ok()?),
        option!("grid", "grid-spread",
            "Split packets of shadow rays where inverse depths differ by more than this part of the first",
            OptionValues::Positive,
            Self::Grid(options) => options.shadow_spread,
            |value| options.shadow_spread = value.parse().ok().filter(|spread: &f32| *spread > 0.0 && spread.is_finite())?),
        option!("grid", "grid-nested",
            "Let cells that list more than so many triangles hold grids of their own, for scenes of very uneven density; \
             auto: more than 64, and only in scenes with surfaces that one sees through",
            OptionValues::WholeOrAuto(1..=u32::MAX),
            Self::Grid(options) => options.nested_above.map_or_else(|| "auto".to_owned(), |most| most.to_string()),
            |value| options.nested_above = whole(value)),
        option!("grid", "packet", "Pixels a side of the packets of rays",
            OptionValues::Names(PacketSide::names),
            Self::Grid(options) => options.packet,
            |value| options.packet = value.parse().ok()?),
        option!("kdtree", "kd-builder", "How planes are found",
            OptionValues::Names(KdBuilder::names),
            Self::KdTree(options, _) => options.builder,
            |value| options.builder = value.parse().ok()?),
        option!("kdtree", "kd-clipping", "What is kept of a triangle that a plane cuts",
            OptionValues::Names(Clipping::names),
            Self::KdTree(options, _) => options.clipping,
            |value| options.clipping = value.parse().ok()?),
        option!("kdtree", "kd-step-cost", "What the surface area heuristic charges for a step to a child",
            OptionValues::Positive,
            Self::KdTree(options, _) => options.costs.step,
            |value| options.costs.step = value.parse().ok()?),
        option!("kdtree", "kd-test-cost", "What it charges for the test of a triangle",
            OptionValues::Positive,
            Self::KdTree(options, _) => options.costs.test,
            |value| options.costs.test = value.parse().ok()?),
        option!("kdtree", "kd-empty-cost", "What the costs of a plane that cuts off empty space are multiplied with",
            OptionValues::Share,
            Self::KdTree(options, _) => options.costs.empty,
            |value| options.costs.empty = value.parse().ok()?),
        option!("kdtree", "kd-charge-twice",
            "Charge for two tests of a triangle on both sides of a plane, although rays remember the first",
            OptionValues::Switch,
            Self::KdTree(options, _) => !options.costs.mailbox,
            |value| options.costs.mailbox = value != "true"),
        option!("kdtree", "kd-failures",
            "How many planes on the way to a leaf may cost more than they save",
            OptionValues::Whole(0..=SahCosts::MOST_FAILURES),
            Self::KdTree(options, _) => options.costs.failures,
            |value| options.costs.failures = whole(value)?),
        option!("kdtree", "kd-layout", "How nodes lie in memory",
            OptionValues::Names(KdLayout::names),
            Self::KdTree(options, _) => options.layout,
            |value| options.layout = value.parse().ok()?),
        option!("kdtree", "kd-traversal", "How rays are led to leaves, alone and in packets",
            OptionValues::Names(KdTraversal::names),
            Self::KdTree(options, _) => options.traversal,
            |value| options.traversal = value.parse().ok()?),
        option!("kdtree", "kd-packet", "Camera and shadow rays of a packet",
            OptionValues::Names(KdPacketWidth::names),
            Self::KdTree(options, _) => options.packets.width,
            |value| options.packets.width = value.parse().ok()?),
        option!("kdtree", "kd-mailbox", "Which triangles packets remember to have tested",
            OptionValues::Names(KdMailbox::names),
            Self::KdTree(options, _) => options.packets.mailbox,
            |value| options.packets.mailbox = value.parse().ok()?),
        option!("kdtree", "kd-rebuild", "What is done when triangles are elsewhere in the next frame",
            OptionValues::Names(KdRebuild::names),
            Self::KdTree(_, rebuild) => rebuild,
            |value| *rebuild = value.parse().ok()?),
        option!("kdtree", "kd-lazy",
            "Build nodes of fewer triangles than this when rays first reach them; 0 builds all at once",
            OptionValues::Whole(0..=KdTreeOptions::MOST_LAZY),
            Self::KdTree(options, _) => options.lazy_below,
            |value| options.lazy_below = whole(value)?),
    ];

    /// The options of this structure.
    pub fn options(&self) -> impl Iterator<Item = &'static StructureOption> + use<> {
        let name = self.name();
        Self::OPTIONS.iter().filter(move |option| option.structure == name)
    }

    /// Its options that aren't the defaults, with their values.
    pub fn changed_options(&self) -> impl Iterator<Item = (&'static StructureOption, String)> {
        let default = Self::named(self.name()).unwrap_or_default();
        self.options().filter_map(move |option| {
            let value = self.option(option.name).filter(|value| default.option(option.name).as_ref() != Some(value));
            Some((option, value?))
        })
    }

    /// The value of an option, as [`set_option`](Self::set_option) takes it; `None` where the structure has no such option.
    #[must_use]
    pub fn option(&self, name: &str) -> Option<String> {
        let option = self.options().find(|option| option.name == name)?;
        (option.get)(self)
    }

    /// Sets an option. Larger sorting tiles reduce the number in a tracing tile where fewer fit.
    ///
    /// # Errors
    /// If the structure has no such option, or that can't have the value. Then nothing is changed.
    pub fn set_option(&mut self, name: &str, value: &str) -> Result<(), ImpossibleOption> {
        let impossible = |why: String| ImpossibleOption { option: name.to_owned(), value: value.to_owned(), why };
        let option = self.options().find(|option| option.name == name);
        let option = option.ok_or_else(|| impossible(format!("`{self}` has no such option")))?;
        option.values.check(name, value).map_err(impossible)?;
        (option.set)(self, value).ok_or_else(|| impossible("tiles have at most 64 pixels a side".to_owned()))
    }
}

impl OptionValues {
    /// Checks that an option of this name can have a value; the error gives the reason.
    fn check(&self, name: &str, value: &str) -> Result<(), String> {
        let in_range = |range: &RangeInclusive<u32>| value.parse().is_ok_and(|value| range.contains(&value));
        match self {
            // A short stack may have any number of entries.
            Self::Names(_) if name == "kd-traversal" => {
                value.parse::<KdTraversal>().map(drop).map_err(|unknown| unknown.to_string())
            }
            Self::Names(names) => {
                let names = names();
                let is_known = names.iter().any(|(known, _)| *known == value);
                let known = names.iter().map(|(known, _)| *known).collect::<Vec<_>>().join(", ");
                is_known.then_some(()).ok_or_else(|| format!("choose one of {known}"))
            }
            Self::Whole(range) | Self::WholeOrAuto(range) if in_range(range) => Ok(()),
            Self::WholeOrAuto(_) | Self::Rectangle if value == "auto" => Ok(()),
            Self::Whole(range) => Err(format!("give a whole number from {} to {}", range.start(), range.end())),
            Self::WholeOrAuto(range) => Err(format!("give `auto` or a whole number from {} on", range.start())),
            Self::Positive => {
                let is_positive = value.parse().is_ok_and(|value: f64| value > 0.0 && value.is_finite());
                is_positive.then_some(()).ok_or_else(|| "give a number above 0".to_owned())
            }
            Self::Rectangle => match value.parse::<LightClamp>() {
                Ok(_) => Ok(()),
                Err(none) => Err(none.to_string()),
            },
            Self::Share => {
                let is_share = value.parse().is_ok_and(|value: f64| (0.0..=1.0).contains(&value));
                is_share.then_some(()).ok_or_else(|| "give a number from 0 to 1".to_owned())
            }
            Self::Switch => {
                matches!(value, "true" | "false").then_some(()).ok_or_else(|| "give `true` or `false`".to_owned())
            }
        }
    }
}

/// The same cells with larger or smaller sorting tiles, and no more of them in a tracing tile than fit.
fn with_sorting_tile(cells: Cells, tile: u32) -> Option<Cells> {
    let fit = Cells::LARGEST_TILE.checked_div(tile)?;
    Cells::new(tile, cells.tracing_tiles().min(fit), cells.slices()).ok()
}

fn whole(value: &str) -> Option<u32> {
    value.parse().ok()
}

fn tiles() -> Vec<(&'static str, &'static str)> {
    vec![("8", ""), ("16", ""), ("32", ""), ("64", "")]
}

fn tiles_of_tiles() -> Vec<(&'static str, &'static str)> {
    vec![("1", ""), ("2", ""), ("4", ""), ("8", "")]
}

impl Choice for Structure {
    const OPTION: &'static str = "structure";
    /// Each with its default options.
    const CHOICES: &'static [(&'static str, Self, &'static str)] = &[
        ("perspective", Self::Perspective, "grids made for the camera's and the lights' rays"),
        ("listed", Self::LISTED, "the same in their paper's form, with triangles listed by cell"),
        ("grid", Self::GRID, "a uniform grid for all rays, traced in packets"),
        ("kdtree", Self::KD_TREE, "a kd-tree for all rays"),
        ("bvh", Self::Bvh, "a bounding volume hierarchy for all rays"),
    ];

    /// The name, for any options.
    fn name(self) -> &'static str {
        let found = Self::CHOICES.iter().find(|(_, value, _)| discriminant(value) == discriminant(&self));
        found.map_or("", |(name, ..)| name)
    }
}

/// Its name, and the options that aren't the defaults: `kdtree:kd-builder=presorted,kd-lazy=64`.
impl fmt::Display for Structure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())?;
        for (index, (option, value)) in self.changed_options().enumerate() {
            let separator = if index == 0 { ':' } else { ',' };
            write!(f, "{separator}{}={value}", option.name)?;
        }
        Ok(())
    }
}

/// Reads the text that [`Structure`]'s `Display` writes.
impl FromStr for Structure {
    type Err = UnknownStructure;

    fn from_str(text: &str) -> Result<Self, UnknownStructure> {
        let (name, options) = text.split_once(':').map_or((text, None), |(name, options)| (name, Some(options)));
        let mut structure = Self::named(name)?;
        for option in options.into_iter().flat_map(|options| options.split(',')) {
            let (option, value) = option.split_once('=').unwrap_or((option, ""));
            structure.set_option(option, value)?;
        }
        Ok(structure)
    }
}

/// The reason why a text is no structure.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnknownStructure {
    /// There is none of that name.
    #[error(transparent)]
    Name(#[from] UnknownChoice),
    /// An option is impossible.
    #[error(transparent)]
    Option(#[from] ImpossibleOption),
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Some values that an option can have.
    fn values(option: &StructureOption) -> Vec<String> {
        match &option.values {
            OptionValues::Names(names) => names().iter().map(|(name, _)| (*name).to_owned()).collect(),
            OptionValues::Whole(range) | OptionValues::WholeOrAuto(range) => {
                // Blocks of rays are multiples of 16.
                vec![range.end().to_string(), 48.min(*range.end()).to_string()]
            }
            OptionValues::Positive => vec!["0.25".to_owned(), "100".to_owned()],
            OptionValues::Rectangle => vec!["auto".to_owned(), "-30:30:-20:20.5".to_owned()],
            OptionValues::Share => vec!["0".to_owned(), "0.3".to_owned(), "1".to_owned()],
            OptionValues::Switch => vec!["true".to_owned(), "false".to_owned()],
        }
    }

    #[test]
    fn every_option_of_every_structure_is_set_read_and_written() {
        for option in Structure::OPTIONS {
            assert!(!option.about.ends_with('.') && !option.name.contains(' '), "{}", option.name);
            for value in values(option) {
                let mut structure = Structure::named(option.structure).unwrap();
                if option.name == "tracing-tiles" {
                    structure.set_option("sorting-tile", "8").unwrap();
                }
                structure.set_option(option.name, &value).unwrap();
                assert_eq!(structure.option(option.name), Some(value));
                assert_eq!(structure.to_string().parse(), Ok(structure));
            }
        }
    }

    #[test]
    fn defaults_are_the_librarys_and_need_no_options() {
        for &(name, structure, _) in Structure::CHOICES {
            assert_eq!((structure.to_string().as_str(), name.parse()), (name, Ok(structure)));
        }
        let tuned = Structure::KdTree(KdTreeOptions { lazy_below: 64, ..KdTreeOptions::FAST }, KdRebuild::Whole);
        assert_eq!(tuned.to_string(), "kdtree:kd-lazy=64");
        assert_eq!(tuned.name(), "kdtree");
    }

    #[test]
    fn larger_tiles_leave_room_for_fewer() {
        let mut listed = Structure::LISTED;
        listed.set_option("sorting-tile", "64").unwrap();
        assert_eq!(listed.option("tracing-tiles").as_deref(), Some("1"));
        let before = listed;
        let refused = listed.set_option("tracing-tiles", "2").unwrap_err();
        assert!(refused.to_string().contains("64 pixels") && listed == before, "{refused}");
    }

    #[test]
    fn trees_that_outlive_a_frame_are_not_lazy() {
        for &(name, rebuild, _) in KdRebuild::CHOICES {
            let lazy: Structure = format!("kdtree:kd-rebuild={name},kd-lazy=64").parse().unwrap();
            let is_built_anew = matches!(rebuild, KdRebuild::Whole | KdRebuild::Hierarchy);
            assert_eq!(lazy.check().is_ok(), is_built_anew, "{name}");
            assert!(is_built_anew || lazy.check().unwrap_err().to_string().contains("no option `kd-lazy`"));
            assert!(Structure::KdTree(KdTreeOptions::FAST, rebuild).check().is_ok());
        }
    }

    #[test]
    fn what_can_not_be_is_refused_in_words() {
        for (text, why) in [
            ("tree", "there is no structure `tree`"),
            ("bvh:packet=4", "no such option"),
            ("grid:packet=7", "choose one of 2, 4, 8, 16, 32"),
            ("grid:grid-density=0", "a number above 0"),
            ("grid:grid-nested=0", "`auto` or a whole number from 1 on"),
            ("listed:sorting-tile=7", "choose one of 8, 16, 32, 64"),
            ("listed:slices=65", "from 1 to 64"),
            ("listed:light-clamp=10:-10:0:20", "from -180 to 180, as -30:30:-20:20"),
            ("listed:light-clamp=0:10:0", "as -30:30:-20:20"),
            ("listed:whole-tiles=", "`true` or `false`"),
            ("kdtree:kd-builder=fast", "choose one of naive"),
            ("kdtree:kd-traversal=short-stack:49", "1 to 48"),
            ("kdtree:kd-rebuild=never", "choose one of whole, hierarchy, background"),
            ("kdtree:kd-lazy=4097", "from 0 to 4096"),
            ("kdtree:kd-packet=5", "choose one of 4, 8, 16"),
            ("kdtree:kd-test-cost=0", "a number above 0"),
            ("kdtree:kd-empty-cost=1.5", "a number from 0 to 1"),
            ("kdtree:kd-empty-cost=NaN", "a number from 0 to 1"),
            ("kdtree:kd-charge-twice=no", "`true` or `false`"),
        ] {
            let refused = text.parse::<Structure>().unwrap_err().to_string();
            assert!(refused.contains(why), "{text}: {refused}");
        }
    }
}
