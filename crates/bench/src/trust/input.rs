//! Bad or repeated input is counted and costs little.

use std::process::Command;
use std::time::Instant;

use anyhow::{Context as _, Result, ensure};
use glam::Vec3;
use umbrage::rays::{Camera, LightSource, SeenPixels, SimdLevel};
use umbrage::scene::{Frame, Light};
use umbrage::{Renderer, Settings};
use umbrage_verify::structures::STRUCTURES;
use umbrage_verify::views::{camera, view};
use umbrage_verify::{Case, TestMesh};

use super::rays::number;
use super::surfaces::choices;
use super::{Effort, Finding};

/// A frame of test triangles with a light.
pub(super) fn frame(mesh: TestMesh, light: Vec3) -> Frame {
    let mut frame = Frame::from_triangles(mesh.positions, mesh.indices);
    let source = LightSource::Point { position: light };
    frame.lights = vec![Light::new(source, 100.0)];
    frame
}

pub(super) fn garbage(effort: &Effort) -> Result<Finding> {
    let (scenes, mut random) = (effort.of(1000), effort.random());
    let mut structures: Vec<_> = STRUCTURES.iter().map(|(_, make)| make(SimdLevel::default())).collect();
    let (mut omitted_in_all, mut wrong, mut seen) = ([0_u64; 3], 0, SeenPixels::default());
    for _ in 0..scenes {
        let mut mesh = TestMesh::soup(&mut random, 100, 1e-3);
        let mut expected = [0_u32; 3];
        for id in 0..100 {
            let [a, b, c] = mesh.indices[id];
            match random.below(8) {
                0 => {
                    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][random.below(3)];
                    mesh.positions[[a, b, c][random.below(3)] as usize][random.below(3)] = bad;
                    expected[0] += 1;
                }
                1 => {
                    mesh.positions[b as usize] = mesh.positions[c as usize];
                    expected[1] += 1;
                }
                2 => {
                    mesh.indices[id][random.below(3)] = [u32::MAX, 300, 1 << 31][random.below(3)];
                    expected[2] += 1;
                }
                _ => {}
            }
        }
        let light = umbrage_verify::lights::point(random.point() * 3.0);
        let case = Case::new("garbage", mesh, view(camera(), 12, 9), &[light]);
        for structure in &mut structures {
            structure.build(case.mesh.triangles());
            structure.see(&case.shot(), &mut seen)?;
            structure.shadow(&case.shot(), &seen, &case.lights, &mut [umbrage::LightMask::default()]);
            let omitted = structure.omitted();
            let found = [&omitted.not_finite, &omitted.zero_area, &omitted.index_out_of_range].map(|kind| kind.count);
            wrong += u32::from(found != expected);
        }
        omitted_in_all.iter_mut().zip(expected).for_each(|(all, more)| *all += u64::from(more));
    }
    let [not_finite, zero_area, out_of_range] = omitted_in_all.map(number);
    let text = format!(
        "{wrong} wrong counts in {} random scenes and {} structures and options: {not_finite} triangles that aren't finite, \
         {zero_area} without an area and {out_of_range} with indices out of range were left out and counted, each with its \
         reason. No panic.",
        number(scenes),
        STRUCTURES.len()
    );
    Ok(Finding::new(wrong == 0, text))
}

