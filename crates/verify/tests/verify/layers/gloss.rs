//! Layers with followed reflections of microfacets.

use umbrage::Panorama;

use super::*;

/// The mean radiance of a square from some direction, with followed rays from its microfacets.
fn drawn(frame: &Frame, view: DVec3, background: &Background, samples: u32) -> DVec3 {
    let up = if view.z > 0.99 { Vec3::Y } else { Vec3::Z };
    let camera = Camera::look_at((view * 4.0).as_vec3(), Vec3::ZERO, up, 0.1);
    let camera = Camera { projection: Projection::Orthographic { half_height: 1e-3 }, ..camera };
    let settings = Settings {
        width: 4,
        height: 4,
        samples,
        bounces: 1,
        gloss: true,
        least_contribution: 0.0,
        camera: camera.into(),
        background: background.clone(),
        lights: Some(Vec::new()),
        ..Settings::default()
    };
    let film = Renderer::default().render_frame(frame, &settings).expect("a frame").clone();
    film.color.iter().map(|color| color.truncate().as_dvec3()).sum::<DVec3>() / 16.0
}

#[test]
fn what_layers_mirror_is_what_suns_light_there() {
    // White where x < 0, black elsewhere: −Z is in the middle of the image.
    let texels = (0..512 * 256).map(|texel| if texel % 512 < 256 { Vec3::ONE } else { Vec3::ZERO }).collect();
    let half = Background::Image(Arc::new(Panorama::new(512, 256, texels).expect("a panorama")));
    let metal = |roughness| Material { metallic: 1.0, ..plain(Vec3::new(0.9, 0.7, 0.4), roughness) };
    let black = |roughness| plain(Vec3::ZERO, roughness);
    let specular =
        |factor, color| Layers { specular: Specular { factor, color, ..Specular::default() }, ..Layers::default() };
    let on_top = |layers: Layers| Layers { clearcoat: coat(1.0, 0.6).clearcoat, ..layers };
    let mut largest = 0.0_f64;
    for (name, material) in [
        ("half as strong", layered(black(0.6), specular(0.5, Vec3::ONE))),
        ("coloured", layered(black(0.4), specular(1.0, Vec3::new(20.0, 8.0, 2.0)))),
        ("stretched", layered(metal(0.3), stretch(0.8, 0.0))),
        ("stretched aslant", layered(metal(0.3), stretch(0.9, 1.0))),
        ("a film", layered(black(0.5), film(1.4, 400.0))),
        ("a film on metal", layered(metal(0.5), film(1.8, 250.0))),
        ("lacquer", nothing_below(coat(1.0, 0.5))),
        ("lacquer on metal", layered(metal(0.4), coat(1.0, 0.6))),
        (
            "all of them",
            layered(metal(0.4), on_top(Layers { anisotropy: stretch(0.7, 0.5).anisotropy, ..film(1.6, 420.0) })),
        ),
    ] {
        // Narrower highlights are too narrow for this number of suns at grazing views.
        let lowest = if material.roughness < 0.5 { 0.3 } else { 0.15 };
        for view in [direction(0.9, 30.0), direction(0.5, 200.0), direction(0.3, 100.0), direction(lowest, 10.0)] {
            let expected = under_some_suns(&material, view, |from| from.x < 0.0);
            let drawn = drawn(&square(&material), view, &half, 1024);
            println!("{name} from {view:.2}: {drawn:.4}, {expected:.4}");
            largest = largest.max((drawn - expected).abs().max_element());
        }
    }
    println!("off by {largest:.4} at most");
    assert!(largest < 0.01, "off by {largest}");
}

#[test]
fn layers_that_are_followed_are_as_bright_under_white_surroundings() {
    for (name, material) in white_ones().into_iter().filter(|(_, material)| material.roughness > 0.5) {
        let smooth = Material { roughness: 0.0, ..material.clone() };
        let mut below_a_mirror = material.clone();
        below_a_mirror.layers.as_mut().expect("layers").clearcoat = coat(0.8, 0.0).clearcoat;
        // The table of isotropic lobes lacks the energy loss between the facets of smooth grooves.
        let is_stretched = material.layers.as_ref().is_some_and(|layers| layers.anisotropy.strength > 0.0);
        let kinds = [("", material), ("below a mirror ", below_a_mirror), ("smooth ", smooth)];
        for (kind, material) in kinds.into_iter().take(if is_stretched { 2 } else { 3 }) {
            for cosine in [1.0, 0.5] {
                let view = direction(cosine, 30.0);
                let once = radiance(&material, view, Vec::new(), WHITE);
                let followed = drawn(&square(&material), view, &WHITE, 128);
                // For grooves, the table has an isotropic highlight of the same area.
                let tolerance = if is_stretched { 0.065 } else { 0.02 };
                expect_near(followed, once, tolerance, &format!("{kind}{name}, {cosine}"));
            }
        }
    }
}

#[test]
fn bumps_that_mirror_into_their_triangle_are_not_black() {
    let metal = Material { metallic: 1.0, ..plain(Vec3::ONE, 0.3) };
    let mut frame = square(&metal);
    // Nearly away from the view, so that most of the mirrored directions are below.
    frame.normals = vec![direction(0.9, 180.0).as_vec3(); 4];
    let shown = drawn(&frame, direction(0.5, 0.0), &WHITE, 64);
    assert!((0.9..1.01).contains(&shown.x), "{shown}");
}
