//! The page's studio, on this machine: looks of a scene, and files that can't be opened.
#![allow(clippy::unwrap_used, reason = "a test may fail")]

use umbrage_page::{Look, LookAt, Shown, Studio};

fn look() -> Look {
    Look { width: 64, height: 48, ..Look::default() }
}

fn render(studio: &mut Studio, look: &Look) -> Result<Shown, String> {
    pollster::block_on(studio.render(look))
}

fn with_demo() -> Studio {
    let mut studio = Studio::default();
    studio.open_demo("demo:marbles?triangles=2000").unwrap();
    studio
}

#[test]
fn a_look_of_the_camera_that_was_shown_is_the_same_picture() {
    let mut studio = with_demo();
    let shown = render(&mut studio, &look()).unwrap();
    let picture = studio.pixels().to_vec();
    assert!(picture.len() == 64 * 48 * 4 && picture.chunks_exact(4).any(|pixel| pixel != &picture[..4]));
    render(&mut studio, &Look { camera: Some(shown.camera), ..look() }).unwrap();
    let differing = picture.iter().zip(studio.pixels()).filter(|(a, b)| a != b).count();
    assert!(differing < picture.len() / 100, "{differing} bytes differ");
}

#[test]
fn a_light_that_stays_changes_nothing_and_one_that_moves_does() {
    let mut studio = with_demo();
    let shown = render(&mut studio, &look()).unwrap();
    let proof = studio.proof();
    assert!(shown.lights.len() > 1);
    for (number, light) in shown.lights.iter().enumerate() {
        let [x, y, z] = light.position;
        let with_light = |position| {
            let mut lights = vec![None; number];
            lights.push(Some(position));
            Look { lights, ..look() }
        };
        render(&mut studio, &with_light([x, y, z])).unwrap();
        assert_eq!(studio.proof(), proof);
        let moved = render(&mut studio, &with_light([-x, y, -z])).unwrap();
        assert_eq!(studio.proof().triangles, proof.triangles);
        assert_ne!(studio.proof().masks, proof.masks);
        // The light's flag has its new position.
        assert_ne!(moved.lights[number].spec, light.spec);
        assert!(moved.lights[number].spec.is_some());
    }
}

#[test]
fn narrow_pictures_show_as_much_to_the_sides() {
    let mut studio = with_demo();
    let tall = Look { width: 48, height: 96, ..look() };
    let (wide, narrow) = (render(&mut studio, &look()).unwrap(), render(&mut studio, &tall).unwrap());
    let to_the_side = |shown: &Shown, aspect: f32| (0.5 * shown.camera.fov_degrees).to_radians().tan() * aspect;
    // As wide as a picture of 5:4.
    let [expected, found] = [to_the_side(&wide, 1.25), to_the_side(&narrow, 0.5)];
    assert!((expected - found).abs() < 1e-3 && narrow.is_widened && !wide.is_widened, "{expected} {found}");
    // A chosen camera isn't widened.
    let own = render(&mut studio, &Look { camera: Some(wide.camera), ..tall }).unwrap();
    assert!(!own.is_widened && (own.camera.fov_degrees - wide.camera.fov_degrees).abs() < 1e-3);
}

/// A square of a grey, as far from white as `--exposure auto` has to bring it.
fn grey_square() -> Studio {
    let mut studio = Studio::default();
    let file = |name: &str, text: &str| (name.to_owned(), text.as_bytes().to_vec());
    let files = [
        file("a.mtl", "newmtl grey\nKd 0.02 0.02 0.02\n"),
        file("a.obj", "mtllib a.mtl\nusemtl grey\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"),
    ];
    studio.open_files("a.obj", files).unwrap();
    studio
}

#[test]
fn files_are_measured_once_and_exposures_of_ones_own_are_kept() {
    let mut studio = grey_square();
    let metered = render(&mut studio, &look()).unwrap().exposure_stops;
    assert!(metered > 0.1, "{metered}");
    let picture = studio.pixels().to_vec();
    let near = LookAt { position: [0.5, 0.5, 0.2], target: [0.5, 0.5, 0.0], fov_degrees: 40.0 };
    assert_eq!(render(&mut studio, &Look { camera: Some(near), ..look() }).unwrap().exposure_stops, metered);
    assert_eq!(render(&mut studio, &Look { exposure_stops: Some(-1.0), ..look() }).unwrap().exposure_stops, -1.0);
    let sum = |pixels: &[u8]| pixels.iter().map(|&level| u64::from(level)).sum::<u64>();
    assert!(sum(studio.pixels()) < sum(&picture));
    // Scenes of the gallery are lit for no exposure.
    assert_eq!(render(&mut with_demo(), &look()).unwrap().exposure_stops, 0.0);
}

#[test]
fn backgrounds_are_the_sky_or_a_colour() {
    let mut studio = grey_square();
    render(&mut studio, &Look { background: "#ff0000".to_owned(), ..look() }).unwrap();
    assert_eq!(studio.pixels()[..4], [255, 0, 0, 255]);
    for background in ["none", "a.hdr", "#12"] {
        let error = render(&mut studio, &Look { background: background.to_owned(), ..look() }).unwrap_err();
        assert!(error.contains("#203040"), "{error}");
    }
}

#[test]
fn every_heat_map_has_colours() {
    let mut studio = with_demo();
    for heat in ["tested", "cells", "undecided", "pairs", "points"] {
        let shown = render(&mut studio, &Look { heat: Some(heat.to_owned()), ..look() }).unwrap();
        assert!(shown.heat.is_some_and(|(_, top)| top > 0), "{heat}");
    }
    let error = render(&mut studio, &Look { heat: Some("warmth".to_owned()), ..look() }).unwrap_err();
    assert!(error.contains("warmth") && error.contains("tested"), "{error}");
}

#[test]
fn what_cannot_be_opened_leaves_the_last_scene() {
    let mut studio = with_demo();
    assert!(studio.open_demo("demo:nothing").unwrap_err().contains("marbles"));
    let broken = [("a.glb".to_owned(), b"glTF but not really".to_vec())];
    assert!(studio.open_files("a.glb", broken).unwrap_err().starts_with("a.glb: "));
    render(&mut studio, &look()).unwrap();
    let triangle = [("a.obj".to_owned(), b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec())];
    studio.open_files("a.obj", triangle).unwrap();
    assert_eq!(render(&mut studio, &look()).unwrap().triangles, 1);
    assert!(render(&mut Studio::default(), &look()).is_err());
}
