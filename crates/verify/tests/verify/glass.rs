//! Glass against formulas, and against a program that follows light by these alone.

use std::sync::Arc;

use glam::{DVec3, Vec3, Vec4};
use umbrage::rays::predicate::{HitPoint, hit};
use umbrage::rays::{Camera, Hit, LightSource, Ray, View};
use umbrage::scene::{Frame, Light, Material, Materials, Mesh, Volume};
use umbrage::{Background, Renderer, Settings};
use umbrage_papers::structures;
use umbrage_verify::{Random, TestMesh};

const SKY: Vec3 = Vec3::new(0.3, 0.5, 0.7);

/// Glass that has `color` after one unit of distance.
fn glass(ior: f32, color: Vec3) -> Material {
    let volume = Volume { thickness: 1.0, attenuation_distance: 1.0, attenuation_color: color, ..Volume::default() };
    Material { transmission: 1.0, roughness: 0.0, ior, volume, ..Material::default() }
}

fn plain(color: Vec3) -> Material {
    Material { base_color: color.extend(1.0), unlit: true, ..Material::clay() }
}

#[derive(Default)]
struct Maker {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    material_of_triangle: Vec<u32>,
    /// Colours of vertices.
    colors: Vec<Vec4>,
}

impl Maker {
    fn push(&mut self, corners: [Vec3; 3], material: u32) {
        let first = self.positions.len() as u32;
        self.positions.extend(corners);
        self.colors.extend([Vec4::ONE; 3]);
        self.triangles.push([first, first + 1, first + 2]);
        self.material_of_triangle.push(material);
    }

    fn quad(&mut self, [a, b, c, d]: [Vec3; 4], material: u32) {
        self.push([a, b, c], material);
        self.push([a, c, d], material);
    }

    /// A box with outward fronts.
    fn cuboid(&mut self, low: Vec3, high: Vec3, material: u32) {
        for axis in 0..3 {
            for (level, is_high) in [(low, false), (high, true)] {
                let corner = |second: bool, third: bool| {
                    let mut at = low;
                    at[axis] = level[axis];
                    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
                    (at[u], at[v]) = (if second { high[u] } else { low[u] }, if third { high[v] } else { low[v] });
                    at
                };
                let mut face = [corner(false, false), corner(true, false), corner(true, true), corner(false, true)];
                if !is_high {
                    face.reverse();
                }
                self.quad(face, material);
            }
        }
    }

    /// A ball of facets with outward fronts.
    fn ball(&mut self, splits: u32, radius: f32, middle: Vec3, material: u32) {
        let ball = TestMesh::ball(splits);
        for &corners in &ball.indices {
            let [a, b, c] = corners.map(|vertex| ball.positions[vertex as usize]);
            let corners = if (b - a).cross(c - a).dot(a) > 0.0 { [a, b, c] } else { [a, c, b] };
            self.push(corners.map(|corner| corner * radius + middle), material);
        }
    }

    fn frame(self, materials: Vec<Material>) -> Frame {
        let Self { positions, triangles, material_of_triangle, colors } = self;
        let mesh = Mesh { triangles, material_of_triangle, colors, ..Mesh::default() };
        let materials = Materials { materials, textures: Vec::new() };
        Frame { positions, mesh: Arc::new(mesh), materials: Arc::new(materials), ..Frame::default() }
    }
}

fn settings(camera: Camera, background: Vec3, bounces: u32) -> Settings {
    let background = Background::Color(background);
    Settings { width: 80, height: 60, camera: camera.into(), background, bounces, ..Settings::default() }
}

fn colors(frame: &Frame, settings: &Settings) -> Vec<Vec3> {
    let film = Renderer::default().render_frame(frame, settings).expect("a picture").clone();
    film.color.iter().map(|color| color.truncate()).collect()
}

