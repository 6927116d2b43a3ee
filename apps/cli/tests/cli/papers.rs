//! The papers' structures and their options.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use crate::support::{Workplace, decode_png};

#[test]
fn smaller_tiles_test_fewer_triangles() {
    let place = Workplace::new();
    let mean = |flags: &[&str]| {
        let fixed = ["heatmap", "demo:statue?triangles=3000", "--size", "200x200", "--max", "20", "-o", "map.png"];
        let (stdout, _) = place.succeed(&[&fixed, flags].concat());
        let tested = stdout.lines().next().unwrap();
        tested.split_whitespace().nth(5).unwrap().parse::<f64>().unwrap()
    };
    let tile = |pixels: &str| mean(&["--structure", &format!("listed:whole-tiles,sorting-tile={pixels}")]);
    assert!(tile("8") < 0.7 * tile("32"));
    assert!(mean(&["--structure", "listed:sorting-tile=8"]) < tile("8"));
}

#[test]
fn impossible_cells_are_refused() {
    let place = Workplace::new();
    let refused = |flags: &[&str]| place.fail(2, &[&["heatmap", "scene.gltf"], flags].concat());
    let options = |options: &str| refused(&["--structure", &format!("listed:{options}")]);
    assert!(options("sorting-tile=9").contains("choose one of 8, 16, 32, 64"));
    assert!(options("sorting-tile=0").contains("choose one of 8, 16, 32, 64"));
    assert!(options("sorting-tile=64,tracing-tiles=2").contains("at most 64"));
    assert!(options("slices=65").contains("1 to 64"));
    assert!(refused(&["--structure", "perspective:slices=2"]).contains("has no options"));
    assert!(refused(&["--structure", "kdtree"]).contains("choose one of perspective, listed"));
    assert!(refused(&["--slices", "2"]).contains("--structure listed:slices=2"));
}

#[test]
fn info_builds_a_tree_where_that_is_asked_for() {
    let place = Workplace::new();
    let scene = ["info", "demo:cloth?triangles=300"];
    let (stdout, _) = place.succeed(&[&scene[..], &["--structure", "kdtree:builder=presorted"]].concat());
    for name in ["presorted builder", "depth", "leaves", "references", "SAH cost", "memory"] {
        assert!(stdout.contains(name), "{name} in {stdout}");
    }
    let (stdout, _) = place.succeed(&[&scene[..], &["--structure", "kdtree", "--json"]].concat());
    let contents: serde_json::Value = serde_json::from_str(&stdout).expect("JSON");
    let tree = &contents["structure"];
    let number = |name: &str| tree[name].as_f64().unwrap_or_default();
    // A binary tree with all triangles in its leaves.
    assert_eq!(number("nodes"), 2.0 * number("leaves") - 1.0, "{tree}");
    assert!(number("references") >= contents["triangles"].as_f64().unwrap_or(f64::MAX), "{tree}");
    assert!(number("sah_cost") > 1.0 && number("depth") > 3.0, "{tree}");
    let (stdout, _) = place.succeed(&[&scene[..], &["--json"]].concat());
    assert!(!stdout.contains("sah_cost"), "{stdout}");
    assert!(place.fail(2, &[&scene[..], &["--kd-layout", "subtrees"]].concat()).contains("kdtree:layout=subtrees"));
    assert!(place.fail(2, &[&scene[..], &["--structure", "bvh"]].concat()).contains("choose one of kdtree"));
}

#[test]
fn structures_are_listed_with_their_options() {
    let place = Workplace::new();
    let (stdout, _) = place.succeed(&["structures"]);
    for name in ["perspective", "bvh", "listed", "grid", "kdtree"] {
        assert!(stdout.lines().any(|line| line.starts_with(&format!("{name} "))), "{name} in {stdout}");
    }
    let (stdout, _) = place.succeed(&["structures", "kdtree"]);
    for part in ["Paper: Horn", "\nbuilder=binned\n", "short-stack:4", "\nlazy=0\n", "a whole number from 0 to 4096"] {
        assert!(stdout.contains(part), "{part} in {stdout}");
    }
    assert!(place.succeed(&["structures", "bvh"]).0.contains("It has no options"));
    assert!(place.fail(2, &["structures", "kdtre"]).contains("did you mean `kdtree`?"));
}

