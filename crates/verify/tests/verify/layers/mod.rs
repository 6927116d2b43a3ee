//! glTF's further layers of materials: against their formulas in f64, under even light, and switched off.

mod gloss;
mod reference;

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3, Vec4};
use umbrage::rays::{Camera, LightSource, Projection, SimdLevel};
use umbrage::scene::{
    Anisotropy, Clearcoat, Frame, Iridescence, Layers, Light, Material, Materials, Mesh, Sheen, Specular,
};
use umbrage::{Background, Film, Renderer, Settings};

const BLACK: Background = Background::Color(Vec3::ZERO);
const WHITE: Background = Background::Color(Vec3::ONE);

/// A dielectric material of some colour.
fn plain(color: Vec3, roughness: f32) -> Material {
    Material { base_color: color.extend(1.0), roughness, double_sided: true, ..Material::default() }
}

fn layered(material: Material, layers: Layers) -> Material {
    Material { layers: Some(Box::new(layers)), ..material }
}

fn no_specular() -> Specular {
    Specular { factor: 0.0, ..Specular::default() }
}

/// A base without any reflection, below some layers.
fn nothing_below(layers: Layers) -> Material {
    layered(plain(Vec3::ZERO, 0.5), Layers { specular: no_specular(), ..layers })
}

fn coat(factor: f32, roughness: f32) -> Layers {
    Layers { clearcoat: Clearcoat { factor, roughness, ..Clearcoat::default() }, ..Layers::default() }
}

fn sheen(color: Vec3, roughness: f32) -> Layers {
    Layers { sheen: Sheen { color, roughness, ..Sheen::default() }, ..Layers::default() }
}

fn stretch(strength: f32, rotation_radians: f32) -> Layers {
    Layers { anisotropy: Anisotropy { strength, rotation_radians, texture: None }, ..Layers::default() }
}

fn film(ior: f32, nanometers: f32) -> Layers {
    let thickness_maximum_nanometers = nanometers;
    let iridescence = Iridescence { factor: 1.0, ior, thickness_maximum_nanometers, ..Iridescence::default() };
    Layers { iridescence, ..Layers::default() }
}

fn direction(cosine: f64, turn_degrees: f64) -> DVec3 {
    let (sin, cos) = turn_degrees.to_radians().sin_cos();
    DVec3::new(cos, sin, 0.0) * (1.0 - cosine * cosine).sqrt() + DVec3::Z * cosine
}

/// Parallel light from a direction, with irradiance `intensity` on a surface that faces it.
fn sun(from: DVec3, intensity: f64) -> Light {
    Light {
        casts_shadow: false,
        ..Light::new(LightSource::Directional { direction: (-from).as_vec3() }, intensity as f32)
    }
}

/// A square in the plane z = 0 with tangents along x.
fn square(material: &Material) -> Frame {
    let corners = [Vec2::new(-1.0, -1.0), Vec2::new(1.0, -1.0), Vec2::new(1.0, 1.0), Vec2::new(-1.0, 1.0)];
    let mut frame = Frame::from_triangles(corners.map(|at| at.extend(0.0)).to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
    frame.tangents = vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4];
    frame.materials = Arc::new(Materials { materials: vec![material.clone()], textures: Vec::new() });
    frame
}

/// Radiance of a square towards some direction.
fn radiance(material: &Material, view: DVec3, lights: Vec<Light>, background: Background) -> DVec3 {
    shown(&Frame { lights, ..square(material) }, view, background, 0)
}

/// Radiance at a frame's origin towards some direction.
fn shown(frame: &Frame, view: DVec3, background: Background, bounces: u32) -> DVec3 {
    let up = if view.z > 0.99 { Vec3::Y } else { Vec3::Z };
    let camera = Camera::look_at((view * 4.0).as_vec3(), Vec3::ZERO, up, 0.1);
    let camera = Camera { projection: Projection::Orthographic { half_height: 1e-3 }, ..camera };
    let settings = Settings { width: 4, height: 4, camera: camera.into(), background, bounces, ..Settings::default() };
    let film = Renderer::default().render_frame(frame, &settings).expect("a frame").clone();
    assert!(film.triangle.iter().all(|&triangle| triangle != Film::NO_TRIANGLE));
    film.color[5].truncate().as_dvec3()
}

/// Radiance for each unit of irradiance of a surface that faces the light.
fn lit(material: &Material, view: DVec3, light: DVec3) -> DVec3 {
    radiance(material, view, vec![sun(light, 1.0)], BLACK)
}

