//! Parses the command line, and answers options of other programs with their names here.

use std::ffi::OsString;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, CommandFactory, FromArgMatches};

use crate::failure::Failure;
use crate::flags::Flags;

/// Options of other programs, and how the same is said here.
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
    /// An option of other programs.
    Wrong(Failure),
}

impl Asked {
    pub(crate) fn of(words: impl IntoIterator<Item = OsString>) -> Self {
        let parsed = with_negative_numbers(Flags::command()).try_get_matches_from(words);
        match parsed.and_then(|matches| Flags::from_arg_matches(&matches)) {
            Ok(flags) => Self::Flags(Box::new(flags)),
            Err(said) => elsewhere(&said).map_or(Self::Said(said), Self::Wrong),
        }
    }
}

/// Has options take negative numbers as values, which they refuse in clearer words than "unexpected argument '-4'".
fn with_negative_numbers(command: clap::Command) -> clap::Command {
    let takes_number = |arg: &Arg| arg.get_action().takes_values() && !arg.is_positional();
    command
        .mut_args(|arg| if takes_number(&arg) { arg.allow_negative_numbers(true) } else { arg })
        .mut_subcommands(with_negative_numbers)
}

/// The error where an option has the name that other programs give it.
fn elsewhere(said: &clap::Error) -> Option<Failure> {
    let Some(ContextValue::String(option)) = said.get(ContextKind::InvalidArg) else { return None };
    if said.kind() != ErrorKind::UnknownArgument {
        return None;
    }
    let (_, hint) = ELSEWHERE.iter().find(|(names, _)| names.contains(&option.as_str()))?;
    Some(Failure::input(format!("there is no option {option}"), *hint))
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
        ] {
            match asked(&format!("umbrage render a.obj {option}")) {
                Asked::Wrong(Failure::Input { message, hint }) => {
                    assert!(message.starts_with("there is no option -") && hint.unwrap().contains(part), "{option}");
                }
                other => panic!("{option}: {other:?}"),
            }
        }
        assert!(matches!(asked("umbrage render a.obj --smell"), Asked::Said(_)));
    }

    #[test]
    fn options_of_others_are_none_of_ours() {
        let command = Flags::command();
        let ours: Vec<_> = command.get_subcommands().flat_map(clap::Command::get_arguments).collect();
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
    fn negative_numbers_are_values() {
        for (option, part) in [("--samples -4", "-4 is not in"), ("--frames -5..3", "frames as A..B")] {
            match asked(&format!("umbrage render a.obj {option}")) {
                Asked::Said(said) => assert!(said.to_string().contains(part), "{said}"),
                other => panic!("{option}: {other:?}"),
            }
        }
        assert!(matches!(asked("umbrage render a.obj --exposure -1"), Asked::Flags(_)));
    }
}
