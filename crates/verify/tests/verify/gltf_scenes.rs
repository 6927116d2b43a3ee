//! Real glTF files: their contents, and positions of triangles from an independent implementation.

use glam::Vec3;
use umbrage::scene::{Clip, Frame, OpenOptions, Scene};
use umbrage_rays::{Bounds, LightSource, Projection};
use umbrage_verify::real_scene;

/// Contents of a file.
struct Content {
    file: &'static str,
    triangles: usize,
    cameras: usize,
    animations: usize,
    textures: usize,
}

const fn content(file: &'static str, triangles: usize, cameras: usize, animations: usize, textures: usize) -> Content {
    Content { file, triangles, cameras, animations, textures }
}

#[rustfmt::skip]
const CONTENTS: [Content; 28] = [
    content("country_kitchen.glb", 1_021_815, 1, 0, 0),
    content("dream_apartment.glb", 177_934, 0, 0, 0),
    content("issum.glb", 192_286, 0, 0, 0),
    content("chess_board.glb", 178_848, 0, 0, 0),
    content("elephant_gallop.glb", 84_638, 0, 1, 0),
    content("robot_arm.glb", 9_760, 0, 1, 0),
    content("vintage_fan.glb", 21_080, 0, 4, 0),
    content("robot_expressive.glb", 3_237, 0, 14, 0),
    content("cesium_man.glb", 4_672, 0, 1, 1),
    content("dispersion_test.glb", 51_827, 0, 0, 2),
    content("tree_alphamask.glb", 4_222, 0, 0, 2),
    content("conformance/AnimatedMorphCube.glb", 12, 0, 1, 0),
    content("conformance/AnimatedMorphSphere/AnimatedMorphSphere.gltf", 960, 0, 1, 0),
    content("conformance/AttenuationTest.glb", 292, 0, 0, 3),
    content("conformance/BoxAnimated.glb", 254, 0, 1, 0),
    content("conformance/Cameras.gltf", 2, 2, 0, 0),
    content("conformance/Cubes_pointlight.glb", 36, 0, 0, 0),
    content("conformance/Fox.glb", 576, 0, 3, 1),
    content("conformance/InterpolationTest.glb", 110, 0, 9, 1),
    content("conformance/MorphPrimitivesTest/MorphPrimitivesTest.gltf", 32, 0, 0, 1),
    content("conformance/MorphStressTest.glb", 2_412, 0, 3, 3),
    content("conformance/RiggedSimple.glb", 188, 0, 1, 0),
    content("conformance/SimpleMorph/SimpleMorph.gltf", 1, 0, 1, 0),
    content("conformance/SimpleSkin.gltf", 8, 0, 1, 0),
    content("conformance/TransmissionRoughnessTest.glb", 77_792, 0, 0, 5),
    content("conformance/cornellBox.glb", 4_006, 1, 0, 0),
    content("teapots_galore/TeapotsGalore.gltf", 7_656_770, 1, 0, 0),
    content("teapots_galore/TeapotsGalore_nodes.gltf", 7_656_770, 1, 0, 0),
];

fn open(file: &str, clip: Clip) -> Option<Scene> {
    let options = OpenOptions { clip, ..OpenOptions::default() };
    Some(umbrage::open_with(real_scene(file)?, &options).expect(file))
}

fn bounds(frame: &Frame) -> Bounds {
    frame.triangles().bounds()
}

#[test]
fn files_hold_what_is_known_of_them() {
    for Content { file, triangles, cameras, animations, textures } in CONTENTS {
        let Some(scene) = open(file, Clip::Auto) else { continue };
        let frame = scene.at(0.0).unwrap();
        assert_eq!(frame.mesh.triangles.len(), triangles, "{file}: triangles");
        assert_eq!(frame.mesh.material_of_triangle.len(), triangles, "{file}");
        assert_eq!(frame.cameras.len(), cameras, "{file}: cameras");
        assert_eq!(scene.animations().len(), animations, "{file}: animations");
        assert_eq!(frame.materials.textures.len(), textures, "{file}: textures");
        let vertices = frame.positions.len();
        assert!(frame.mesh.triangles.as_flattened().iter().all(|&vertex| (vertex as usize) < vertices), "{file}");
        let materials = frame.materials.materials.len();
        assert!(frame.mesh.material_of_triangle.iter().all(|&material| (material as usize) < materials), "{file}");
        for length in [frame.normals.len(), frame.tangents.len(), frame.mesh.tex_coords[0].len()] {
            assert!(length == 0 || length == vertices, "{file}: {length} attributes for {vertices} vertices");
        }
    }
}

