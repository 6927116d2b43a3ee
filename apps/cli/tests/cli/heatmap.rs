//! `umbrage heatmap`: its files and messages.

use crate::support::{Workplace, decode_png};

/// The structures of heat maps.
const STRUCTURES: &[&str] = if cfg!(feature = "papers") { &["listed", "perspective"] } else { &["perspective"] };

#[test]
fn a_heat_map_shows_where_the_work_is() {
    let place = Workplace::new();
    for structure in STRUCTURES {
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
    for structure in STRUCTURES {
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
