/// Words of all images, one after the other, each with a list of its levels first: all in one buffer of the GPU.
#[derive(Clone, Debug)]
pub struct Texels {
    words: Vec<u32>,
}

impl Texels {
    /// First word of the linear values of sRGB bytes.
    pub const LINEAR_FROM_SRGB_WORD: u32 = 0;
    /// First word of the table of specular albedo.
    pub const SPECULAR_ALBEDO_WORD: u32 = 256;
    /// First word of the table of the sheen's albedo.
    pub const SHEEN_ALBEDO_WORD: u32 = 1408;
    /// Entries along each side of the tables of albedo.
    pub const ALBEDO_SIDE: usize = 24;

    /// Makes texels without images, behind fixed tables: the linear value of each sRGB byte, scale and bias of specular
    /// albedo by roughness (rows) and cosine (columns), and the sheen's albedo by roughness and the root of the cosine,
    /// all from 0 to 1; without the last if no material has sheen.
    #[must_use]
    pub fn new(
        linear_from_srgb: &[f32; 256],
        specular_albedo: &[[[f32; 2]; Self::ALBEDO_SIDE]; Self::ALBEDO_SIDE],
        sheen_albedo: Option<&[[f32; Self::ALBEDO_SIDE]; Self::ALBEDO_SIDE]>,
    ) -> Self {
        let specular = specular_albedo.as_flattened().as_flattened();
        let sheen = sheen_albedo.map_or(&[][..], |albedo| albedo.as_flattened());
        Self { words: linear_from_srgb.iter().chain(specular).chain(sheen).map(|value| value.to_bits()).collect() }
    }

    /// Adds an image from its levels, the full one first, each half as wide and high as the one before, rounded down
    /// but at least 1. Levels are words in rows, the upper row first; RGBA8 with red in the lowest byte for a texture,
    /// three f32 for each texel of a panorama. Returns the index of its list of levels.
    pub fn add<L: IntoIterator<Item = u32>>(&mut self, levels: impl ExactSizeIterator<Item = L>) -> u32 {
        let list = self.words.len();
        self.words.resize(list + levels.len(), 0);
        for (index, level) in levels.enumerate() {
            self.words[list + index] = self.words.len() as u32;
            self.words.extend(level);
        }
        list as u32
    }

    /// All words, as shaders read them.
    #[must_use]
    pub fn words(&self) -> &[u32] {
        &self.words
    }
}
