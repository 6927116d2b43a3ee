//! Parses the command line, and explains unknown options, such as those of other programs.

use std::ffi::{OsStr, OsString};

use clap::builder::PossibleValue;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command, CommandFactory, FromArgMatches};
use umbrage::{OptionValues, Structure, StructureOption};

use crate::choices::structures;
use crate::failure::Failure;
use crate::flags::Flags;

/// Options of other programs, and hints to the equivalent ones here.
const ELSEWHERE: &[(&[&str], &str)] = &[
    (&["--fov", "--field-of-view"], "a camera ends with its vertical field of view: --camera X,Y,Z:X,Y,Z:FOV"),
    (&["--width", "--height", "--resolution", "--res"], "width and height are one option: --size 1280x720"),
    (&["--scene", "--input", "--file", "-i"], "the scene stands by itself: umbrage render model.glb"),
    (&["--spp", "--sample"], "rays for each pixel: --samples 16"),
    (&["--out", "--output-file"], "the picture's name: -o picture.png"),
    (&["--frame"], "one frame of many: --frames 12..=12; a moment: --time 0.5"),
    (&["--gpu"], "what renders: --engine gpu"),
    (&["--depth", "--normals"], "what pixels saw in place of light: --show depth, --show normals"),
];

/// The outcome of parsing.
#[derive(Debug)]
pub(crate) enum Asked {
    Flags(Box<Flags>),
    /// Help, the version, or an error of clap's.
    Said(clap::Error),
    /// An unknown option, such as those of other programs.
    Wrong(Failure),
}

impl Asked {
    pub(crate) fn of(words: impl IntoIterator<Item = OsString>) -> Self {
        let words = with_negative_values(words);
        let parsed = with_brief_values(Flags::command()).try_get_matches_from(&words);
        match parsed.and_then(|matches| Flags::from_arg_matches(&matches)) {
            Ok(flags) => Self::Flags(Box::new(flags)),
            Err(said) => unknown_option(&said, &words).map_or(Self::Said(said), Self::Wrong),
        }
    }
}

/// Options whose values are listed in their help by name alone, since their texts or other pages describe them.
const BY_NAME: [&str; 8] = ["format", "structure", "sides", "tone_map", "show", "layers", "png_compression", "chroma"];

/// Puts default values, and possible ones without a description, on the line of an option's help.
fn with_brief_values(command: Command) -> Command {
    command.mut_subcommands(|command| command.mut_args(brief))
}

fn brief(mut arg: Arg) -> Arg {
    let help = arg.get_help().filter(|_| arg.get_action().takes_values()).map(ToString::to_string);
    let Some(mut help) = help else { return arg };
    let values = arg.get_possible_values();
    let are_described = values.iter().any(|value| value.get_help().is_some());
    if !values.is_empty() && (!are_described || BY_NAME.contains(&arg.get_id().as_str())) {
        let names: Vec<_> = values.iter().map(PossibleValue::get_name).collect();
        help += &format!(" [possible values: {}]", names.join(", "));
        arg = arg.hide_possible_values(true);
    }
    if let [default] = arg.get_default_values() {
        help += &format!(" [default: {}]", default.display());
        arg = arg.hide_default_value(true);
    }
    arg.help(help)
}

/// Joins values that begin with `-` and a digit to the option before them, whose error is clearer than "unexpected
/// argument '-4'".
fn with_negative_values(words: impl IntoIterator<Item = OsString>) -> Vec<OsString> {
    let mut joined: Vec<OsString> = Vec::new();
    let mut are_values = false;
    for word in words {
        are_values |= word == "--";
        let is_negative = word.to_str().is_some_and(|word| {
            word.strip_prefix('-')
                .is_some_and(|rest| rest.starts_with(|first: char| first.is_ascii_digit() || first == '.'))
        });
        match joined.last_mut() {
            Some(option) if is_negative && !are_values && is_long_option(option) => {
                option.push("=");
                option.push(word);
            }
            _ => joined.push(word),
        }
    }
    joined
}

/// Whether a word is an option without its value.
fn is_long_option(word: &OsStr) -> bool {
    word.to_str().is_some_and(|word| word.starts_with("--") && !word.contains('='))
}

/// The error for an unknown option, with a hint to the intended one if it is known.
fn unknown_option(said: &clap::Error, words: &[OsString]) -> Option<Failure> {
    let Some(ContextValue::String(option)) = said.get(ContextKind::InvalidArg) else { return None };
    if said.kind() != ErrorKind::UnknownArgument || !option.starts_with('-') {
        return None;
    }
    let of_others = ELSEWHERE.iter().find(|(names, _)| names.contains(&option.as_str())).map(|(_, hint)| *hint);
    let message = format!("there is no option {option}");
    if let Some(structure) = with_options(option, words) {
        return Some(Failure::input(
            message,
            format!("options of a structure follow its name: --structure {structure}"),
        ));
    }
    let hint = match (of_others, said.get(ContextKind::SuggestedArg)) {
        (Some(hint), _) => hint.to_owned(),
        (None, Some(ContextValue::String(similar))) => format!("a similar option is {similar}"),
        _ => "`umbrage help COMMAND` lists a command's options".to_owned(),
    };
    Some(Failure::input(message, hint))
}

