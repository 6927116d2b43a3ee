use bytemuck::Pod;
use glam::{Vec2, Vec3, Vec4};

use super::{FilmPlanes, ShadeLight, ShadeMaterial, ShadeSample, ShadeScene, ShadeSurroundings, Texels};
use crate::onward::{OnwardPlanes, mask_words};
use crate::pose::PosedAttributes;
use crate::{Buffer, Geometry, Gpu, GpuError, Groups, Kernel, Onward, OnwardLight};

/// The shade stage: adds each pixel's radiance at a sample to the film.
#[derive(Debug)]
pub struct Shade {
    /// Kernels for the camera's hits, without layers and with them, for films with each kind of ways; compiled at their
    /// first use.
    seen: [[Option<Kernel>; 3]; 2],
    /// The same for hits of secondary rays.
    onward: [[Option<Kernel>; 3]; 2],
    /// Whether any material has layers, and the kind of the film's ways.
    is_layered: bool,
    follows: Follows,
    /// Kernel for the transmittance of surfaces before lights, compiled at its first use.
    tint: Option<Kernel>,
    /// Kernels that choose directions of ambient occlusion, for the camera's hits and for those of secondary rays.
    look: Option<[Kernel; 2]>,
    /// The film of kernels that write no film.
    nothing: Buffer,
    rows: Kernel,
    sample: Buffer,
    scene: Buffer,
    lights: Buffer,
    attributes: Buffer,
    materials: Buffer,
    texels: Buffer,
    size: Buffer,
    /// Words of attributes, and the scene's surroundings.
    of_scene: ShadeScene,
    slots: u32,
    is_start_of_film: bool,
}

/// Attributes of triangles and vertices. A slice is empty if the scene doesn't have the attribute; the others have one
/// value for each triangle or vertex.
#[derive(Clone, Copy, Debug, Default)]
pub struct Attributes<'a> {
    /// Index of each triangle's material.
    pub material_of_triangle: &'a [u32],
    /// Two sets of texture coordinates for each vertex.
    pub tex_coords: [&'a [Vec2]; 2],
    /// Linear colour and opacity of each vertex.
    pub colors: &'a [Vec4],
    /// Unit normal of each vertex, or zero if the surface is flat.
    pub normals: Moving<'a, Vec3>,
    /// Unit tangent of each vertex and, in w, the sign of its bitangent; zero if there is none.
    pub tangents: Moving<'a, Vec4>,
}

/// Attributes that may change in every frame.
#[derive(Clone, Copy, Debug)]
pub enum Moving<'a, T> {
    /// One for each vertex, or none.
    Uploaded(&'a [T]),
    /// This many, which the stage `pose` writes.
    Posed(usize),
}

impl<T> Default for Moving<'_, T> {
    fn default() -> Self {
        Self::Uploaded(&[])
    }
}

impl<T: Pod> Moving<'_, T> {
    fn bytes(&self) -> u64 {
        match self {
            Self::Uploaded(elements) => size_of_val(*elements) as u64,
            Self::Posed(count) => (count * size_of::<T>()) as u64,
        }
    }

    /// Bytes to upload.
    fn uploaded(&self) -> &[u8] {
        match self {
            Self::Uploaded(elements) => bytemuck::cast_slice(elements),
            Self::Posed(_) => &[],
        }
    }
}

/// Results of earlier stages on the GPU.
#[derive(Clone, Copy, Debug)]
pub struct ShadeInputs<'a> {
    /// The triangle that each slot shows, in [`TileOrder`](umbrage_rays::TileOrder); `0xffffffff` for none.
    pub seen: &'a Buffer,
    /// Slots that each light reaches: one bit for each slot, the first in the lowest bit, light after light.
    pub lit: &'a Buffer,
    /// World position of each vertex: three f32.
    pub positions: &'a Buffer,
    /// Four u32 for each triangle: its vertices and its number.
    pub triangles: &'a Buffer,
}

/// A layer of a pixel's surfaces. Layers of a sample come front to back, samples one after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layer {
    /// Whether the sample is the first one, which starts the film.
    pub is_of_first_sample: bool,
    /// Whether it is the layer nearest to the camera.
    pub is_first: bool,
    /// Whether the surroundings are behind it.
    pub is_last: bool,
}

impl Layer {
    /// The one layer of a scene without transparent surfaces.
    #[must_use]
    pub fn only(is_of_first_sample: bool) -> Self {
        Self { is_of_first_sample, is_first: true, is_last: true }
    }
}

impl Shade {
    /// Slots of a workgroup.
    const WIDTH: u32 = 64;