/// Radiance under light of radiance 1 from everywhere, made of many suns.
fn under_suns(material: &Material, view: DVec3) -> DVec3 {
    under_some_suns(material, view, |_| true)
}

/// Radiance under the suns in some directions.
fn under_some_suns(material: &Material, view: DVec3, is_there: impl Fn(DVec3) -> bool) -> DVec3 {
    const RINGS: usize = 64;
    const STEPS: usize = 128;
    let light = |ring: usize, step: usize| {
        // Cosines are squares, so that there are many suns near the horizon, where sheen and coat reflect most.
        let root = (ring as f64 + 0.5) / RINGS as f64;
        let angle = (step as f64 + 0.5) / STEPS as f64 * 360.0;
        (direction(root * root, angle), 4.0 * PI * root / (RINGS * STEPS) as f64)
    };
    let all = (0..RINGS).flat_map(|ring| (0..STEPS).map(move |step| light(ring, step)));
    let lights = all.filter(|(from, _)| is_there(*from)).map(|(from, intensity)| sun(from, intensity)).collect();
    radiance(material, view, lights, BLACK)
}

/// Views and lights from steep to grazing, on the same side and on opposite ones.
fn pairs() -> impl Iterator<Item = (DVec3, DVec3)> {
    let views = [(0.95, 0.0), (0.6, 0.0), (0.3, 70.0)].map(|(cosine, turn)| direction(cosine, turn));
    let lights = [(0.9, 20.0), (0.6, 180.0), (0.35, 240.0), (0.2, 10.0)].map(|(cosine, turn)| direction(cosine, turn));
    views.into_iter().flat_map(move |view| lights.map(|light| (view, light)))
}

#[track_caller]
fn expect_near(got: DVec3, expected: DVec3, tolerance: f64, of: &str) {
    let difference = (got - expected).abs().max_element();
    assert!(difference <= tolerance * expected.max_element() + 1e-6, "{of}: {got}, not {expected}");
}

#[test]
fn lacquer_is_as_its_formula_says() {
    for (view, light) in pairs() {
        let part = |factor: f64| factor * reference::schlick(0.04, 1.0, view.z);
        let of = format!("{view} {light}");
        for roughness in [0.2, 0.6] {
            let lobe = reference::ggx(roughness, view, light) * light.z;
            let got = lit(&nothing_below(coat(0.7, roughness as f32)), view, light);
            expect_near(got, DVec3::splat(part(0.7) * lobe), 1e-4, &of);
        }
        // The coat dims the layers below it, and emission.
        let color = Vec3::new(0.8, 0.5, 0.2);
        let below = layered(plain(color, 0.5), Layers { specular: no_specular(), ..coat(0.7, 0.3) });
        let base = color.as_dvec3() / PI * light.z * (1.0 - part(0.7));
        let lobe = part(0.7) * reference::ggx(0.3, view, light) * light.z;
        expect_near(lit(&below, view, light), base + lobe, 1e-4, &of);
        let glowing = Material { emissive: Vec3::new(2.0, 1.0, 0.5), ..nothing_below(coat(1.0, 0.3)) };
        let expected = DVec3::new(2.0, 1.0, 0.5) * (1.0 - part(1.0));
        expect_near(radiance(&glowing, view, Vec::new(), BLACK), expected, 1e-5, &of);
    }
}

#[test]
fn sheen_is_as_its_formula_says() {
    let color = Vec3::new(0.9, 0.4, 0.1);
    for (view, light) in pairs() {
        for roughness in [0.3, 0.7, 1.0] {
            let of = format!("roughness {roughness}, {view} {light}");
            let lobe = color.as_dvec3() * (reference::charlie(roughness, view, light) * light.z);
            expect_near(lit(&nothing_below(sheen(color, roughness as f32)), view, light), lobe, 1e-4, &of);
            // The table has the integral to about a hundredth.
            let whole = reference::albedo(|light| reference::charlie(roughness, view, light));
            let base =
                layered(plain(Vec3::ONE, 0.5), Layers { specular: no_specular(), ..sheen(color, roughness as f32) });
            let expected = lobe + light.z / PI * (1.0 - 0.9 * whole);
            expect_near(lit(&base, view, light), expected, 0.015, &of);
        }
    }
}

