//! Materials and textures from MTL libraries.

use glam::{Vec2, Vec3, Vec4};
use umbrage_files::OpenOptions;
use umbrage_scene::{Alpha, Frame, Material, Texture, TextureUse};

use crate::solids::{self, folder, open_path};

/// An OBJ with one triangle per material.
fn obj(materials: &[&str]) -> String {
    let faces: String = materials.iter().map(|name| format!("usemtl {name}\nf 1/1 2/1 3/1\n")).collect();
    format!("mtllib my library.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n{faces}")
}

/// A TGA image without compression, its upper row first.
fn tga([width, height]: [u8; 2], texels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = vec![0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, width, 0, height, 0, 32, 0x28];
    bytes.extend(texels.iter().flat_map(|[r, g, b, a]| [b, g, r, a]));
    bytes
}

/// A BMP image of 24 bits a texel and one row.
fn bmp(texels: &[[u8; 3]]) -> Vec<u8> {
    let row = (3 * texels.len()).next_multiple_of(4);
    let mut bytes = b"BM".to_vec();
    let u32s = |values: &[u32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    bytes.extend(u32s(&[54 + row as u32, 0, 54, 40, texels.len() as u32, 1, 1 | 24 << 16, 0, row as u32, 0, 0, 0, 0]));
    bytes.extend(texels.iter().flat_map(|[r, g, b]| [b, g, r]));
    bytes.resize(54 + row, 0);
    bytes
}

fn load(library: &str, images: &[(&str, &[u8])], names: &[&str]) -> Result<(Frame, Vec<String>), String> {
    let obj = obj(names);
    let mut files = vec![("a.obj", obj.as_bytes()), ("my library.mtl", library.as_bytes())];
    files.extend(images);
    let folder = folder(&files);
    open_path(&folder.path().join("a.obj"))
}

/// The only material of a library, and its textures and warnings.
fn material(statements: &str, images: &[(&str, &[u8])]) -> (Material, Vec<Texture>, Vec<String>) {
    let (frame, warnings) = load(&format!("newmtl it\n{statements}\n"), images, &["it"]).expect("a readable file");
    (frame.materials.materials[0].clone(), frame.materials.textures.clone(), warnings)
}

/// The texel in column `x` of an image of one row.
fn texel(texture: &Texture, x: u32) -> Vec4 {
    texture.sample(Vec2::new((x as f32 + 0.5) / texture.size()[0] as f32, 0.5), 0.0)
}

#[test]
fn faces_have_the_material_that_they_use() {
    let library = "newmtl red\nKd 1 0 0\nnewmtl unused\nmap_Kd missing.png\nnewmtl deep blue\n  Kd\t0 0 0.5 \n";
    let (frame, warnings) = load(library, &[], &["deep blue", "red", "deep blue"]).unwrap();
    assert_eq!(warnings, [""; 0], "textures of materials that nothing uses are not looked for");
    assert_eq!(frame.mesh.material_of_triangle, [0, 1, 0]);
    let colors: Vec<_> = frame.materials.materials.iter().map(|material| material.base_color).collect();
    assert_eq!(colors, [Vec4::new(0.0, 0.0, 0.5, 1.0), Vec4::new(1.0, 0.0, 0.0, 1.0)]);
    assert_eq!(frame.materials.materials[0].name, "deep blue");
}

#[test]
fn numbers_become_a_metallic_roughness_material() {
    let (plain, _, warnings) = material("Kd 0.5\nKe 1 2 3\nNi 1.33\nillum 2\nKa 1 1 1\nTf 1 1 1\nNs 100", &[]);
    assert_eq!(warnings, [""; 0]);
    assert_eq!(plain.base_color, Vec4::new(0.5, 0.5, 0.5, 1.0));
    assert_eq!((plain.emissive, plain.ior), (Vec3::new(1.0, 2.0, 3.0), 1.33));
    assert_eq!((plain.roughness, plain.metallic, plain.alpha), (1.0, 0.0, Alpha::Opaque), "no Ks, no highlight");
    let (shiny, ..) = material("Ks 0.5 0.5 0.5\nNs 30", &[]);
    // α² = 2 / (30 + 2) = 1/16, so α = 1/4 and its root is 1/2.
    assert!((shiny.roughness - 0.5).abs() < 1e-6, "{}", shiny.roughness);
    let (physical, ..) = material("Ks 1 1 1\nNs 30\nPr 0.25\nPm 0.75\nNi 0", &[]);
    assert_eq!((physical.roughness, physical.metallic, physical.ior), (0.25, 0.75, 1.5));
}

#[test]
fn opacity_blends_whether_it_is_said_as_d_or_as_tr() {
    for statements in ["d 0.25", "Tr 0.75", "d -halo 0.25"] {
        let (material, ..) = material(statements, &[]);
        assert_eq!((material.base_color.w, material.alpha), (0.25, Alpha::Blend), "{statements}");
    }
    assert_eq!(material("d 1\nTr 0", &[]).0.alpha, Alpha::Opaque);
}

#[test]
fn a_color_texture_is_srgb_and_placed_by_its_options() {
    let image = bmp(&[[255, 0, 0], [0, 128, 0]]);
    let statement = "map_Kd -blendu on -s 2 4 1 -o 0.25 0.5 -mm 0 1 -clamp on C:\\art\\two texels.bmp";
    let (material, textures, warnings) = material(statement, &[("two texels.bmp", &image)]);
    assert_eq!(warnings, [""; 0]);
    assert_eq!(textures.len(), 1);
    assert_eq!(texel(&textures[0], 0), Vec4::new(1.0, 0.0, 0.0, 1.0));
    // IEC 61966-2-1: 128/255 encodes 0.215861.
    assert!(texel(&textures[0], 1).abs_diff_eq(Vec4::new(0.0, 0.215_861, 0.0, 1.0), 1e-5));
    let placed = material.base_color_texture.unwrap();
    // Upright (u, v) go to (2u + 0.25, 4v + 0.5); here v is counted from above on both sides.
    let (u, v) = (0.125, 0.75);
    let expected = Vec2::new(2.0 * u + 0.25, 1.0 - (4.0 * v + 0.5));
    assert_eq!(placed.image_coords([Vec2::new(u, 1.0 - v), Vec2::ZERO]), expected);
}

#[test]
fn an_opacity_texture_makes_a_mask() {
    let color = bmp(&[[255, 255, 255], [0, 0, 0]]);
    let holes = bmp(&[[0, 0, 0], [255, 255, 255], [255, 255, 255], [0, 0, 0]]);
    let images: [(&str, &[u8]); 2] = [("color.bmp", &color), ("holes.bmp", &holes)];
    let (both, textures, warnings) = material("map_Kd color.bmp\nmap_d holes.bmp", &images);
    assert_eq!(warnings, [""; 0]);
    assert_eq!((both.alpha, textures.len()), (Alpha::Mask { cutoff: 0.5 }, 1));
    let texels: Vec<_> = (0..4).map(|x| texel(&textures[0], x)).map(|texel| (texel.x, texel.w)).collect();
    assert_eq!(texels, [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)]);
    let (alone, textures, _) = material("Kd 1 0 0\nmap_d holes.bmp", &images);
    assert_eq!(alone.base_color_texture, Some(TextureUse::new(0)));
    assert_eq!((texel(&textures[0], 0), texel(&textures[0], 1)), (Vec4::new(1.0, 1.0, 1.0, 0.0), Vec4::ONE));
}