#[test]
fn animations_stay_sane() {
    for Content { file, animations, .. } in CONTENTS.into_iter().filter(|content| content.animations > 0) {
        for number in 0..animations {
            let Some(scene) = open(file, Clip::Named(number.to_string())) else { continue };
            let rest = open(file, Clip::Rest).unwrap().at(0.0).unwrap();
            let size = bounds(&rest).size().max_element();
            let mut frame = Frame::default();
            for moment in 0..5 {
                scene.pose(scene.duration_seconds() * f64::from(moment) / 4.0, &mut frame).unwrap();
                assert!(frame.positions.iter().all(|position| position.is_finite()), "{file} {number} {moment}");
                let far = (bounds(&frame).center() - bounds(&rest).center()).length();
                let grown = bounds(&frame).size().max_element();
                assert!(far < 4.0 * size && grown < 4.0 * size, "{file} {number} {moment}: {far} {grown} of {size}");
                let unit = |normal: &Vec3| *normal == Vec3::ZERO || (normal.length() - 1.0).abs() < 1e-5;
                assert!(frame.normals.iter().all(unit), "{file} {number} {moment}");
            }
        }
    }
}

/// A scene's surface at a moment, from a small implementation in double precision, written from the specification alone
/// and in another language.
struct Reference {
    file: &'static str,
    seconds: f64,
    /// The number of the clip that plays; `None` for all.
    clip: Option<u32>,
    area: f32,
    center: Vec3,
    bounds: Bounds,
}

const fn reference(
    file: &'static str,
    seconds: f64,
    clip: Option<u32>,
    area: f32,
    center: [f32; 3],
    min: [f32; 3],
    max: [f32; 3],
) -> Reference {
    let bounds = Bounds { min: Vec3::from_array(min), max: Vec3::from_array(max) };
    Reference { file, seconds, clip, area, center: Vec3::from_array(center), bounds }
}

#[rustfmt::skip]
const REFERENCES: [Reference; 14] = [
    reference("cesium_man.glb", 0.0, None, 1.51841, [-0.0382464, 0.793039, 0.0237452], [-0.310509, -0.0106452, -0.446594], [0.194655, 1.44716, 0.449894]),
    reference("cesium_man.glb", 0.77, None, 1.51793, [-0.0270093, 0.802283, 0.0199173], [-0.227528, -0.013582, -0.4869], [0.193072, 1.46793, 0.460111]),
    reference("robot_expressive.glb", 0.7, Some(10), 48.7477, [-0.0223025, 2.51734, 0.161285], [-1.53606, -0.0215071, -1.2798], [1.61375, 4.51269, 1.55937]),
    reference("vintage_fan.glb", 2.345, None, 5560.99, [-0.0137699, 25.8043, 5.01412], [-22.1873, -0.0201125, -15.0315], [22.076, 54.4509, 20.2414]),
    reference("robot_arm.glb", 3.21, None, 6.51406, [0.0528685, 0.661565, 0.336432], [-0.577984, 0.0, -1.41123], [1.22602, 1.82874, 1.81499]),
    reference("conformance/Fox.glb", 0.5, Some(0), 14974.7, [-0.59898, 40.0233, -6.07566], [-20.6202, -0.130771, -85.5978], [11.5953, 75.8702, 65.3879]),
    reference("conformance/RiggedSimple.glb", 1.0, None, 38.2382, [0.459569, -1.0779, 0.0], [-1.0, -4.57508, -1.0], [2.86649, 4.10051, 1.0]),
    reference("conformance/InterpolationTest.glb", 0.3, None, 193.558, [-0.0150939, 4.30071, 0.032386], [-4.69155, -2.15946, -1.0], [4.73738, 10.3573, 1.00367]),
    reference("conformance/InterpolationTest.glb", 1.25, None, 168.164, [0.00602403, 5.08196, 0.0371109], [-4.72561, -2.15946, -1.0], [4.74928, 11.0, 1.00367]),
    reference("conformance/BoxAnimated.glb", 2.0, None, 16.9307, [0.0, 0.755691, 0.0113084], [-0.5, -0.5, -0.578134], [0.5, 2.99222, 0.578134]),
    reference("conformance/AnimatedMorphCube.glb", 1.7, None, 8.96522, [0.0, -0.00911621, -0.93963], [-1.0, -1.0, -1.0], [1.0, 1.0, -0.864082]),
    reference("conformance/SimpleSkin.gltf", 1.75, None, 1.76842, [-0.167516, 0.888039, 0.0], [-1.1152, 0.0, 0.0], [0.538304, 1.84444, 0.0]),
    reference("conformance/MorphStressTest.glb", 1.9, Some(0), 16.9066, [-0.0600064, 0.120935, 0.0], [-2.0, -0.1, -0.5], [2.0, 1.148, 0.5]),
    reference("elephant_gallop.glb", 0.61, None, 5.04432, [-0.000458031, 0.72211, 0.190918], [-0.473354, -0.0186615, -0.843672], [0.467606, 1.24678, 1.14317]),
];

