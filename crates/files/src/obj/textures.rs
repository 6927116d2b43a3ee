use std::collections::HashMap;
use std::path::{Path, PathBuf};

use umbrage_scene::{ColorSpace, Filter, Texture, Wrap};

use super::library::TextureStatement;
use super::materials::{find, find_in_other_case, missing};
use crate::folder::{self, Folder};
use crate::memory::Budget;
use crate::texture;

/// Makes the textures of a file's materials, each once; some combine two images.
#[derive(Debug, Default)]
pub(super) struct TextureLoader {
    textures: Vec<Texture>,
    made: HashMap<(Recipe, Wrap), Option<u32>>,
    /// Name of the current material, for warnings.
    material: String,
    /// The folder of the material's library.
    folder: Folder,
    pub(super) warnings: Vec<String>,
    budget: Budget,
}

/// A texture's source images and their combination.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum Recipe {
    /// sRGB colours, white without an image, and opacity, 1 without an image.
    Color { color: Option<PathBuf>, opacity: Option<PathBuf> },
    /// The image's numbers.
    Quantity(PathBuf),
    /// Roughness in green and metalness in blue, 1 where there is no image.
    RoughnessMetallic { roughness: Option<PathBuf>, metallic: Option<PathBuf> },
}

#[derive(Debug)]
struct Texels {
    size: [u32; 2],
    texels: Vec<[u8; 4]>,
}

impl TextureLoader {
    /// Without textures yet.
    pub(super) fn new(budget: &Budget) -> Self {
        Self { budget: budget.clone(), ..Self::default() }
    }

    /// Sets the material whose textures follow.
    pub(super) fn begin_material(&mut self, name: &str, folder: &Folder) {
        name.clone_into(&mut self.material);
        self.folder.clone_from(folder);
    }

    pub(super) fn warn(&mut self, what: &str) {
        self.warnings.push(format!("material `{}`: {what}", self.material));
    }

    /// Finds the map's file; warns where it is missing.
    pub(super) fn find<'a>(&mut self, map: &'a TextureStatement) -> Option<(&'a TextureStatement, PathBuf)> {
        let path = find(&self.folder, &map.file, &self.budget).or_else(|| {
            let found = find_in_other_case(&self.folder, &map.file, &self.budget);
            let why = match &found {
                Some((_, other)) => folder::read_instead(other),
                None => missing(&self.folder, &map.file).to_owned(),
            };
            self.warn(&format!("the texture `{}` {why}", map.file));
            found.map(|(path, _)| path)
        });
        path.map(|(path, _)| (map, path))
    }

    /// Returns the index of the texture made by `recipe`; `None`, with a warning, where an image can't be read.
    pub(super) fn texture(&mut self, recipe: Recipe, wrap: Wrap) -> Option<u32> {
        let key = (recipe, wrap);
        if let Some(&made) = self.made.get(&key) {
            return made;
        }
        let made = match textured(&key.0, wrap, &self.budget.in_passing()) {
            Ok(texture) => {
                self.textures.push(texture);
                // Never truncated: four billion textures don't fit in memory.
                Some(self.textures.len() as u32 - 1)
            }
            Err(why) => {
                self.warn(&why);
                None
            }
        };
        self.made.insert(key, made);
        made
    }

    /// Returns the textures and the warnings.
    pub(super) fn finish(self) -> (Vec<Texture>, Vec<String>) {
        (self.textures, self.warnings)
    }
}

fn textured(recipe: &Recipe, wrap: Wrap, budget: &Budget) -> Result<Texture, String> {
    let read = |path: &Option<PathBuf>| path.as_deref().map(|path| Texels::read(path, budget)).transpose();
    let (image, space) = match recipe {
        Recipe::Color { color, opacity } => (colored(read(color)?, read(opacity)?, budget)?, ColorSpace::Srgb),
        Recipe::Quantity(path) => (Texels::read(path, budget)?, ColorSpace::Linear),
        Recipe::RoughnessMetallic { roughness, metallic } => {
            (roughness_metallic(read(roughness)?, read(metallic)?, budget)?, ColorSpace::Linear)
        }
    };
    let name = recipe.first_path().map(|path| path.display().to_string()).unwrap_or_default();
    texture::kept_by(Texture::new(name, image.size, image.texels, space, Filter::Linear, [wrap, wrap]), budget)
}