#[test]
fn roughness_and_metal_textures_share_one_image() {
    let (rough, metal) = (bmp(&[[51, 51, 51]]), bmp(&[[102, 102, 102]]));
    let images: [(&str, &[u8]); 2] = [("r.bmp", &rough), ("m.bmp", &metal)];
    let (both, textures, _) = material("Pm 0\nmap_Pr r.bmp\nmap_Pm m.bmp", &images);
    assert_eq!((both.roughness, both.metallic), (1.0, 1.0), "a factor of zero would hide the texture");
    assert_eq!(both.metallic_roughness_texture, Some(TextureUse::new(0)));
    assert!(texel(&textures[0], 0).abs_diff_eq(Vec4::new(1.0, 0.2, 0.4, 1.0), 1e-6));
    let (one, textures, _) = material("Pm 0.5\nmap_Pr r.bmp", &images);
    assert_eq!((one.roughness, one.metallic), (1.0, 0.5));
    assert!(texel(&textures[0], 0).abs_diff_eq(Vec4::new(1.0, 0.2, 1.0, 1.0), 1e-6));
}

#[test]
fn a_normal_map_is_linear_and_an_emissive_one_needs_no_factor() {
    let image = bmp(&[[128, 128, 255]]);
    let (material, textures, warnings) = material("norm -bm 0.5 n.bmp\nKe 0 0 0\nmap_Ke n.bmp", &[("n.bmp", &image)]);
    assert_eq!(warnings, [""; 0]);
    let texture = |placed: Option<TextureUse>| texel(&textures[placed.unwrap().texture as usize], 0);
    assert!((texture(material.normal_texture).x - 128.0 / 255.0).abs() < 1e-6);
    assert_eq!(material.normal_scale, 0.5);
    assert!((texture(material.emissive_texture).x - 0.215_861).abs() < 1e-5);
    assert_eq!(material.emissive, Vec3::ONE);
}