#[test]
fn stretched_highlights_are_as_their_formula_says() {
    // Black metal: its reflection is Fresnel's term with no reflection at normal incidence.
    for (roughness, strength, rotation) in [(0.3, 0.0, 0.0), (0.3, 0.5, 0.0), (0.4, 0.9, 0.7), (0.6, 1.0, -2.0)] {
        for (view, light) in pairs() {
            let metal = Material { metallic: 1.0, ..plain(Vec3::ZERO, roughness as f32) };
            let metal = layered(metal, stretch(strength as f32, rotation as f32));
            let fresnel = reference::schlick(0.0, 1.0, view.dot((view + light).normalize()));
            let lobe = reference::stretched_ggx(roughness, strength, rotation, view, light);
            let expected = DVec3::splat(fresnel * lobe * light.z);
            expect_near(lit(&metal, view, light), expected, 1e-3, &format!("{roughness} {strength} {view} {light}"));
        }
    }
}

/// Factor by which light that bounces between microfacets raises a lobe with this reflectance at normal incidence.
fn scattered_again(f0: f64, roughness: f64, view: DVec3) -> f64 {
    1.0 + f0 * (1.0 / reference::albedo(|light| reference::ggx(roughness, view, light)) - 1.0)
}

#[test]
fn mirrored_colours_are_as_their_formula_says() {
    let (factor, color, roughness) = (0.6, Vec3::new(8.0, 3.0, 0.0), 0.4);
    for (view, light) in pairs() {
        for ior in [1.5, 2.0, 0.0] {
            let specular = Specular { factor, color, ..Specular::default() };
            let material = Material { ior, ..plain(Vec3::ZERO, roughness as f32) };
            let material = layered(material, Layers { specular, ..Layers::default() });
            let ahead = ((f64::from(ior) - 1.0) / (f64::from(ior) + 1.0)).powi(2);
            let expected = color.as_dvec3().map(|color| {
                let f0 = (ahead * color).min(1.0) * f64::from(factor);
                let fresnel = reference::schlick(f0, f64::from(factor), view.dot((view + light).normalize()));
                let lobe = reference::ggx(roughness, view, light) * light.z;
                fresnel * lobe * scattered_again(f0, roughness, view)
            });
            // Multiple scattering comes from a table that is right to about a hundredth.
            expect_near(lit(&material, view, light), expected, 0.015, &format!("ior {ior}, {view} {light}"));
        }
    }
}

#[test]
fn films_are_as_their_formula_says() {
    let roughness = 0.3;
    for (color, metallic) in [(Vec3::new(0.9, 0.6, 0.3), 1.0), (Vec3::ZERO, 0.0)] {
        let f0 = if metallic == 1.0 { color.as_dvec3() } else { DVec3::splat(0.04) };
        for (ior, nanometers) in [(1.3, 150.0), (1.3, 400.0), (1.8, 550.0), (2.4, 1200.0)] {
            for (view, light) in pairs() {
                let material = layered(
                    Material { metallic, ..plain(color, roughness as f32) },
                    film(ior as f32, nanometers as f32),
                );
                let mirrored =
                    DVec3::from_array(reference::film(ior, nanometers, f0.to_array(), view.z)).min(DVec3::ONE);
                let lobe = reference::ggx(roughness, view, light) * light.z;
                let expected = mirrored.map(|mirrored| mirrored * lobe * scattered_again(mirrored, roughness, view));
                let of = format!("film of {ior}, {nanometers} nm on {f0}, {view} {light}");
                expect_near(lit(&material, view, light), expected, 0.01, &of);
            }
        }
    }
}

/// White materials with layers of all kinds, one or several at once.
fn white_ones() -> Vec<(String, Material)> {
    let mut all = Vec::new();
    for roughness in [0.3_f32, 0.6, 1.0] {
        let dark = Layers { specular: no_specular(), ..Layers::default() };
        let colored = Specular { factor: 1.0, color: Vec3::new(25.0, 9.0, 0.0), ..Specular::default() };
        let everything = Layers {
            specular: colored.clone(),
            ..Layers { sheen: sheen(Vec3::ONE, roughness).sheen, ..coat(1.0, roughness) }
        };
        let layers = [
            ("specular 0", dark),
            ("coloured", Layers { specular: colored, ..Layers::default() }),
            ("coat", coat(1.0, roughness)),
            ("half a coat", coat(0.5, 0.3)),
            ("sheen", sheen(Vec3::ONE, roughness)),
            ("straight sheen", sheen(Vec3::ONE, 0.1)),
            ("red sheen", sheen(Vec3::new(1.0, 0.2, 0.0), roughness)),
            ("stretch", stretch(0.7, 0.4)),
            ("film", film(1.3, 300.0)),
            ("thick film", film(2.0, 700.0)),
            ("all", Layers { anisotropy: stretch(0.5, 0.0).anisotropy, ..everything.clone() }),
            ("all and a film", Layers { iridescence: film(1.6, 420.0).iridescence, ..everything }),
        ];
        for metallic in [0.0, 1.0] {
            for (name, layers) in &layers {
                let material = layered(Material { metallic, ..plain(Vec3::ONE, roughness) }, layers.clone());
                all.push((format!("{name}, roughness {roughness}, metallic {metallic}"), material));
            }
        }
    }
    all
}

