use std::collections::HashMap;
use std::path::PathBuf;

use glam::{Affine2, Vec2, Vec3};
use umbrage_scene::{Alpha, Error, Material, Materials, TextureUse, Wrap};

use super::library::{self, Definition, TextureStatement};
use super::textures::{Recipe, TextureLoader};
use crate::folder::{self, Folder};
use crate::foreign;
use crate::memory::Budget;

/// Loads the materials called `names`, in that order, from `libraries` in `folder`, with their textures.
///
/// # Errors
/// Where an existing library can't be read, or isn't text.
pub(super) fn load(
    folder: &Folder,
    libraries: &[String],
    names: &[Option<String>],
    budget: &Budget,
    warnings: &mut Vec<String>,
) -> Result<Materials, Error> {
    let mut definitions = HashMap::new();
    for (path, texture_folder) in library_paths(folder, libraries, budget, warnings) {
        let bytes = folder::read(&path, budget).map_err(|source| Error::read(&path, source))?;
        foreign::expect_text(&path, &bytes)?;
        for definition in library::parse(&path, &bytes, warnings) {
            definitions.insert(definition.name.clone(), (definition, texture_folder.clone()));
        }
    }
    let mut textures = TextureLoader::new(budget);
    let mut materials = Vec::with_capacity(names.len());
    let mut undefined = Vec::new();
    for name in names {
        let defined = name.as_ref().and_then(|name| definitions.get(name));
        let material = match (name, defined) {
            (_, Some((definition, folder))) => material(definition, folder, &mut textures),
            (Some(name), None) => {
                undefined.push(name.as_str());
                Material { name: name.clone(), ..Material::clay() }
            }
            (None, None) => Material::clay(),
        };
        materials.push(material);
    }
    if let [first, ..] = undefined[..] {
        let count = undefined.len();
        warnings.push(format!("{count} materials are defined nowhere and shown grey, the first being `{first}`"));
    }
    let is_unseen = |material: &Material| material.alpha == Alpha::Blend && material.base_color.w == 0.0;
    if !materials.is_empty() && materials.iter().all(is_unseen) {
        warnings.push("all materials are wholly transparent (`d 0`): nothing of the model is seen".to_owned());
    }
    let (textures, texture_warnings) = textures.finish();
    warnings.extend(texture_warnings);
    Ok(Materials { materials, textures })
}

/// Finds the existing libraries and the folders of their textures. A statement names one or several files, whose names may
/// contain spaces: the longest existing names are taken.
fn library_paths(
    folder: &Folder,
    libraries: &[String],
    budget: &Budget,
    warnings: &mut Vec<String>,
) -> Vec<(PathBuf, Folder)> {
    /// Maximum number of words in a name; more would take too many lookups.
    const MOST_WORDS: usize = 64;
    let mut paths = Vec::new();
    for library in libraries {
        let mut rest = library.trim();
        while !rest.is_empty() {
            let ends = rest.char_indices().filter(|(_, letter)| letter.is_ascii_whitespace()).map(|(at, _)| at);
            let ends: Vec<usize> = ends.chain([rest.len()]).take(MOST_WORDS).collect();
            let named = ends.iter().rev().map(|&end| (unquoted(&rest[..end]), end));
            let exact = named.clone().find_map(|(name, end)| Some((find(folder, name, budget)?, end)));
            let found = exact.or_else(|| {
                named.clone().find_map(|(name, end)| {
                    let (path, other) = find_in_other_case(folder, name, budget)?;
                    warnings.push(format!("the material library `{name}` {}", folder::read_instead(&other)));
                    Some((path, end))
                })
            });
            let end = match found {
                Some((path, end)) => {
                    paths.push(path);
                    end
                }
                None => {
                    let end = first_library(rest);
                    let name = unquoted(&rest[..end]);
                    warnings.push(format!("the material library `{name}` {}", missing(folder, name)));
                    end
                }
            };
            rest = rest[end..].trim_start();
        }
    }
    paths
}