#[test]
fn a_tga_image_is_read_though_nothing_in_it_says_what_it_is() {
    let image = tga([2, 1], &[[255, 0, 0, 9], [0, 0, 255, 200]]);
    let (_, textures, warnings) = material("map_Kd t.tga\nmap_d t.tga", &[("t.tga", &image)]);
    assert_eq!(warnings, [""; 0]);
    assert_eq!(texel(&textures[0], 0), Vec4::new(1.0, 0.0, 0.0, 9.0 / 255.0));
    assert_eq!(texel(&textures[0], 1), Vec4::new(0.0, 0.0, 1.0, 200.0 / 255.0));
}

#[test]
fn a_texture_is_loaded_once_for_all_materials() {
    let image = bmp(&[[1, 2, 3]]);
    let library = "newmtl a\nmap_Kd t.bmp\nnewmtl b\nmap_Kd -s 2 2 2 t.bmp\nnewmtl c\nmap_Kd -clamp on t.bmp\n";
    let (frame, _) = load(library, &[("t.bmp", &image)], &["a", "b", "c"]).unwrap();
    let places: Vec<_> =
        frame.materials.materials.iter().map(|material| material.base_color_texture.unwrap().texture).collect();
    assert_eq!(places, [0, 0, 1], "clamped is another texture");
}

#[test]
fn what_is_missing_is_a_warning() {
    let (frame, warnings) = solids::open("a.obj", obj(&["gone", "away"]).as_bytes()).unwrap();
    assert_eq!(frame.materials.materials.len(), 2);
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].contains("`my library.mtl` is not there"), "{warnings:?}");
    assert!(warnings[1].contains("2 materials are defined nowhere") && warnings[1].contains("`gone`"));

    let (material, textures, warnings) = material("map_Kd gone.png\nmap_Bump b.png\nmap_Ks k.png", &[]);
    assert_eq!((material.base_color_texture, textures.len(), warnings.len()), (None, 0, 3));
    assert!(warnings[0].contains("material `it`: left out `map_Bump` is a height field"), "{warnings:?}");
    assert!(warnings[1].contains("left out `map_Ks`") && warnings[2].contains("`gone.png` is not there"));
}

