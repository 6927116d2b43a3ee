//! `umbrage model.glb` as a shorthand for `umbrage view model.glb`, or for `render` in builds without the window.

use std::ffi::{OsStr, OsString};
use std::path::Path;

use clap::CommandFactory;

use crate::failure::say;
use crate::feature::Feature;
use crate::flags::Flags;

/// Extensions of scene files.
const SCENES: [&str; 7] = ["gltf", "glb", "obj", "ply", "stl", "pc2", "mdd"];

/// Expands the command line: adds the subcommand where the words only name a scene.
pub(crate) fn written_out(words: impl IntoIterator<Item = OsString>) -> Vec<OsString> {
    let words: Vec<_> = words.into_iter().collect();
    let expanded = expanded(words.clone(), Feature::View.is_there());
    if expanded != words && !Feature::View.is_there() {
        say(format_args!("note: {}, so it writes a picture; {}", Feature::View.lack(), Feature::View.remedy()));
    }
    expanded
}

fn expanded(mut words: Vec<OsString>, has_window: bool) -> Vec<OsString> {
    let Some(scene) = words.get(1).filter(|word| is_scene(word)) else { return words };
    let scene = scene.clone();
    let before = if has_window {
        vec!["view".into(), scene]
    } else {
        let picture = beside(&scene);
        ["render".into(), scene].into_iter().chain(picture.into_iter().flat_map(|name| ["-o".into(), name])).collect()
    };
    words.splice(1..2, before);
    words
}

/// Whether a word names a scene rather than a command.
fn is_scene(word: &OsStr) -> bool {
    let text = word.to_string_lossy();
    let is_command = Flags::command().get_subcommands().any(|command| command.get_name() == text) || text == "help";
    let path = Path::new(word);
    let ends_as_one =
        path.extension().is_some_and(|extension| SCENES.iter().any(|ending| extension.eq_ignore_ascii_case(ending)));
    !is_command && !text.starts_with('-') && (text.starts_with("demo:") || ends_as_one || path.exists())
}

/// The path of a picture beside a scene file. The extension avoids the names of textures.
fn beside(scene: &OsStr) -> Option<OsString> {
    let is_file = !scene.to_string_lossy().starts_with("demo:");
    is_file.then(|| Path::new(scene).with_extension("umbrage.png").into_os_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str, has_window: bool) -> Vec<OsString> {
        expanded(line.split(' ').map(OsString::from).collect(), has_window)
    }

    #[test]
    fn scenes_are_opened_and_commands_are_not() {
        for (line, with_window, without) in [
            ("umbrage a/b.glb", "umbrage view a/b.glb", "umbrage render a/b.glb -o a/b.umbrage.png"),
            ("umbrage B.OBJ --time 2", "umbrage view B.OBJ --time 2", "umbrage render B.OBJ -o B.umbrage.png --time 2"),
            ("umbrage demo:cloth", "umbrage view demo:cloth", "umbrage render demo:cloth"),
            ("umbrage Cargo.toml", "umbrage view Cargo.toml", "umbrage render Cargo.toml -o Cargo.umbrage.png"),
        ] {
            assert_eq!(words(line, true), with_window.split(' ').collect::<Vec<_>>());
            assert_eq!(words(line, false), without.split(' ').collect::<Vec<_>>());
        }
        for line in ["umbrage", "umbrage info a.glb", "umbrage --help a.glb", "umbrage help", "umbrage vieww a.glb"] {
            assert_eq!(words(line, true), line.split(' ').collect::<Vec<_>>());
        }
    }
}