impl Recipe {
    fn first_path(&self) -> Option<&Path> {
        match self {
            Self::Quantity(path) => Some(path),
            Self::Color { color: first, opacity: second }
            | Self::RoughnessMetallic { roughness: first, metallic: second } => first.as_deref().or(second.as_deref()),
        }
    }
}

/// Combines the colours of one image and the opacity of another; OBJ ignores the colour image's own opacity.
fn colored(color: Option<Texels>, opacity: Option<Texels>, budget: &Budget) -> Result<Texels, String> {
    let color = color.map(|mut image| {
        for texel in &mut image.texels {
            texel[3] = u8::MAX;
        }
        image
    });
    let Some(opacity) = opacity else { return Ok(color.unwrap_or_else(Texels::white)) };
    // An opacity map has its values in the alpha channel, or else is grey.
    let has_alpha = opacity.texels.iter().any(|texel| texel[3] < u8::MAX);
    let opacity_of = |texel: [u8; 4]| if has_alpha { texel[3] } else { luminance(texel) };
    let color = color.unwrap_or_else(Texels::white);
    combined(&color, &opacity, budget, |[r, g, b, _], opacity| [r, g, b, opacity_of(opacity)])
}

fn roughness_metallic(roughness: Option<Texels>, metallic: Option<Texels>, budget: &Budget) -> Result<Texels, String> {
    let [roughness, metallic] = [roughness, metallic].map(|image| image.unwrap_or_else(Texels::white));
    let mix = |roughness, metallic| [u8::MAX, luminance(roughness), luminance(metallic), u8::MAX];
    combined(&roughness, &metallic, budget, mix)
}

/// Combines two images texel by texel at the larger width and height of the two.
fn combined(
    a: &Texels,
    b: &Texels,
    budget: &Budget,
    mix: impl Fn([u8; 4], [u8; 4]) -> [u8; 4],
) -> Result<Texels, String> {
    let size = [a.size[0].max(b.size[0]), a.size[1].max(b.size[1])];
    texture::take(size, budget)?;
    let texels = (0..size[1])
        .flat_map(|y| (0..size[0]).map(move |x| [x, y]))
        .map(|at| mix(a.nearest(at, size), b.nearest(at, size)));
    Ok(Texels { size, texels: texels.collect() })
}

/// Rec. 709 luma in 8 bits; exact for greys.
fn luminance([r, g, b, _]: [u8; 4]) -> u8 {
    ((54 * u32::from(r) + 183 * u32::from(g) + 19 * u32::from(b)) / 256) as u8
}

impl Texels {
    fn read(path: &Path, budget: &Budget) -> Result<Self, String> {
        let named = |why: String| format!("the texture {}: {why}", path.display());
        let bytes = folder::read(path, budget).map_err(|error| named(error.to_string()))?;
        let (size, texels) = texture::decode_texels(&bytes, budget).map_err(named)?;
        Ok(Self { size, texels })
    }

    fn white() -> Self {
        Self { size: [1, 1], texels: vec![[u8::MAX; 4]] }
    }

    /// The texel nearest to texel `at` of an image of `size` that covers the same square.
    fn nearest(&self, at: [u32; 2], size: [u32; 2]) -> [u8; 4] {
        // No side is above Texture::MAX_SIDE, so the products fit.
        let [x, y] = [0, 1].map(|axis| at[axis] * self.size[axis] / size[axis]);
        self.texels[y as usize * self.size[0] as usize + x as usize]
    }
}