#[test]
fn a_slab_shifts_what_is_behind_it_as_snell_says() {
    let (thickness, ior) = (1.5_f64, 1.5_f64);
    // Behind the slab is a plane whose vertices have their positions as colours.
    let mut maker = Maker::default();
    let corner = |x: f32, y: f32| Vec3::new(x, y, -4.0) * Vec3::new(20.0, 20.0, 1.0);
    maker.quad([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)], 1);
    for (color, position) in maker.colors.iter_mut().zip(&maker.positions) {
        *color = Vec4::new(0.5 + position.x / 40.0, 0.5 + position.y / 40.0, 0.0, 1.0);
    }
    maker.cuboid(Vec3::new(-90.0, -90.0, -(thickness as f32)), Vec3::new(90.0, 90.0, 0.0), 0);
    let frame = maker.frame(vec![glass(ior as f32, Vec3::ONE), plain(Vec3::ONE)]);
    let camera = Camera::look_at(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, Vec3::Y, 1.4);
    let settings = settings(camera, Vec3::ZERO, 2);
    let view = View { camera, width: settings.width, height: settings.height };
    for (pixel, color) in colors(&frame, &settings).into_iter().enumerate() {
        let [x, y] = [pixel as u32 % settings.width, pixel as u32 / settings.width];
        let direction = view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5).direction.normalize();
        let sine = direction.truncate().length();
        let inside = (sine / ior).asin();
        let radius = (3.0 + 4.0 - thickness) * sine.asin().tan() + thickness * inside.tan();
        let met = direction.truncate() / sine.max(1e-9) * radius;
        // Two surfaces, each of which transmits the light that it doesn't reflect.
        let outside = sine.asin();
        let [across, along] =
            [(outside - inside).sin() / (outside + inside).sin(), (outside - inside).tan() / (outside + inside).tan()];
        let through = (1.0 - 0.5 * (across * across + along * along)).powi(2);
        let expected = [0.5 + met.x / 40.0, 0.5 + met.y / 40.0].map(|shade| shade * through);
        let difference = (f64::from(color.x) - expected[0]).abs().max((f64::from(color.y) - expected[1]).abs());
        assert!(difference < 2e-3, "{x}, {y}: {color} instead of {expected:?}");
    }
}

#[test]
fn lossless_glass_is_as_bright_as_what_is_around_it() {
    for ior in [1.0, 1.33, 1.5, 2.4] {
        let mut maker = Maker::default();
        maker.ball(4, 1.0, Vec3::ZERO, 0);
        maker.cuboid(Vec3::new(1.2, -0.5, -0.5), Vec3::new(2.0, 0.5, 0.5), 0);
        let frame = maker.frame(vec![glass(ior, Vec3::ONE)]);
        let camera = Camera::look_at(Vec3::new(1.5, 2.0, 6.0), Vec3::X * 0.5, Vec3::Y, 0.6);
        let colors = colors(&frame, &settings(camera, Vec3::ONE, 100));
        let mean = colors.iter().map(|color| color.x).sum::<f32>() / colors.len() as f32;
        let brightest = colors.iter().map(|color| color.max_element()).fold(0.0, f32::max);
        // The missing light is that of paths with a throughput below 0.002.
        assert!(brightest < 1.0 + 1e-4 && mean > 0.995, "{ior}: {mean} in the mean, {brightest} at most");
    }
}

#[test]
fn what_is_behind_colored_glass_is_darker_as_beer_says() {
    let tint = Vec3::new(0.9, 0.4, 0.1);
    let mut maker = Maker::default();
    maker.cuboid(Vec3::new(-9.0, -9.0, -2.0), Vec3::new(9.0, 9.0, 0.0), 0);
    let frame = maker.frame(vec![glass(1.5, tint)]);
    let camera = Camera::look_at(Vec3::Z * 50.0, Vec3::ZERO, Vec3::Y, 1e-3);
    // All paths from one side to the other, and back.
    let (reflected, passed) = (0.04, tint * tint);
    let often = (Vec3::ONE - reflected * reflected * passed * passed).recip() * (1.0 - reflected) * (1.0 - reflected);
    let expected = often * passed + often * passed * passed * reflected + reflected;
    for color in colors(&frame, &settings(camera, Vec3::ONE, 100)) {
        // Paths below 0.002 aren't followed.
        assert!(color.abs_diff_eq(expected, 4e-3), "{color} instead of {expected}");
    }
}

/// Follows light by the formulas alone, in f64 and with every triangle tested for every ray.
struct Whitted<'a> {
    frame: &'a Frame,
    bounces: u32,
}