const COSINES: [f64; 4] = [1.0, 0.6, 0.25, 0.06];

#[test]
fn no_material_shows_more_than_white_surroundings_have() {
    for (name, material) in white_ones() {
        for cosine in COSINES {
            let shown = radiance(&material, direction(cosine, 30.0), Vec::new(), WHITE);
            assert!(shown.max_element() <= 1.005 && shown.min_element() >= 0.0, "{name}, {cosine}: {shown}");
        }
    }
    // White cloth reflects the even light that sheen doesn't.
    let cloth = layered(plain(Vec3::ONE, 1.0), Layers { specular: no_specular(), ..sheen(Vec3::ONE, 0.6) });
    for cosine in COSINES {
        let shown = radiance(&cloth, direction(cosine, 30.0), Vec::new(), WHITE);
        expect_near(shown, DVec3::ONE, 0.003, &format!("cloth, {cosine}"));
    }
}

#[test]
fn no_material_reflects_more_than_suns_send_from_everywhere() {
    let (mut most, mut of_bare) = ([0.0_f64; 2], Vec::new());
    for (name, material) in white_ones() {
        for cosine in COSINES {
            let view = direction(cosine, 30.0);
            let shown = under_suns(&material, view).max_element();
            let kind = (material.roughness, material.metallic, cosine);
            let known = of_bare.iter().find(|(of, _)| *of == kind).map(|&(_, bare)| bare);
            let bare = known.unwrap_or_else(|| {
                let bare = under_suns(&Material { layers: None, ..material.clone() }, view).max_element();
                of_bare.push((kind, bare));
                bare
            });
            println!("{name}, {cosine}: {shown:.3}, without layers {bare:.3}");
            most = [most[0].max(shown), most[1].max(shown - bare.max(1.0))];
        }
    }
    println!("at most {}, by {} more than without", most[0], most[1]);
    // The excess of the table of multiple scattering, which it has without layers as well.
    assert!(most[0] < 1.06 && most[1] < 0.04, "{most:?}");
}

#[test]
fn smooth_lacquer_is_a_mirror_where_bounces_follow_it() {
    let color = Vec3::new(0.9, 0.3, 0.6);
    let ceiling = Material { unlit: true, ..plain(color, 1.0) };
    let metal = Material { metallic: 1.0, ..plain(Vec3::new(0.5, 0.6, 0.7), 0.0) };
    for cosine in [0.9, 0.4] {
        let view = direction(cosine, 40.0);
        let part = 0.7 * reference::schlick(0.04, 1.0, cosine);
        let below = layered(metal.clone(), coat(0.7, 0.5));
        let of_metal = Vec3::new(0.5, 0.6, 0.7).as_dvec3().map(|f0| reference::schlick(f0, 1.0, cosine)) * (1.0 - part);
        for (material, factor) in [
            (nothing_below(coat(0.7, 0.0)), DVec3::splat(part)),
            // A rough coat is no mirror, but the surface below may be; and both may be.
            (nothing_below(coat(0.7, 0.3)), DVec3::ZERO),
            (below, of_metal),
            (layered(metal.clone(), coat(0.7, 0.0)), of_metal + part),
        ] {
            let mut frame = square(&material);
            let mut mesh = (*frame.mesh).clone();
            frame.positions.extend([(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)].map(|(x, y)| Vec3::new(x, y, 0.1) * 100.0));
            frame.tangents.clear();
            mesh.triangles.push([4, 5, 6]);
            mesh.material_of_triangle.push(1);
            frame.mesh = Arc::new(mesh);
            frame.materials = Arc::new(Materials { materials: vec![material, ceiling.clone()], textures: Vec::new() });
            expect_near(shown(&frame, view, BLACK, 1), factor * color.as_dvec3(), 0.01, &format!("{cosine}"));
            assert_eq!(shown(&frame, view, BLACK, 0), DVec3::ZERO);
        }
    }
    // The surroundings look as bright with followed reflections as without.
    let frame = square(&layered(metal, coat(1.0, 0.0)));
    let [once, followed] = [0, 1].map(|bounces| shown(&frame, direction(0.5, 0.0), WHITE, bounces));
    expect_near(followed, once, 2e-3, "followed");
}

