//! The program `fuzz` finds faults, and prints the mutant.

use std::process::Command;

use umbrage::scene::Frame;
use umbrage::{Renderer, Settings};

fn fuzz(arguments: &[&str]) -> (bool, String) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut program = Command::new(env!("CARGO_BIN_EXE_fuzz"));
    let output = program.args(arguments).arg("--keep").arg(folder.path()).output().expect("the program");
    (output.status.success(), String::from_utf8(output.stdout).expect("text"))
}

#[test]
fn panics_wrong_answers_and_ends_of_the_program_are_found() {
    let (is_sound, said) = fuzz(&["--target", "broken", "--mutants", "24"]);
    assert!(!is_sound);
    for finding in
        ["this panics", "this is wrong", "ends the program", "memory allocation of 1125899906842624 bytes failed"]
    {
        assert!(said.contains(finding), "{finding}: {said}");
    }
    let (seed, _) = said.split_once(":  ends the program").expect("one that ends it");
    let seed = seed.rsplit(' ').next().expect("its number");
    let (is_sound, said) = fuzz(&["--target", "broken", "--seed", seed, "--mutants", "1"]);
    assert!(!is_sound && said.contains("ends the program") && said.contains("1 findings"), "{said}");
}

#[test]
fn what_is_sound_passes() {
    let (is_sound, said) = fuzz(&["--target", "options", "--target", "ply", "--mutants", "5"]);
    assert!(is_sound && said.contains("options: --seed 1 to 6") && said.contains("0 findings"), "{said}");
}

/// Found with `--target api`: making a camera for a frame used its triangles' corners without a check.
#[test]
fn triangles_without_vertices_have_a_camera() {
    let frame = Frame::from_triangles(vec![glam::Vec3::ONE; 3], vec![[0, 1, 2], [0, 1, 33_554_431]]);
    assert!(Settings::default().view(&frame).is_ok());
    assert!(Renderer::default().render_frame(&frame, &Settings::default()).is_err());
}