impl Whitted<'_> {
    fn nearest(&self, ray: &Ray, from: Option<(u32, HitPoint)>) -> Option<Hit> {
        let triangles = self.frame.triangles();
        let hits = (0..triangles.len() as u32).filter_map(|id| hit(ray, triangles, id));
        let is_new = |hit: &Hit| {
            from.is_none_or(|(own, point)| hit.triangle != own && !point.is_on(triangles.corners(hit.triangle)))
        };
        hits.filter(is_new).min_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)))
    }

    /// Light along a ray of unit length, times its throughput `counts`; `inside` are the materials around the ray.
    fn light(&self, ray: &Ray, from: Option<(u32, HitPoint)>, inside: &[u32], counts: DVec3, bounces: u32) -> DVec3 {
        let Some(found) = self.nearest(ray, from) else { return SKY.as_dvec3() * counts };
        let materials = &self.frame.materials.materials;
        let counts = inside.last().map_or(counts, |&medium| {
            let color = materials[medium as usize].volume.attenuation_color.as_dvec3();
            counts * DVec3::from_array(color.to_array().map(|left| left.powf(found.t)))
        });
        let number = self.frame.mesh.material_of_triangle[found.triangle as usize];
        let material = &materials[number as usize];
        if material.unlit {
            return material.base_color.truncate().as_dvec3() * counts;
        }
        assert!(bounces < self.bounces, "the picture is of ways that are all followed to their ends");
        let [a, b, c] = self.frame.triangles().corners(found.triangle).map(Vec3::as_dvec3);
        let front = (b - a).cross(c - a).normalize();
        let is_front = front.dot(ray.direction) < 0.0;
        let normal = if is_front { front } else { -front };
        let mut behind = inside.to_vec();
        let index = |media: &[u32]| media.last().map_or(1.0, |&medium| f64::from(materials[medium as usize].ior));
        let indices = if is_front {
            behind.push(number);
            [index(inside), f64::from(material.ior)]
        } else {
            behind.remove(behind.iter().rposition(|&medium| medium == number).expect("a volume that was entered"));
            [f64::from(material.ior), index(&behind)]
        };
        let incident = (-ray.direction.dot(normal)).clamp(-1.0, 1.0).acos();
        let sine = incident.sin() * indices[0] / indices[1];
        let reflected = if sine >= 1.0 {
            1.0
        } else {
            let [one, other] = [incident.cos(), sine.asin().cos()];
            let across = (indices[0] * one - indices[1] * other) / (indices[0] * one + indices[1] * other);
            let along = (indices[1] * one - indices[0] * other) / (indices[1] * one + indices[0] * other);
            0.5 * (across * across + along * along)
        };
        let start = HitPoint::new(ray, found.t);
        let mut sum = DVec3::ZERO;
        let mirrored = ray.direction - normal * (2.0 * ray.direction.dot(normal));
        let mut follow = |direction: DVec3, media: &[u32], part: f64| {
            let counts = counts * part;
            if counts.max_element() > 0.002 {
                let ray = Ray::new(start.position, direction);
                sum += self.light(&ray, Some((found.triangle, start)), media, counts, bounces + 1);
            }
        };
        follow(mirrored, inside, reflected);
        if reflected < 1.0 {
            let tangent = (ray.direction + normal * incident.cos()).normalize_or_zero();
            follow(tangent * sine - normal * sine.asin().cos(), &behind, 1.0 - reflected);
        }
        sum
    }
}

#[test]
fn light_comes_through_glass_by_the_ways_that_formulas_lead_it() {
    let mut maker = Maker::default();
    // Glass in glass, and a ball of facets.
    maker.cuboid(Vec3::new(-2.2, -0.9, -0.9), Vec3::new(-0.4, 0.9, 0.9), 0);
    maker.cuboid(Vec3::new(-1.7, -0.5, -0.5), Vec3::new(-0.9, 0.5, 0.4), 1);
    maker.ball(2, 0.9, Vec3::new(1.1, 0.0, 0.0), 1);
    let mut random = Random::new(5);
    for material in [2, 3].into_iter().cycle().take(24) {
        let middle = random.point() * 4.0 - Vec3::Z * 4.5;
        maker.push([0; 3].map(|_| middle + random.point()), material);
    }
    let materials = vec![
        glass(1.5, Vec3::new(0.6, 0.7, 0.8)),
        glass(1.25, Vec3::new(0.8, 0.7, 0.6)),
        plain(Vec3::X),
        plain(Vec3::Y),
    ];
    let frame = maker.frame(materials);
    let camera = Camera::look_at(Vec3::new(0.7, 1.5, 5.0), Vec3::new(-0.1, 0.0, 0.0), Vec3::Y, 0.7);
    let settings = settings(camera, SKY, 1000);
    let whitted = Whitted { frame: &frame, bounces: settings.bounces };
    let view = View { camera, width: settings.width, height: settings.height };
    let shown = colors(&frame, &settings);
    let mut others = 0;
    for (pixel, color) in shown.iter().enumerate() {
        let [x, y] = [pixel as u32 % settings.width, pixel as u32 / settings.width].map(|side| f64::from(side) + 0.5);
        let ray = view.ray(x, y);
        let ray = Ray::new(ray.origin, ray.direction.normalize());
        let expected = whitted.light(&ray, None, &[], DVec3::ONE, 0);
        others += usize::from(!color.as_dvec3().abs_diff_eq(expected, 4e-3));
    }
    // Shading has normals in f32: paths differ at an edge, or near the minimum throughput.
    assert!(others * 100 < shown.len(), "{others} of {} pixels show something else", shown.len());

    for structure in structures().iter() {
        let others = colors(&frame, &Settings { structure: structure.clone(), ..settings.clone() });
        assert!(shown == others, "{structure:?}");
    }
}

