//! Flags whose values come from the library's tables: their help, their completions and their checks.

use std::ffi::OsStr;

use clap::builder::{PossibleValue, TypedValueParser};
use clap::{Arg, Command};
use umbrage::rays::Choice;
use umbrage::{EngineKind, Layer, Layers, Structure, Structures};

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

/// All structures that this command knows: those of the library, and with the feature `papers` the papers'.
pub(crate) fn structures() -> Structures {
    #[cfg(feature = "papers")]
    return umbrage_papers::structures();
    #[cfg(not(feature = "papers"))]
    Structures::default()
}

/// Parses one of the structures for which `is_wanted` holds, with its options.
pub(crate) fn structure(is_wanted: fn(&Structure) -> bool) -> impl TypedValueParser<Value = Structure> {
    let known = structures().only(is_wanted);
    let names = known.iter().map(|structure| (structure.name(), structure.about())).collect();
    let parse = move |text: &str| {
        known.parse(text).map_err(|error| match Feature::Papers.check() {
            Err(Failure::Input { message, hint: Some(hint) }) if is_of_papers(text) => format!("{message}: {hint}"),
            _ => error.to_string(),
        })
    };
    Named { names, parse }
}

/// Whether this is a structure of the papers, with or without options.
fn is_of_papers(text: &str) -> bool {
    matches!(text.split(':').next(), Some("listed" | "grid" | "kdtree"))
}
