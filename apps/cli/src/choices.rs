//! Flags whose values come from the library's tables: their help, their completions and their checks.

use std::ffi::OsStr;

use clap::builder::{PossibleValue, TypedValueParser};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use umbrage::rays::{Choice, UnknownChoice};
use umbrage::{EngineKind, ImpossibleOption, Layer, Layers, OptionValues, Structure, StructureOption};

use crate::failure::Failure;
use crate::feature::Feature;

/// Parses a value with `parse`, and lists the possible names.
#[derive(Clone)]
struct Named<P> {
    names: Vec<(&'static str, &'static str)>,
    parse: P,
}

impl<P, T, E> TypedValueParser for Named<P>
where
    P: Fn(&str) -> Result<T, E> + Clone + Send + Sync + 'static,
    T: Clone + Send + Sync + 'static,
    E: Into<Box<dyn std::error::Error + Send + Sync>>,
{
    type Value = T;

    fn parse_ref(&self, command: &Command, flag: Option<&Arg>, value: &OsStr) -> Result<T, clap::Error> {
        self.parse.parse_ref(command, flag, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let values = self.names.iter().map(|(name, about)| {
            let value = PossibleValue::new(*name);
            if about.is_empty() { value } else { value.help(*about) }
        });
        Some(Box::new(values))
    }
}

/// Parses one of a type's choices by its name.
pub(crate) fn choice<T: Choice + Send + Sync>() -> impl TypedValueParser<Value = T> {
    Named { names: T::names(), parse: T::named }
}

/// Parses an engine. In builds without the GPU engine, its description names the missing feature.
pub(crate) fn engine() -> impl TypedValueParser<Value = EngineKind> {
    let described = |(name, about)| match EngineKind::named(name) {
        Ok(EngineKind::Gpu) if !Feature::Gpu.is_there() => (name, "a GPU, in builds with `--features gpu`"),
        _ => (name, about),
    };
    Named { names: EngineKind::names().into_iter().map(described).collect(), parse: EngineKind::named }
}

/// Parses layer names separated by commas, or the name of all.
pub(crate) fn layers() -> impl TypedValueParser<Value = Layers> {
    let all = (Layers::ALL, "all of these");
    Named { names: Layer::names().into_iter().chain([all]).collect(), parse: str::parse::<Layers> }
}

/// The structures of each kind of command, the default first. With a single structure there is no `--structure`.
const KNOWN: [&[&str]; 3] =
    [&["perspective", "listed", "grid", "kdtree", "bvh"], &["listed", "perspective"], &["kdtree"]];
/// All structures, as for rendering.
pub(crate) const ALL: usize = 0;
/// Structures whose work is counted per pixel.
pub(crate) const SPECIALISED: usize = 1;
/// The kd-tree alone.
pub(crate) const KD_TREE: usize = 2;

/// `--structure` and a flag for each option of each structure.
#[derive(Clone, Debug)]
pub(crate) struct StructureFlags<const K: usize> {
    structure: Structure,
    given: Vec<(&'static StructureOption, String)>,
}

impl<const K: usize> StructureFlags<K> {
    /// Whether any option is given.
    pub(crate) fn has_options(&self) -> bool {
        !self.given.is_empty()
    }

    /// The structure with its options.
    ///
    /// # Errors
    /// If an option belongs to another structure, or excludes another option.
    pub(crate) fn structure(&self) -> Result<Structure, Failure> {
        let mut structure = self.structure;
        for (option, value) in &self.given {
            if option.structure != structure.name() {
                let message = format!("--{} is no option of `--structure {}`", option.name, structure.name());
                let hint = format!("leave it out, or add `--structure {}`", option.structure);
                return Err(Failure::input(message, hint));
            }
            let set = structure.set_option(option.name, value);
            set.map_err(|ImpossibleOption { option, value, why }| Failure::input(format!("--{option} {value}"), why))?;
        }
        Ok(structure)
    }

    fn options() -> impl Iterator<Item = &'static StructureOption> {
        Structure::OPTIONS.iter().filter(|option| KNOWN[K].contains(&option.structure))
    }
}

impl<const K: usize> Args for StructureFlags<K> {
    fn augment_args(command: Command) -> Command {
        let default = KNOWN[K][0];
        let command = match KNOWN[K] {
            [_] => command,
            names => command.arg(
                Arg::new("structure")
                    .long("structure")
                    .value_name("NAME")
                    .help("What finds the triangles that rays hit; the picture is the same with each. GPUs have perspective and kdtree")
                    .default_value(default)
                    .value_parser(named_structure(names)),
            ),
        };
        Self::options().fold(command, |command, option| {
            let heading = match option.structure {
                _ if KNOWN[K].len() == 1 => "Options of the kd-tree, with --structure",
                "listed" => "Options of --structure listed",
                "grid" => "Options of --structure grid",
                _ => "Options of --structure kdtree",
            };
            command.arg(flag(option, heading))
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<const K: usize> FromArgMatches for StructureFlags<K> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let chosen = if KNOWN[K].len() > 1 { matches.get_one::<Structure>("structure").copied() } else { None };
        let structure = chosen.unwrap_or_else(|| Structure::named(KNOWN[K][0]).unwrap_or_default());
        let given = Self::options().filter_map(|option| {
            let value = match option.values {
                OptionValues::Switch => matches.get_flag(option.name).then(|| "true".to_owned()),
                _ => matches.get_one::<String>(option.name).cloned(),
            };
            Some((option, value?))
        });
        Ok(Self { structure, given: given.collect() })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

fn named_structure(names: &'static [&'static str]) -> impl TypedValueParser<Value = Structure> {
    let is_known = move |name: &str| names.contains(&name);
    let parse = move |name: &str| match Structure::named(name) {
        Ok(structure) if is_known(name) => Ok(structure),
        _ => Err(UnknownChoice::new(Structure::OPTION, name, names.iter().copied())),
    };
    Named { names: Structure::names().into_iter().filter(|(name, _)| is_known(name)).collect(), parse }
}

/// The flag of an option.
fn flag(option: &'static StructureOption, heading: &'static str) -> Arg {
    let default = Structure::named(option.structure).unwrap_or_default().option(option.name).unwrap_or_default();
    let flag = Arg::new(option.name).long(option.name).help_heading(heading);
    let parse = move |value: &str| {
        let mut structure = Structure::named(option.structure).unwrap_or_default();
        if option.name == "tracing-tiles" {
            // The range depends on the size of sorting tiles, which may be given as well, so this checks with the
            // widest one.
            structure.set_option("sorting-tile", "8").map_err(|impossible| impossible.why)?;
        }
        structure.set_option(option.name, value).map(|()| value.to_owned()).map_err(|impossible| impossible.why)
    };
    let (value_name, range, names) = match &option.values {
        OptionValues::Switch => return flag.help(option.about).action(ArgAction::SetTrue),
        OptionValues::Names(names) => ("NAME", String::new(), names()),
        OptionValues::Whole(range) => ("N", format!(", {} to {}", range.start(), range.end()), Vec::new()),
        OptionValues::WholeOrAuto(_) => ("N", String::new(), Vec::new()),
        OptionValues::Rectangle => ("DEGREES", String::new(), Vec::new()),
        OptionValues::Positive => ("NUMBER", ", above 0".to_owned(), Vec::new()),
        OptionValues::Share => ("NUMBER", ", 0 to 1".to_owned(), Vec::new()),
    };
    let is_rectangle = matches!(option.values, OptionValues::Rectangle);
    let flag = flag.value_name(value_name).help(format!("{}{range} [default: {default}]", option.about));
    if names.is_empty() {
        flag.allow_negative_numbers(true).allow_hyphen_values(is_rectangle).value_parser(parse)
    } else {
        flag.value_parser(Named { names, parse })
    }
}