#[test]
fn blocks_of_light_rays_change_no_pixel() {
    let place = Workplace::new();
    let render = |name: &str, flags: &[&str]| {
        let fixed = ["render", "demo:marbles?triangles=800", "--size", "40x30", "-o", name];
        place.succeed(&[&fixed, flags].concat());
        decode_png(&place.path(name))
    };
    let first = render("a.png", &["--structure", "listed"]);
    let blocks = "listed:light-cells=9,light-rays=16,light-triangles=3";
    assert_eq!(render("b.png", &["--structure", blocks]), first);
    let refused = |flags: &[&str]| place.fail(2, &[&["render", "scene.gltf"], flags].concat());
    assert!(refused(&["--light-rays", "16"]).contains("--structure listed:light-rays=16"));
    let clamp = "listed:light-clamp=-30:30:-20:20";
    assert!(refused(&["--structure", clamp]).contains("only a spherical light map has"));
    assert!(refused(&["--structure", "listed:light-cells=0"]).contains("1 to 2048"));
    assert!(refused(&["--structure", "listed:light-rays=5000"]).contains("1 to 4096"));
    assert!(refused(&["--structure", "lisetd"]).contains("did you mean `listed`?"));
    assert!(refused(&["--structure", "listed:light-cell=9"]).contains("did you mean `light-cells`?"));
}

#[test]
fn kd_trees_change_no_pixel() {
    let place = Workplace::new();
    let render = |flags: &[&str]| {
        let fixed = ["render", "demo:glass?triangles=800", "--size", "40x30", "--bounces", "2", "-o", "a.png"];
        place.succeed(&[&fixed, flags].concat());
        decode_png(&place.path("a.png"))
    };
    let first = render(&[]);
    for options in [
        "builder=naive,layout=subtrees",
        "traversal=short-stack:3,lazy=100",
        "traversal=restart,packet=8,mailbox=ring,clipping=boxes",
        "packet=4,step-cost=3,test-cost=0.5,empty-cost=0,charge-twice",
    ] {
        assert_eq!(render(&["--structure", &format!("kdtree:{options}")]), first, "{options}");
    }
    let refused = |flags: &[&str]| place.fail(2, &[&["render", "scene.gltf"], flags].concat());
    let earlier = refused(&["--kd-traversal", "restart", "--kd-lazy=9"]);
    assert!(earlier.contains("--structure kdtree:traversal=restart,lazy=9"), "{earlier}");
    for (options, why) in [
        ("builder=best", "presorted"),
        ("traversal=short-stack:0", "1 to 48"),
        ("lazy=5000", "4096"),
        ("packet=5", "16"),
        ("empty-cost=1.1", "0 to 1"),
        ("test-cost=inf", "above 0"),
    ] {
        assert!(refused(&["--structure", &format!("kdtree:{options}")]).contains(why), "{options}");
    }
    for (structure, why) in [
        ("grid", "not `grid`"),
        ("listed:light-rays=16", "no option `light-rays`"),
        ("listed:sorting-tile=32", "8 or 16"),
        ("listed:tracing-tiles=2", "16 pixels a side"),
        ("kdtree:lazy=9", "no option `lazy`"),
        ("kdtree:mailbox=none", "no option `mailbox`"),
    ] {
        assert!(refused(&["--engine", "gpu", "--structure", structure]).contains(why), "{structure}");
    }
}