/// A row of squares with these materials, so narrow that blocks of pixels have several.
fn row(materials: Vec<Material>) -> Frame {
    let mut frame = Frame::default();
    let mut mesh = Mesh::default();
    for index in 0..materials.len() as u32 {
        let first = frame.positions.len() as u32;
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (1.0, 12.0), (0.0, 12.0)] {
            frame.positions.push(Vec3::new(x + index as f32, y - 6.0, 0.3 * x));
            frame.normals.push(Vec3::new(0.4 * x - 0.2, 0.02 * y, 1.0).normalize());
            frame.tangents.push(Vec4::new(1.0, 0.0, 0.1, 1.0));
        }
        mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(|corner| first + corner)));
        mesh.material_of_triangle.extend([index; 2]);
    }
    frame.mesh = Arc::new(mesh);
    frame.materials = Arc::new(Materials { materials, textures: Vec::new() });
    frame.lights = vec![sun(direction(0.6, 100.0), 2.0), sun(direction(0.9, 10.0), 1.0)];
    frame.animation_bounds = frame.triangles().bounds();
    frame
}

fn row_settings() -> Settings {
    Settings { width: 84, height: 39, ..Settings::default() }
}

fn bits(film: &Film) -> Vec<[u32; 4]> {
    film.color.iter().map(|color| color.to_array().map(f32::to_bits)).collect()
}

#[test]
fn layers_that_are_off_change_nothing() {
    let clay = plain(Vec3::new(0.7, 0.6, 0.5), 0.4);
    let metal = Material { metallic: 0.9, ..clay.clone() };
    let off = Layers {
        clearcoat: Clearcoat { roughness: 0.4, ..Clearcoat::default() },
        sheen: Sheen { roughness: 0.4, ..Sheen::default() },
        anisotropy: Anisotropy { rotation_radians: 1.0, ..Anisotropy::default() },
        ..Layers::default()
    };
    assert!(off.are_off());
    let without = row(vec![clay.clone(), metal.clone(), clay.clone()]);
    let with = row([clay.clone(), metal.clone(), clay.clone()].map(|of| layered(of, off.clone())).to_vec());
    let settings = row_settings();
    let rendered = |frame: &Frame| Renderer::default().render_frame(frame, &settings).expect("a frame").clone();
    let expected = rendered(&without);
    assert!(bits(&expected) == bits(&rendered(&with)));
    // Pixels beside a layer in a block have the same bits as elsewhere.
    let everything = Layers {
        specular: Specular { factor: 0.3, ..Specular::default() },
        sheen: sheen(Vec3::ONE, 0.5).sheen,
        anisotropy: stretch(0.8, 0.0).anisotropy,
        iridescence: film(1.5, 400.0).iridescence,
        ..coat(1.0, 0.1)
    };
    let beside = rendered(&row(vec![layered(clay.clone(), everything), metal, clay]));
    let mut changed = 0;
    for ((color, &triangle), expected) in bits(&beside).iter().zip(&beside.triangle).zip(bits(&expected)) {
        if triangle == 0 || triangle == 1 {
            changed += usize::from(*color != expected);
        } else {
            assert_eq!(*color, expected, "of triangle {triangle}");
        }
    }
    assert!(changed > 40, "{changed} pixels of what has layers");
}

#[test]
fn every_level_and_number_of_threads_shades_layers_alike() {
    let frame = row(white_ones().into_iter().map(|(_, material)| material).collect());
    let settings = Settings { width: 301, ..row_settings() };
    let expected = bits(Renderer::default().render_frame(&frame, &settings).expect("a frame"));
    for level in SimdLevel::available() {
        for threads in [1, 2, 3, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let mut renderer = Renderer::with_simd_level(level);
            let film = pool.install(|| renderer.render_frame(&frame, &settings).expect("a frame").clone());
            assert!(bits(&film) == expected, "{level}, {threads} threads");
        }
    }
}
