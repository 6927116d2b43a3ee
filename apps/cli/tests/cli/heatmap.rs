//! `umbrage heatmap`: its files and messages.

use crate::support::{Workplace, decode_png};

#[test]
fn a_heat_map_shows_where_the_work_is() {
    let place = Workplace::new();
    for structure in ["listed", "perspective"] {
        let (stdout, _) =
            place.succeed(&["heatmap", "scene.gltf", "--time", "0", "--size", "100x80", "--structure", structure]);
        let lines: Vec<&str> = stdout.lines().collect();
        assert_eq!(lines.len(), 4, "{stdout}");
        assert!(lines[0].starts_with("triangles tested") && lines[0].ends_with("max 1"), "{stdout}");
        assert!(lines[1].starts_with("cells visited") && lines[1].ends_with("max 1"), "{stdout}");
        assert!(lines[3].starts_with("pairs per tile") && lines[3].ends_with("max 1"), "{stdout}");
        assert_eq!(place.names(), ["heatmap.png"]);
        let pixels = decode_png(&place.path("heatmap.png"));
        assert!(pixels.len() > 100 * 80 && pixels.len().is_multiple_of(100));
        // The one triangle is in the middle, and the upper corners are far from it.
        assert_eq!((pixels[0], pixels[99]), ([0; 3], [0; 3]));
        assert_eq!(pixels[45 * 100 + 50], [255, 240, 72]);
    }
}

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
fn pairs_and_points_are_shown_by_cell() {
    let place = Workplace::new();
    let fixed = ["heatmap", "scene.gltf", "--time", "0", "--size", "128x128", "--max", "4000", "-o", "map.png"];
    let pixels = |flags: &[&str]| {
        let (stdout, _) = place.succeed(&[&fixed, flags].concat());
        (stdout, decode_png(&place.path("map.png")))
    };
    // The triangle is listed in all tiles that it reaches, here all four, and counts at their pixels beside it too.
    let (_, pairs) = pixels(&["--of", "pairs", "--structure", "perspective"]);
    assert!(pairs[..128 * 128].iter().all(|pixel| *pixel == pairs[0] && *pixel != [0; 3]));
    let (_, tested) = pixels(&["--of", "tested", "--structure", "perspective"]);
    assert_eq!(tested[0], [0; 3]);
    for structure in ["listed", "perspective"] {
        let (stdout, points) = pixels(&["--of", "points", "--light", "0", "--structure", structure]);
        assert!(stdout.lines().last().unwrap().starts_with("points per light cell  min 0 "), "{stdout}");
        assert_eq!(points[0], [0; 3], "no point, no cell");
        assert_ne!(points[64 * 128 + 64], [0; 3]);
        assert_eq!(pixels(&["--of", "points", "--structure", structure]).1, points, "the first light is the default");
    }
}

#[test]
fn lights_that_have_no_map_are_refused() {
    let place = Workplace::new();
    let refused = |flags: &[&str]| place.fail(2, &[&["heatmap", "scene.gltf"], flags].concat());
    assert!(refused(&["--light", "0"]).contains("--of points"));
    let message = refused(&["--of", "points", "--light", "7"]);
    assert!(message.contains("no light 7") && message.contains("`umbrage info`"), "{message}");
    assert!(refused(&["--of", "points", "--light", "lamp"]).contains("--light"));
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