#[test]
fn images_that_cannot_be_read_are_warnings() {
    let good = bmp(&[[255, 0, 0]]);
    let (broken, textures, warnings) = material("map_Kd t.png", &[("t.png", &good[..40])]);
    assert_eq!((broken.base_color_texture, textures.len()), (None, 0));
    assert!(warnings[0].contains("t.png") && warnings[0].contains("not"), "{warnings:?}");
    let images: [(&str, &[u8]); 2] = [("c.bmp", &good), ("d.bmp", b"nothing")];
    let (half, textures, warnings) = material("map_Kd c.bmp\nmap_d d.bmp", &images);
    assert_eq!((half.alpha, half.base_color_texture), (Alpha::Opaque, Some(TextureUse::new(0))));
    assert_eq!((texel(&textures[0], 0), warnings.len()), (Vec4::new(1.0, 0.0, 0.0, 1.0), 1));
}

#[test]
fn values_of_a_library_that_cannot_be_read_are_left_out_alone() {
    for (statement, expected) in [
        ("Kd 1 1", "`Kd` on line 3: 2 numbers where 3 are needed"),
        ("Kd", "`Kd` on line 3: no number"),
        ("Kd 1 nan 1", "`Kd` on line 3: `nan` is not finite"),
        ("d half", "`d` on line 3: `half` is not a number"),
        ("Ns -1.#IND", "`Ns` on line 3: `-1.#IND` is not finite"),
        ("Ni nan", "`Ni` on line 3: `nan` is not finite"),
        ("map_Kd -clamp on", "`map_Kd` on line 3: no file name"),
        ("map_Kd", "`map_Kd` on line 3: no file name"),
        ("norm -bm strong a.png", "`norm` on line 3: `strong` is not a number"),
    ] {
        let (material, _, warnings) = material(&format!("Kd 1 0 0\n{statement}"), &[]);
        assert_eq!(material.base_color, Vec4::new(1.0, 0.0, 0.0, 1.0));
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert!(warnings[0].starts_with(&format!("material `it`: left out {expected}")), "{warnings:?}");
    }
    let (_, warnings) = load("Kd 1 1 1\nNs 4\nnewmtl it\n", &[], &["it"]).unwrap();
    assert!(warnings[0].contains("left out 2 statements before the first `newmtl`, the first being `Kd` on line 1"));
}

#[test]
fn a_byte_order_mark_does_not_hide_the_first_material() {
    let (frame, warnings) = load("\u{feff}newmtl it\rKd 1 0 0\r", &[], &["it"]).unwrap();
    assert_eq!(warnings, [""; 0]);
    assert_eq!(frame.materials.materials[0].base_color, Vec4::new(1.0, 0.0, 0.0, 1.0));
    let utf16: String = "newmtl it\n".chars().flat_map(|letter| [letter, '\0']).collect();
    let error = load(&utf16, &[], &["it"]).unwrap_err();
    assert!(error.contains("my library.mtl: ") && error.contains("UTF-16"), "{error}");
}

#[test]
fn transparency_alone_does_not_hide_a_material() {
    let (opaque, _, warnings) = material("Tr 1", &[]);
    assert_eq!((opaque.base_color.w, opaque.alpha), (1.0, Alpha::Opaque));
    assert_eq!(warnings, ["material `it`: `Tr 1` would hide it; it is shown opaque"]);
    // Beside `d`, `Tr` is ignored.
    for statements in ["d 1\nTr 1", "Tr 1\nd 1"] {
        assert_eq!(material(statements, &[]).0.alpha, Alpha::Opaque, "{statements}");
    }
    let (hidden, _, warnings) = material("d 0", &[]);
    assert_eq!((hidden.base_color.w, hidden.alpha), (0.0, Alpha::Blend));
    assert!(warnings[0].contains("all materials are wholly transparent"), "{warnings:?}");
    let (_, warnings) = load("newmtl a\nd 0\nnewmtl b\nd 0.5\n", &[], &["a", "b"]).unwrap();
    assert_eq!(warnings, [""; 0], "some of the model is seen");
}