#[test]
fn dispersion_parts_colors() {
    // A wedge of glass before an edge between black and white.
    let colorful = |dispersion: f32| {
        let mut maker = Maker::default();
        let [a, b, c] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 0.2]].map(|[x, z]| Vec3::new(x, 0.0, z));
        let [low, high] = [Vec3::NEG_Y, Vec3::Y];
        for [from, to] in [[b, a], [c, b], [a, c]] {
            maker.quad([from + high, to + high, to + low, from + low], 0);
        }
        maker.push([a, b, c].map(|corner| corner + low), 0);
        maker.push([c, b, a].map(|corner| corner + high), 0);
        let edge = |x: f32, y: f32| Vec3::new(x, y, -3.0);
        maker.quad([edge(0.0, -9.0), edge(9.0, -9.0), edge(9.0, 9.0), edge(0.0, 9.0)], 1);
        let frame = maker.frame(vec![Material { dispersion, ..glass(1.5, Vec3::ONE) }, plain(Vec3::ONE)]);
        let camera = Camera::look_at(Vec3::Z * 6.0, Vec3::ZERO, Vec3::Y, 0.3);
        let colors = colors(&frame, &settings(camera, Vec3::ZERO, 4));
        colors.iter().filter(|color| color.max_element() - color.min_element() > 0.1).count()
    };
    assert_eq!(colorful(0.0), 0);
    let parted = colorful(5.0);
    assert!(parted > 20, "{parted} pixels");
}

#[test]
fn stained_glass_colors_the_light_behind_it() {
    let stain = Vec3::new(0.9, 0.5, 0.2);
    let lit = |with_glass: bool, bounces: u32| {
        let mut maker = Maker::default();
        let floor = |x: f32, z: f32| Vec3::new(x * 9.0, 0.0, z * 9.0);
        maker.quad([floor(-1.0, 1.0), floor(1.0, 1.0), floor(1.0, -1.0), floor(-1.0, -1.0)], 1);
        if with_glass {
            maker.cuboid(Vec3::new(-9.0, 3.0, -9.0), Vec3::new(9.0, 3.5, 9.0), 0);
        }
        let mut frame = maker.frame(vec![glass(1.5, stain), Material::clay()]);
        let source = LightSource::Point { position: Vec3::new(0.0, 5.0, 0.0) };
        frame.lights = vec![Light::new(source, 40.0)];
        let camera = Camera::look_at(Vec3::new(0.1, 2.5, 0.0), Vec3::ZERO, Vec3::Z, 1.0);
        let settings = settings(camera, Vec3::ZERO, bounces);
        let view = View { camera, width: settings.width, height: settings.height };
        let points = (0..settings.width * settings.height).map(|pixel| {
            let ray = view.ray(f64::from(pixel % settings.width) + 0.5, f64::from(pixel / settings.width) + 0.5);
            ray.origin - ray.direction * (ray.origin.y / ray.direction.y)
        });
        points.zip(colors(&frame, &settings)).collect::<Vec<_>>()
    };
    let open = lit(false, 1);
    for ((point, open), (_, behind)) in open.iter().zip(lit(true, 1)) {
        let slant = (point.length_squared() + 25.0).sqrt() / 5.0;
        let length = (0.5 * slant) as f32;
        let expected = *open * Vec3::from_array(stain.to_array().map(|left| left.powf(length))) * 0.96 * 0.96;
        assert!(behind.abs_diff_eq(expected, 1e-4), "{behind} at {point} instead of {expected}");
    }
    // Without bounces, glass casts no shadow.
    assert!(lit(true, 0) == lit(false, 0));
}