/// Values of the options that the table of techniques names without one.
const VALUES: [(&str, &str); 28] = [
    ("--bounces", "2"),
    ("--least-contribution", "0.1"),
    ("--light", "spot:0,3,3:0,0,0:60"),
    ("--texture-memory", "1MB"),
    ("grid:density", "2"),
    ("grid:insertion", "exact"),
    ("grid:macrocell", "2"),
    ("grid:nested", "16"),
    ("grid:spread", "2"),
    ("kdtree:builder", "spatial-median"),
    ("kdtree:clipping", "boxes"),
    ("kdtree:empty-cost", "0.5"),
    ("kdtree:failures", "1"),
    ("kdtree:lazy", "64"),
    ("kdtree:mailbox", "ring"),
    ("kdtree:packet", "8"),
    ("kdtree:rebuild", "two-level"),
    ("kdtree:traversal", "push-down"),
    ("kdtree:layout", "subtrees"),
    ("listed:camera-triangles", "32"),
    ("listed:light-clamp", "-30:30:-20:20,light-map=spherical"),
    ("listed:light-map", "spherical"),
    ("listed:light-rays", "16"),
    ("listed:light-slices", "4"),
    ("listed:light-triangles", "16"),
    ("listed:slices", "4"),
    ("listed:sorting-tile", "8"),
    ("listed:tracing-tiles", "2,sorting-tile=16"),
];

/// Ways to reach techniques by this program, as their table names them: commands, options of structures, and flags.
fn ways_of_the_papers() -> BTreeSet<String> {
    let document = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../crates/papers/docs/README.md");
    let document = fs::read_to_string(document).expect("the table of techniques");
    let cells = document.lines().filter(|line| line.starts_with('|')).filter_map(|row| row.split('|').nth(4));
    let words = cells.flat_map(|cell| cell.split('`').skip(1).step_by(2));
    let of_others = |word: &str| word.starts_with("umbrage-bench ") || word.contains("::");
    words.filter(|word| !of_others(word)).map(str::to_owned).collect()
}

/// The command that a way stands for, on a small scene, for flags that of a file; `picture.png` is its picture.
fn command_of(way: &str) -> Vec<String> {
    let with_value = |word: &str| match VALUES.iter().find(|(name, _)| *name == word) {
        Some((_, value)) if word.starts_with("--") => format!("{word} {value}"),
        Some((_, value)) => format!("{word}={value}"),
        None => word.to_owned(),
    };
    let is_flag = way.starts_with("--");
    let way = match way.split_once(' ') {
        Some(("umbrage", rest)) => rest.split(' ').map(with_value).collect::<Vec<_>>().join(" "),
        _ if is_flag => format!("render {}", with_value(way)),
        _ => format!("render --structure {}", with_value(way)),
    };
    let scene = if is_flag { "scene.gltf" } else { "demo:marbles?triangles=800" };
    format!("{way} {scene} --size 40x30 -o picture.png").split(' ').map(str::to_owned).collect()
}

#[test]
fn every_way_of_the_papers_runs() {
    let place = Workplace::new();
    let run = |way: &str| {
        let command = command_of(way);
        place.succeed(&command.iter().map(String::as_str).collect::<Vec<_>>());
        decode_png(&place.path("picture.png"))
    };
    let expected = run("umbrage render");
    let ways = ways_of_the_papers();
    assert!(ways.len() > 30, "{ways:?}");
    for way in ways.iter().filter(|way| !way.contains("--engine gpu")) {
        let picture = run(way);
        // No structure changes a picture.
        let is_other = way.starts_with("--") || way.contains("heatmap");
        assert!(is_other || picture == expected, "{way}");
    }
}

mod long {
    use super::{Workplace, command_of, ways_of_the_papers};

    #[test]
    fn every_way_of_the_papers_on_a_gpu_runs() {
        let place = Workplace::new();
        let ways = ways_of_the_papers().into_iter().filter(|way| way.contains("--engine gpu")).collect::<Vec<_>>();
        assert_eq!(ways.len(), 3, "{ways:?}");
        if place.run(&["info", "--devices"]).stdout.is_empty() {
            return eprintln!("not run: no adapter");
        }
        for way in ways {
            place.succeed(&command_of(&way).iter().map(String::as_str).collect::<Vec<_>>());
        }
    }
}