#[test]
fn a_statement_names_several_libraries_with_spaces_or_quotes() {
    let library = |name: &str| format!("newmtl {name}\nKd 1 0 0\n").into_bytes();
    let (a, b, c) = (library("a"), library("b"), library("c"));
    let faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nusemtl c\nf 1 2 3\n";
    let files: [(&str, &[u8]); 3] = [("one.mtl", &a), ("my second.mtl", &b), ("the third one.mtl", &c)];
    for statement in ["one.mtl my second.mtl the third one.mtl", "\"the third one.mtl\" one.mtl \"my second.mtl\""] {
        let obj = format!("mtllib {statement}\n{faces}");
        let folder = folder(&[&files[..], &[("a.obj", obj.as_bytes())]].concat());
        let (frame, warnings) = open_path(&folder.path().join("a.obj")).unwrap();
        assert_eq!(warnings, [""; 0]);
        assert_eq!(frame.materials.materials.len(), 3);
    }
    let obj = format!("mtllib gone one.mtl my second.mtl\n{faces}");
    let folder = folder(&[("my second.mtl", &b), ("a.obj", obj.as_bytes())]);
    let (_, warnings) = open_path(&folder.path().join("a.obj")).unwrap();
    assert!(warnings[0].contains("the material library `gone one.mtl` is not there"), "{warnings:?}");
    assert!(warnings[1].contains("2 materials are defined nowhere"), "{warnings:?}");
}

#[test]
fn names_that_differ_in_case_alone_are_found_with_a_warning() {
    let image = bmp(&[[255, 0, 0]]);
    let (material, _, warnings) = material("map_Kd WOOD.bmp", &[("Wood.BMP", &image)]);
    assert!(material.base_color_texture.is_some());
    assert!(warnings[0].contains("`WOOD.bmp` is not there; `Wood.BMP` was read"), "{warnings:?}");
    let obj = obj(&["it"]);
    let folder = folder(&[("a.obj", obj.as_bytes()), ("My Library.MTL", b"newmtl it\nKd 1 0 0\n")]);
    let (frame, warnings) = open_path(&folder.path().join("a.obj")).unwrap();
    assert_eq!(frame.materials.materials[0].base_color.y, 0.0);
    assert!(warnings[0].contains("`my library.mtl` is not there; `My Library.MTL` was read"), "{warnings:?}");
}

#[test]
fn libraries_and_textures_outside_of_the_folder_are_read_where_that_is_allowed() {
    let text = "mtllib ../a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl it\nf 1/1 2/1 3/1\n";
    let texels = bmp(&[[255, 0, 0]]);
    let files = folder(&[("a.mtl", b"newmtl it\nKd 1 1 1\nmap_Kd a.bmp\n"), ("a.bmp", &texels)]);
    std::fs::create_dir(files.path().join("scene")).unwrap();
    let path = files.path().join("scene/a.obj");
    std::fs::write(&path, text).unwrap();
    let (frame, warnings) = open_path(&path).unwrap();
    assert!(warnings[0].contains("`../a.mtl` is outside of the scene's folder"), "{warnings:?}");
    assert_eq!(frame.materials.textures.len(), 0);
    let trusting = OpenOptions { allow_outside: true, ..OpenOptions::default() };
    let scene = umbrage_files::open_with(&path, &trusting).unwrap();
    assert_eq!(scene.warnings(), [""; 0]);
    assert_eq!(scene.at(0.0).unwrap().materials.textures.len(), 1);
}

#[test]
fn a_scene_tells_which_files_it_is_from() {
    let (obj, image) = (obj(&["it"]), bmp(&[[1, 2, 3]]));
    let library = b"newmtl it\nmap_Kd t.bmp\n";
    let folder =
        folder(&[("a.obj", obj.as_bytes()), ("my library.mtl", library), ("t.bmp", &image), ("u.bmp", &image)]);
    let scene = umbrage_files::open(folder.path().join("a.obj")).expect("a readable file");
    let files: Vec<_> = ["a.obj", "my library.mtl", "t.bmp"].iter().map(|name| folder.path().join(name)).collect();
    assert_eq!(scene.files(), files);
}