#[test]
fn poses_agree_with_an_independent_implementation() {
    for Reference { file, seconds, clip, area, center, bounds } in REFERENCES {
        let clip = clip.map_or(Clip::All, |number| Clip::Named(number.to_string()));
        let Some(scene) = open(file, clip) else { continue };
        let frame = scene.at(seconds).unwrap();
        let (mut own_area, mut moment) = (0.0, Vec3::ZERO.as_dvec3());
        let mut own_bounds = Bounds::EMPTY;
        for triangle in &frame.mesh.triangles {
            let [a, b, c] = triangle.map(|vertex| frame.positions[vertex as usize]);
            own_bounds = own_bounds.union(Bounds::of_points([a, b, c]));
            let [a, b, c] = [a, b, c].map(Vec3::as_dvec3);
            let part = 0.5 * (b - a).cross(c - a).length();
            own_area += part;
            moment += part / 3.0 * (a + b + c);
        }
        // The reference has six digits, of which small numbers have lost some to the size of the whole.
        let tolerance = 1e-5 * bounds.size().max_element();
        let close = |a: Vec3, b: Vec3| (a - b).abs().max_element() < tolerance;
        assert!((own_area as f32 - area).abs() < 1e-5 * area, "{file} {seconds}: area {own_area}");
        let own_center = (moment / own_area).as_vec3();
        assert!(close(own_center, center), "{file} {seconds}: centre {own_center}, not {center}");
        let agree = close(own_bounds.min, bounds.min) && close(own_bounds.max, bounds.max);
        assert!(agree, "{file} {seconds}: {own_bounds:?}, not {bounds:?}");
    }
}

#[test]
fn an_instanced_scene_is_the_same_as_its_nodes() {
    let Some(instanced) = open("teapots_galore/TeapotsGalore.gltf", Clip::Auto) else { return };
    let Some(nodes) = open("teapots_galore/TeapotsGalore_nodes.gltf", Clip::Auto) else { return };
    let [instanced, nodes] = [instanced.at(0.0).unwrap(), nodes.at(0.0).unwrap()];
    // The two files have their copies in different orders.
    let sum = |frame: &Frame| frame.positions.iter().copied().map(Vec3::as_dvec3).sum::<glam::DVec3>();
    let difference = (sum(&instanced) - sum(&nodes)) / instanced.positions.len() as f64;
    assert!(difference.length() < 1e-4, "{difference}");
    let squares =
        |frame: &Frame| frame.positions.iter().map(|position| position.as_dvec3().length_squared()).sum::<f64>();
    assert!((squares(&instanced) / squares(&nodes) - 1.0).abs() < 1e-6);
    let [ours, theirs] = [bounds(&instanced), bounds(&nodes)];
    assert!((ours.min - theirs.min).length() + (ours.max - theirs.max).length() < 1e-3, "{ours:?} {theirs:?}");
}

#[test]
fn cameras_and_lights_are_where_their_files_say() {
    if let Some(scene) = open("conformance/Cameras.gltf", Clip::Auto) {
        let frame = scene.at(0.0).unwrap();
        let [perspective, orthographic] = [frame.cameras[0].camera, frame.cameras[1].camera];
        assert_eq!(perspective.position, Vec3::new(0.5, 0.5, 3.0));
        assert_eq!(perspective.forward, Vec3::NEG_Z);
        assert_eq!(perspective.projection, Projection::Perspective { tan_half_height: (0.7_f32 / 2.0).tan() });
        assert_eq!(orthographic.projection, Projection::Orthographic { half_height: 1.0 });
    }
    if let Some(scene) = open("conformance/Cubes_pointlight.glb", Clip::Auto) {
        let frame = scene.at(0.0).unwrap();
        assert!(matches!(frame.lights[..], [umbrage_scene::Light { source: LightSource::Point { .. }, .. }]));
        assert_ne!(&*frame.lights[0].name, "made for the scene");
    }
}