    /// Makes the stage, with black surroundings.
    ///
    /// # Errors
    /// If the device has no memory for the tables.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let mut shade = Self {
            seen: Default::default(),
            onward: Default::default(),
            is_layered: false,
            follows: Follows::Nothing,
            tint: None,
            look: None,
            nothing: Buffer::storage(gpu, "no film"),
            rows: Kernel::new(gpu, "shade::rows", "rows", &[]),
            sample: Buffer::uniform(gpu, "shade sample"),
            scene: Buffer::uniform(gpu, "shade scene"),
            lights: Buffer::uniform(gpu, "lights"),
            attributes: Buffer::storage(gpu, "vertex attributes"),
            materials: Buffer::storage(gpu, "materials"),
            texels: Buffer::storage(gpu, "textures and panorama"),
            size: Buffer::uniform(gpu, "rows size"),
            of_scene: ShadeScene::default(),
            slots: 0,
            is_start_of_film: false,
        };
        *variant(&mut shade.seen, false, Follows::Nothing) =
            Some(kernel(gpu, "shade::shade", "shade", false, Follows::Nothing));
        shade.lights.reserve(gpu, (ShadeLight::MOST * size_of::<ShadeLight>()) as u64)?;
        shade.materials.reserve(gpu, size_of::<ShadeMaterial>() as u64)?;
        Ok(shade)
    }

    /// Replaces the materials and the images that they and the surroundings use.
    ///
    /// # Errors
    /// If they exceed the largest buffer of the device.
    pub fn set_materials(&mut self, gpu: &Gpu, materials: &[ShadeMaterial], texels: &Texels) -> Result<(), GpuError> {
        self.is_layered = materials.iter().any(|material| material.layer_bits != 0);
        self.materials.write(gpu, materials)?;
        self.texels.write(gpu, texels.words())
    }

    /// Replaces the scene's surroundings. A panorama is among the texels of [`Shade::set_materials`].
    pub fn set_surroundings(&mut self, surroundings: ShadeSurroundings) {
        self.of_scene.surroundings = surroundings;
    }

    /// Replaces the lights; the last `sky_lights` carry [the sky's light](ShadeScene::sky_light_count).
    ///
    /// # Errors
    /// If there are more than [`ShadeLight::MOST`].
    pub fn set_lights(&mut self, gpu: &Gpu, lights: &[ShadeLight], sky_lights: usize) -> Result<(), GpuError> {
        if lights.len() > ShadeLight::MOST {
            let [bytes, limit] = [lights.len(), ShadeLight::MOST].map(|count| (count * size_of::<ShadeLight>()) as u64);
            return Err(GpuError::TooLarge { what: format!("shading {} lights", lights.len()), bytes, limit });
        }
        self.of_scene.light_count = lights.len() as u32;
        self.of_scene.sky_light_count = sky_lights as u32;
        self.lights.write(gpu, lights)
    }

    /// Replaces the attributes of triangles and vertices. If `is_same_mesh`, materials of triangles, texture
    /// coordinates and colours are those of the last call, and only normals and tangents are uploaded. Those that the
    /// stage `pose` has written stay if the mesh is the same and their number hasn't changed.
    ///
    /// # Errors
    /// If they exceed the largest buffer of the device.
    pub fn set_attributes(
        &mut self,
        gpu: &Gpu,
        attributes: &Attributes<'_>,
        is_same_mesh: bool,
    ) -> Result<(), GpuError> {
        let Attributes { material_of_triangle, tex_coords: [first_set, second_set], colors, .. } = *attributes;
        // Static attributes come first, so that moving ones may come and go.
        let still: [&[u8]; 4] = [
            bytemuck::cast_slice(material_of_triangle),
            bytemuck::cast_slice(first_set),
            bytemuck::cast_slice(second_set),
            bytemuck::cast_slice(colors),
        ];
        let [of_first, of_second, of_third, of_fourth] = still.map(|part| part.len() as u64);
        let sizes = [of_first, of_second, of_third, of_fourth, attributes.normals.bytes(), attributes.tangents.bytes()];
        let mut starts = [0; 6];
        let mut bytes = 0;
        for (start, size) in starts.iter_mut().zip(sizes) {
            *start = bytes;
            bytes += size;
        }
        let had = self.attributes.bytes();
        self.attributes.reserve(gpu, bytes)?;
        if !is_same_mesh || self.attributes.bytes() != had {
            for (start, part) in starts.into_iter().zip(still) {
                self.attributes.write_at(gpu, start, part)?;
            }
        }
        self.attributes.write_at(gpu, starts[4], attributes.normals.uploaded())?;
        self.attributes.write_at(gpu, starts[5], attributes.tangents.uploaded())?;
        let word = |part: usize| if sizes[part] == 0 { ShadeScene::NO_WORD } else { (starts[part] / 4) as u32 };
        self.of_scene = ShadeScene {
            material_word: word(0),
            tex_coord_words: [word(1), word(2)],
            color_word: word(3),
            normal_word: word(4),
            tangent_word: word(5),
            ..self.of_scene
        };
        Ok(())
    }

    /// The buffer to which the stage `pose` writes normals and tangents, and their words in it.
    #[must_use]
    pub fn posed_attributes(&self) -> (&Buffer, PosedAttributes) {
        let word = |word: u32| (word != ShadeScene::NO_WORD).then_some(word);
        let (normal_word, tangent_word) = (word(self.of_scene.normal_word), word(self.of_scene.tangent_word));
        (&self.attributes, PosedAttributes { normal_word, tangent_word })
    }

    /// Prepares for one layer of one sample, until the next call: a submission has one.
    ///
    /// # Errors
    /// If the device has reported an error.
    ///
    /// # Panics
    /// If the film isn't of the sample's size, or has no plane for transmittance although there are several layers.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        sample: &ShadeSample,
        layer: Layer,
        film: &FilmPlanes,
    ) -> Result<(), GpuError> {
        let [width, height] = sample.size_pixels;
        assert_eq!(film.size(), [width, height], "a film of the image's size");
        assert!(film.through_plane().is_some() || (layer.is_first && layer.is_last), "a film for several layers");
        self.slots = umbrage_rays::TileOrder::new(width, height).slots() as u32;
        self.follows = Follows::of(film.ways());
        let Self { is_layered, follows, .. } = *self;
        variant(&mut self.seen, is_layered, follows)
            .get_or_insert_with(|| kernel(gpu, "shade::shade", "shade", is_layered, follows));
        self.is_start_of_film = layer.is_of_first_sample && layer.is_first;
        let sample = ShadeSample {
            words_per_light: self.slots / 32,
            is_first_sample: u32::from(layer.is_of_first_sample),
            is_first_layer: u32::from(layer.is_first),
            is_last_layer: u32::from(layer.is_last),
            first_plane: film.first_plane().unwrap_or(ShadeScene::NO_WORD),
            through_plane: film.through_plane().unwrap_or(ShadeScene::NO_WORD),
            flat_plane: film.flat_plane().unwrap_or(ShadeScene::NO_WORD),
            ways_plane: film.ways_plane().unwrap_or(ShadeScene::NO_WORD),
            ways_count: film.ways(),
            ..*sample
        };
        self.sample.write(gpu, &[sample])?;
        self.scene.write(gpu, &[self.of_scene])?;
        self.size.write(gpu, &[width, height, 0, 0])
    }

    /// Prepares for a generation of hits of secondary rays, and for the transmittance of light on its way to them,
    /// until the next call.
    ///
    /// # Errors
    /// If the device has reported an error.
    pub fn prepare_onward(&mut self, gpu: &Gpu, sample: &ShadeSample, onward: &Onward) -> Result<(), GpuError> {
        let OnwardPlanes { rays, ways_plane, ways, flat_plane } = onward.shaded();
        let Self { is_layered, follows, .. } = *self;
        variant(&mut self.onward, is_layered, follows)
            .get_or_insert_with(|| kernel(gpu, "shade::onward", "onward", is_layered, follows));
        self.prepare_asked(gpu, onward.light());
        let sample = ShadeSample {
            size_pixels: [rays, 1],
            words_per_light: mask_words(rays),
            ways_plane,
            ways_count: ways,
            flat_plane,
            tints_word: onward.tints_word(),
            points: rays,
            ..*sample
        };
        self.sample.write(gpu, &[sample])
    }

    /// Prepares for the questions about the camera's hits in a band that come before shading.
    ///
    /// # Errors
    /// If the device has reported an error.
    pub fn prepare_first(&mut self, gpu: &Gpu, sample: &ShadeSample, light: OnwardLight) -> Result<(), GpuError> {
        self.prepare_asked(gpu, light);
        let [width, height] = sample.size_pixels;
        let points = umbrage_rays::TileOrder::new(width, height).slots() as u32;
        self.scene.write(gpu, &[self.of_scene])?;
        self.sample.write(gpu, &[ShadeSample { points, ..*sample }])
    }

    fn prepare_asked(&mut self, gpu: &Gpu, light: OnwardLight) {
        if light.takes_colors {
            self.tint.get_or_insert_with(|| Kernel::new(gpu, "shade::tint", "tint", &[]));
        }
        if light.around > 0.0 {
            self.look.get_or_insert_with(|| Kernel::all(gpu, "shade::look", ["look", "look_onward"], &[]));
        }
    }

    /// Shades the hits of secondary rays, into the rays' own planes.
    ///
    /// # Panics
    /// If it wasn't prepared for that.
    pub fn record_onward(&self, gpu: &Gpu, pass: &mut wgpu::ComputePass<'_>, onward: &Onward, geometry: &Geometry) {
        let Some(kernel) = &self.onward[usize::from(self.is_layered)][self.follows as usize] else {
            panic!("it was prepared for")
        };
        let buffers = self.buffers(geometry, [onward.meetings(), onward.lit(), onward.planes()]);
        let rays = onward.shaded().rays;
        kernel.dispatch(gpu, pass, &buffers, Groups::Flat(rays.div_ceil(Self::WIDTH)));
    }

    /// Records the transmittance of light to points: `passed` lists the surfaces, and `of_points` has the start of each
    /// point's list.
    pub(crate) fn record_tint(
        &self,
        gpu: &Gpu,
        pass: &mut wgpu::ComputePass<'_>,
        geometry: &Geometry,
        [passed, of_points]: [&Buffer; 2],
        points: u32,
    ) {
        let Some(kernel) = &self.tint else { panic!("it was prepared for") };
        // It writes no film.
        let buffers = self.buffers(geometry, [passed, of_points, &self.nothing]);
        kernel.dispatch(gpu, pass, &buffers, Groups::Flat(points.div_ceil(Self::WIDTH)));
    }

    /// Records the choice of a direction of ambient occlusion for each of `points` points.
    pub(crate) fn record_look(
        &self,
        gpu: &Gpu,
        pass: &mut wgpu::ComputePass<'_>,
        geometry: &Geometry,
        [seen, lit, directions]: [&Buffer; 3],
        points: u32,
        is_first: bool,
    ) {
        let Some(kernels) = &self.look else { panic!("it was prepared for") };
        let buffers = self.buffers(geometry, [seen, lit, directions]);
        kernels[usize::from(!is_first)].dispatch(gpu, pass, &buffers, Groups::Flat(points.div_ceil(Self::WIDTH)));
    }

    fn buffers<'a>(&'a self, geometry: &'a Geometry, [seen, lit, film]: [&'a Buffer; 3]) -> [&'a Buffer; 11] {
        let Self { sample, scene, lights, attributes, materials, texels, .. } = self;
        let (positions, triangles) = (geometry.positions(), geometry.triangles());
        [sample, scene, lights, seen, lit, positions, triangles, attributes, materials, texels, film]
    }

    /// Number of workgroups of the prepared layer.
    #[must_use]
    pub fn groups(&self) -> u32 {
        self.slots / Self::WIDTH
    }

    /// Shades the layer if `groups` is the [prepared number](Self::groups), or does nothing if it is none.
    pub fn record(
        &self,
        gpu: &Gpu,
        pass: &mut wgpu::ComputePass<'_>,
        inputs: &ShadeInputs<'_>,
        film: &FilmPlanes,
        groups: Groups<'_>,
    ) {
        let ShadeInputs { seen, lit, positions, triangles } = inputs;
        let Self { sample, scene, lights, attributes, materials, texels, .. } = self;
        let buffers =
            [sample, scene, lights, seen, lit, positions, triangles, attributes, materials, texels, film.planes()];
        // First, since shading empties finished slots.
        if self.is_start_of_film && film.first_plane().is_some() {
            self.rows.dispatch(gpu, pass, &[&self.size, seen, film.triangle()], groups);
        }
        let Some(kernel) = &self.seen[usize::from(self.is_layered)][self.follows as usize] else {
            panic!("it was prepared for")
        };
        kernel.dispatch(gpu, pass, &buffers, groups);
    }
}

/// Kind of a film's ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Follows {
    Nothing,
    Smooth,
    Glossy,
}

impl Follows {
    fn of(ways: u32) -> Self {
        match ways {
            0 => Self::Nothing,
            Onward::GLOSSY_WAYS => Self::Glossy,
            _ => Self::Smooth,
        }
    }
}

fn variant(kernels: &mut [[Option<Kernel>; 3]; 2], is_layered: bool, follows: Follows) -> &mut Option<Kernel> {
    &mut kernels[usize::from(is_layered)][follows as usize]
}

/// A kernel that shades.
fn kernel(gpu: &Gpu, path: &str, entry: &'static str, is_layered: bool, follows: Follows) -> Kernel {
    let constant = |name, is_so| (name, f64::from(u8::from(is_so)));
    let constants = [
        constant("LAYERS", is_layered),
        constant("GLOSS", follows == Follows::Glossy),
        constant("FOLLOWS", follows != Follows::Nothing),
    ];
    // The camera's hits may be followed; hits of secondary rays always are.
    let count = if entry == "shade" { constants.len() } else { constants.len() - 1 };
    Kernel::new(gpu, path, entry, &constants[..count])
}
