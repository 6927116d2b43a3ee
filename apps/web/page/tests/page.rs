//! The page's studio, on this machine: looks of a scene, and what can't be opened.
#![allow(clippy::unwrap_used, reason = "a test may fail")]

use umbrage_page::{Look, Shown, Studio};

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
    let [x, y, z] = shown.light.unwrap();
    render(&mut studio, &Look { light: Some([x, y, z]), ..look() }).unwrap();
    assert_eq!(studio.proof(), proof);
    render(&mut studio, &Look { light: Some([-x, y, -z]), ..look() }).unwrap();
    assert_eq!(studio.proof().triangles, proof.triangles);
    assert_ne!(studio.proof().masks, proof.masks);
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