/// The end of the first name in a list of missing libraries: behind `.mtl`, or else the list's end.
fn first_library(names: &str) -> usize {
    let mut ends = names.char_indices().filter(|(_, letter)| letter.is_ascii_whitespace()).map(|(at, _)| at);
    let is_library = |&end: &usize| names[..end].to_ascii_lowercase().ends_with(".mtl");
    ends.find(is_library).unwrap_or(names.len())
}

/// A name without the quotes around it.
fn unquoted(name: &str) -> &str {
    name.trim().strip_prefix('"').and_then(|name| name.strip_suffix('"')).unwrap_or(name.trim())
}

/// Finds the file `name` in `folder`, and its own folder: by its path, with `/` or `\`, else by its last part.
pub(super) fn find(folder: &Folder, name: &str, budget: &Budget) -> Option<(PathBuf, Folder)> {
    let name = name.replace('\\', "/");
    let last = name.rsplit('/').next().filter(|last| !last.is_empty())?;
    [folder.file(&name), folder.file(last)].into_iter().flatten().find(|(path, _)| budget.may_read().has(path))
}

/// As [`find`], ignoring case, and returns the file's own name too.
pub(super) fn find_in_other_case(folder: &Folder, name: &str, budget: &Budget) -> Option<((PathBuf, Folder), String)> {
    let last = name.rsplit(['/', '\\']).next().filter(|last| !last.is_empty())?;
    [name, last].into_iter().find_map(|name| folder.in_other_case(name, budget.may_read()))
}

/// The reason why [`find`] found nothing.
pub(super) fn missing(folder: &Folder, name: &str) -> &'static str {
    match folder.file(&name.replace('\\', "/")) {
        Some(_) => "is not there",
        None => "is outside of the scene's folder; if you trust the file, allow that (--allow-outside)",
    }
}

/// Converts `definition` to a metallic-roughness material.
///
/// `Pr` and `Pm` are taken unchanged. Without `Pr`, a material with highlights (`Ks` above zero) gets the roughness whose
/// GGX lobe is about as wide as the Blinn–Phong one: α = √(2 / (`Ns` + 2)), perceptual roughness = √α (Walter et al. 2007,
/// Microfacet Models for Refraction, §5.2; Burley 2012, §5.4). `Ni` below 1 means nothing and is left out.
fn material(definition: &Definition, folder: &Folder, textures: &mut TextureLoader) -> Material {
    let name = &definition.name;
    textures.begin_material(name, folder);
    for what in &definition.left_out {
        textures.warnings.push(format!("material `{name}`: left out {what}"));
    }
    let mut material = Material { name: name.clone(), double_sided: true, ..Material::default() };
    material.roughness = definition.roughness.unwrap_or_else(|| {
        let shiny = definition.specular.is_some_and(|specular| specular.max_element() > 0.0);
        definition.exponent.filter(|_| shiny).map_or(1.0, |exponent| (2.0 / (exponent + 2.0)).sqrt().sqrt())
    });
    material.metallic = definition.metallic.unwrap_or(0.0);
    material.ior = definition.ior.filter(|&ior| ior >= 1.0).unwrap_or(material.ior);
    let opacity = opacity(definition, textures);
    material.base_color = definition.diffuse.unwrap_or(Vec3::ONE).extend(opacity);
    paint(&mut material, definition, textures);
    if opacity < 1.0 {
        material.alpha = Alpha::Blend;
    }
    let (emissive, map) = (definition.emissive, &definition.emissive_map);
    material.emissive_texture =
        map.as_ref().and_then(|map| textures.get(map, |path| Recipe::Color { color: Some(path), opacity: None }));
    material.emissive = match material.emissive_texture {
        // Beside a texture, exporters write zeros or nothing.
        Some(_) => emissive.filter(|&emissive| emissive != Vec3::ZERO).unwrap_or(Vec3::ONE),
        None => emissive.unwrap_or(Vec3::ZERO),
    };
    if let Some(map) = &definition.normal_map {
        material.normal_texture = textures.get(map, Recipe::Quantity);
        material.normal_scale = map.strength;
    }
    roughen(&mut material, definition, textures);
    material
}