/// The value of `--structure` that stands for an unknown flag, if it names an option of a structure as earlier versions
/// did: `--kd-builder` is `builder` of the kd-tree. It includes all such flags of the same structure.
fn with_options(flag: &str, words: &[OsString]) -> Option<String> {
    let structures = structures();
    let (structure, _) = structures.iter().find_map(|structure| Some((structure, option_of(structure, flag)?)))?;
    let words: Vec<&str> = words.iter().filter_map(|word| word.to_str()).collect();
    let mut text = structure.name().to_owned();
    for (index, word) in words.iter().enumerate() {
        let (flag, value) = word.split_once('=').map_or((*word, None), |(flag, value)| (flag, Some(value)));
        let Some(option) = option_of(structure, flag) else { continue };
        let value = match option.values {
            OptionValues::Switch => "true",
            _ => value.or_else(|| words.get(index + 1).copied()).unwrap_or("VALUE"),
        };
        text.push(if text.contains(':') { ',' } else { ':' });
        text.extend([option.name, "=", value]);
    }
    Some(text)
}

/// The option that a flag names, alone or after the first letters of the structure's name: `--packet`, `--grid-packet`.
fn option_of(structure: &Structure, flag: &str) -> Option<&'static StructureOption> {
    let flag = flag.strip_prefix("--")?;
    structure.options().find(|option| {
        let prefix = flag.strip_suffix(option.name);
        prefix.is_some_and(|prefix| {
            prefix.is_empty() || prefix.strip_suffix('-').is_some_and(|prefix| structure.name().starts_with(prefix))
        })
    })
}

#[cfg(test)]
mod tests {

    use super::*;

    fn asked(line: &str) -> Asked {
        Asked::of(line.split(' ').map(OsString::from))
    }

    #[test]
    fn options_of_others_are_told_by_their_name_here() {
        for (option, part) in [
            ("--fov 40", "--camera"),
            ("--width=100", "--size"),
            ("--scene a.obj", "umbrage render"),
            ("-i a", "itself"),
            ("--smell", "umbrage help"),
            ("--samles 4", "--samples"),
            ("--fov -40", "--camera"),
            ("-4", "umbrage help"),
        ] {
            match asked(&format!("umbrage render a.obj {option}")) {
                Asked::Wrong(Failure::Input { message, hint }) => {
                    assert!(message.starts_with("there is no option -") && hint.unwrap().contains(part), "{option}");
                }
                other => panic!("{option}: {other:?}"),
            }
        }
        assert!(matches!(asked("umbrage render a.obj b.obj"), Asked::Said(_)));
    }

    #[cfg(feature = "papers")]
    #[test]
    fn flags_of_structures_are_told_by_their_name_here() {
        for (line, structure) in [
            ("render --kd-builder presorted", "kdtree:builder=presorted"),
            ("render --kd-builder=presorted --kd-lazy 9", "kdtree:builder=presorted,lazy=9"),
            ("render --kd-charge-twice --kd-test-cost 3", "kdtree:charge-twice=true,test-cost=3"),
            ("render --grid-density 3 --packet 8", "grid:density=3,packet=8"),
            ("render --packet 8", "grid:packet=8"),
            ("heatmap --sorting-tile 8", "listed:sorting-tile=8"),
            ("render --light-clamp -30:30:-20:20", "listed:light-clamp=-30:30:-20:20"),
            ("render --light-map", "listed:light-map=VALUE"),
        ] {
            let Asked::Wrong(Failure::Input { hint, .. }) = asked(&format!("umbrage {line}")) else { panic!("{line}") };
            assert_eq!(hint.unwrap(), format!("options of a structure follow its name: --structure {structure}"));
        }
    }

    #[test]
    fn options_of_others_are_none_of_ours() {
        let command = Flags::command();
        let ours: Vec<_> = command.get_subcommands().flat_map(Command::get_arguments).collect();
        for name in ELSEWHERE.iter().flat_map(|(names, _)| *names) {
            let is_ours = |arg: &&&Arg| {
                let short = arg.get_short().map(|short| format!("-{short}"));
                let long = arg.get_long().map(|long| format!("--{long}"));
                [short, long].iter().flatten().any(|own| own == name)
            };
            assert_eq!(ours.iter().find(is_ours).map(|arg| arg.get_id()), None, "{name}");
        }
    }

    #[test]
    fn values_may_begin_with_a_sign() {
        for (option, part) in [
            ("--samples -4", "whole samples from 1 to 4096"),
            ("--samples 4.5", "whole samples from 1 to 4096"),
            ("--frames -5..3", "frames as A..B"),
            ("--size -4x4", "such as 1280x720"),
            ("--time -1s", "seconds from 0"),
            ("--shard -1/8", "such as 3/8"),
            ("--aperture -3%", "is no length"),
            ("--max-memory -1GB", "a size is needed"),
            ("--camera 0,0,5", "needs a point to look at"),
        ] {
            match asked(&format!("umbrage render a.obj {option}")) {
                Asked::Said(said) => assert!(said.to_string().contains(part), "{said}"),
                other => panic!("{option}: {other:?}"),
            }
        }
        assert!(matches!(asked("umbrage render a.obj --exposure -1 --camera -1,0,0:0,0,0"), Asked::Flags(_)));
        assert!(matches!(asked("umbrage render --quiet -- -4.obj"), Asked::Flags(_)));
    }
}