pub(super) fn identical(effort: &Effort) -> Result<Finding> {
    const SIDE: u32 = 64;
    let camera = Camera::look_at(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, Vec3::Y, 0.9);
    let counts = [effort.of(10_000).max(500), effort.of(100_000).max(1000)];
    let mut text = format!(
        "One triangle over much of {SIDE}×{SIDE} pixels, so many times, with a light: milliseconds of a frame, and \
         kilobytes that the structure holds.\n\n| structure | 1 | {} | {} |\n|---|---|---|---|\n",
        number(counts[0]),
        number(counts[1])
    );
    let mut holds = true;
    for (name, structure) in choices() {
        let settings = Settings { width: SIDE, height: SIDE, camera: camera.into(), structure, ..Settings::default() };
        let mut line = format!("| {name} |");
        let mut first = None;
        for count in [1, counts[0], counts[1]] {
            let mut mesh = TestMesh::default();
            for _ in 0..count {
                mesh.push([Vec3::new(-2.0, -1.5, 0.0), Vec3::new(2.0, -1.5, 0.3), Vec3::new(0.0, 2.0, -0.2)]);
            }
            let (mut renderer, frame) = (Renderer::default(), frame(mesh, Vec3::new(1.0, 2.0, 3.0)));
            renderer.render_frame(&frame, &settings)?;
            let started = Instant::now();
            renderer.render_frame(&frame, &settings)?;
            let milliseconds = 1e3 * started.elapsed().as_secs_f64();
            let bytes = renderer.stats().structure_bytes;
            let answers = (renderer.film().triangle.clone(), renderer.light_masks().to_vec());
            holds &= milliseconds < 50.0 + 1e-3 * count as f64;
            ensure!(*first.get_or_insert_with(|| answers.clone()) == answers, "{name}: {count} aren't seen as one is");
            line += &format!(" {milliseconds:.1}, {} |", bytes / 1024);
        }
        text += &(line + "\n");
    }
    Ok(Finding::new(holds, text.trim_end()))
}

pub(super) fn files(effort: &Effort) -> Result<Finding> {
    let targets = ["gltf", "glb", "obj", "ply", "stl", "sequence", "pc2", "mdd", "images", "pose"];
    let mut finding = fuzzed("damaged files, and moments to pose them at", &targets, effort.of(20_000), effort)?;
    finding.text += AT_LENGTH;
    Ok(finding)
}

/// Runs that take an hour, with their last figures.
const AT_LENGTH: &str = "\n\nBesides, each reader of models and pictures had ten minutes of `fuzz --minutes 10 --seed 20261129 \
                         --target NAME` on 29 November 2026, beside other work: 67 796 mutants of gltf, 532 204 of glb, \
                         1 100 714 of obj, 2 275 735 of ply, 1 515 590 of stl and 324 284 of images, without a finding.";

pub(super) fn command_lines(effort: &Effort) -> Result<Finding> {
    let targets = ["options", "api", "command"];
    fuzzed(
        "texts of options, frames and settings for the library, and command lines",
        &targets,
        effort.of(2_000),
        effort,
    )
}

/// Runs the program `fuzz` with this many mutants of some targets.
fn fuzzed(what: &str, targets: &[&str], mutants: u64, effort: &Effort) -> Result<Finding> {
    let program = std::env::current_exe()?.with_file_name("fuzz");
    if !program.exists() {
        let how = "Not asked: build the program first, `cargo build --release -p umbrage-verify -p umbrage-cli`.";
        return Ok(Finding::new(false, how));
    }
    let mut command = Command::new(program);
    command.args(["--mutants", &mutants.to_string(), "--seed", &effort.seed.to_string()]);
    command.args(targets.iter().flat_map(|target| ["--target", target]));
    let output = command.output().context("the program `fuzz`")?;
    let said = String::from_utf8(output.stdout)?;
    // Each target's line ends with its numbers of accepted and of refused mutants, and of findings.
    let mut rows = String::new();
    for target in targets {
        let line = said.lines().find(|line| line.starts_with(&format!("{target}: --seed")));
        let (_, answers) = line.and_then(|line| line.rsplit_once(": ")).with_context(|| format!("{target}: {said}"))?;
        let counts: Vec<&str> = answers.split(", ").filter_map(|count| count.split(' ').next()).collect();
        rows += &format!("| {target} | {} |\n", counts.join(" | "));
    }
    let text = format!(
        "{} mutants of each kind of {what}: nothing may panic, take 20 s or 1.5 GiB, or be accepted and then be \
         nonsense.\n\n| | accepted | refused | findings |\n|---|---|---|---|\n{}",
        number(mutants),
        rows.trim_end()
    );
    Ok(Finding::new(output.status.success(), text))
}