/// Opacity, 0 to 1: `d`, or else 1 - `Tr`. `Tr 1` without `d` is taken as opaque, as its writers mean it.
fn opacity(definition: &Definition, textures: &mut TextureLoader) -> f32 {
    match (definition.opacity, definition.transparency) {
        (Some(opacity), _) => opacity,
        (None, Some(1.0)) => {
            textures.warn("`Tr 1` would hide it; it is shown opaque");
            1.0
        }
        (None, transparency) => 1.0 - transparency.unwrap_or(0.0),
    }
}

/// Sets the texture of colour and opacity.
fn paint(material: &mut Material, definition: &Definition, textures: &mut TextureLoader) {
    let maps = [&definition.diffuse_map, &definition.opacity_map];
    let Some((map, [color, opacity])) = textures.find_two(maps, ["map_Kd", "map_d"]) else { return };
    let masked = opacity.is_some();
    material.base_color_texture = textures.make(map, Recipe::Color { color: color.clone(), opacity });
    if masked && material.base_color_texture.is_some() {
        material.alpha = Alpha::Mask { cutoff: 0.5 };
    } else if masked && color.is_some() {
        // One of the two can't be read; tries the colours alone.
        material.base_color_texture = textures.make(map, Recipe::Color { color, opacity: None });
    }
}

/// Sets the texture of roughness and metalness. A factor of zero, which exporters write beside a texture, would hide it.
fn roughen(material: &mut Material, definition: &Definition, textures: &mut TextureLoader) {
    let maps = [&definition.roughness_map, &definition.metallic_map];
    let Some((map, [roughness, metallic])) = textures.find_two(maps, ["map_Pr", "map_Pm"]) else { return };
    let unless_zero = |factor: Option<f32>| factor.filter(|&factor| factor > 0.0).unwrap_or(1.0);
    if roughness.is_some() {
        material.roughness = unless_zero(definition.roughness);
    }
    if metallic.is_some() {
        material.metallic = unless_zero(definition.metallic);
    }
    material.metallic_roughness_texture = textures.make(map, Recipe::RoughnessMetallic { roughness, metallic });
}

impl TextureLoader {
    /// Finds the files of two maps that make one texture, and the map whose options apply to both: the first present. Warns
    /// where the second map's options differ.
    fn find_two<'a>(
        &mut self,
        maps: [&'a Option<TextureStatement>; 2],
        [first, second]: [&str; 2],
    ) -> Option<(&'a TextureStatement, [Option<PathBuf>; 2])> {
        let found = maps.map(|map| map.as_ref().and_then(|map| self.find(map)));
        if let [Some((a, _)), Some((b, _))] = &found
            && (a.scale, a.offset, a.clamp) != (b.scale, b.offset, b.clamp)
        {
            self.warn(&format!("`{second}` is placed as `{first}`, not by its own options"));
        }
        let map = found.iter().flatten().map(|(map, _)| *map).next()?;
        Some((map, found.map(|found| found.map(|(_, path)| path))))
    }

    /// Returns the texture made by `recipe` of `map`'s file.
    fn get(&mut self, map: &TextureStatement, recipe: impl FnOnce(PathBuf) -> Recipe) -> Option<TextureUse> {
        let (_, path) = self.find(map)?;
        self.make(map, recipe(path))
    }

    /// Returns the texture of `recipe` with the transform of `map`.
    fn make(&mut self, map: &TextureStatement, recipe: Recipe) -> Option<TextureUse> {
        let wrap = if map.clamp { Wrap::ClampToEdge } else { Wrap::Repeat };
        let texture = self.texture(recipe, wrap)?;
        Some(TextureUse { image_from_mesh: image_from_mesh(map), ..TextureUse::new(texture) })
    }
}

/// Converts the options, which act on v upwards, to a frame's v downwards: v' = 1 - v.
fn image_from_mesh(map: &TextureStatement) -> Affine2 {
    let offset = Vec2::new(map.offset.x, 1.0 - map.scale.y - map.offset.y);
    Affine2::from_scale_angle_translation(map.scale, 0.0, offset)
}
