// Inputs of shading, as tables.rs writes them, and the film.

const NO_TRIANGLE: u32 = 0xffffffffu;
// Stands for missing attributes.
const NO_WORD: u32 = 0xffffffffu;

const PROJECTION_PERSPECTIVE: u32 = 0u;
const PROJECTION_ORTHOGRAPHIC: u32 = 1u;

const SURROUNDINGS_COLOR: u32 = 0u;
const SURROUNDINGS_SKY: u32 = 1u;
const SURROUNDINGS_IMAGE: u32 = 2u;
const SURROUNDINGS_TRANSPARENT: u32 = 3u;

const LIGHT_POINT: u32 = 0u;
const LIGHT_SPOT: u32 = 1u;
const LIGHT_DIRECTIONAL: u32 = 2u;
const LIGHT_FLAT: u32 = 3u;
const MOST_LIGHTS: u32 = 1024u;

const TEXTURE_BASE_COLOR: u32 = 0u;
const TEXTURE_METALLIC_ROUGHNESS: u32 = 1u;
const TEXTURE_NORMAL: u32 = 2u;
const TEXTURE_OCCLUSION: u32 = 3u;
const TEXTURE_EMISSIVE: u32 = 4u;
const TEXTURE_TRANSMISSION: u32 = 5u;
// Number of these; the textures of layers come after them.
const TEXTURES: u32 = 6u;
const TEXTURE_SPECULAR: u32 = 6u;
const TEXTURE_SPECULAR_COLOR: u32 = 7u;
const TEXTURE_COAT: u32 = 8u;
const TEXTURE_COAT_ROUGHNESS: u32 = 9u;
const TEXTURE_COAT_NORMAL: u32 = 10u;
const TEXTURE_SHEEN_COLOR: u32 = 11u;
const TEXTURE_SHEEN_ROUGHNESS: u32 = 12u;
const TEXTURE_GROOVES: u32 = 13u;
const TEXTURE_FILM: u32 = 14u;
const TEXTURE_FILM_THICKNESS: u32 = 15u;
const ALL_TEXTURES: u32 = 16u;

// Bits of a material's layers.
const LAYER_SPECULAR: u32 = 1u;
const LAYER_COAT: u32 = 2u;
const LAYER_SHEEN: u32 = 4u;
const LAYER_GROOVES: u32 = 8u;
const LAYER_FILM: u32 = 16u;

// First words of fixed tables in shade_texels.
const LINEAR_FROM_SRGB_WORD: u32 = 0u;
const SPECULAR_ALBEDO_WORD: u32 = 256u;
const SPECULAR_ALBEDO_SIDE: u32 = 24u;
// As large as the table of specular albedo.
const SHEEN_ALBEDO_WORD: u32 = 1408u;

// The camera rays of one sample, and the layer of surfaces that they see.
struct ShadeSample {
    position: vec3<f32>,
    projection: u32,
    right: vec3<f32>,
    // Half the height of the view, at depth 1 for a perspective.
    half_height: f32,
    up: vec3<f32>,
    // Width of a ray's cone at depth 0, and how much it grows for each unit of depth.
    footprint: f32,
    forward: vec3<f32>,
    footprint_per_depth: f32,
    offset_pixels: vec2<f32>,
    // Size of the rows that are shaded at once.
    size_pixels: vec2<u32>,
    // Depth in the film's first plane for a pixel without a triangle.
    miss_depth: f32,
    words_per_light: u32,
    is_first_sample: u32,
    is_first_layer: u32,
    is_last_layer: u32,
    // First pixels of the film's planes; NO_WORD for one that isn't kept.
    first_plane: u32,
    through_plane: u32,
    flat_plane: u32,
    // The first of these rows, and the number of rows of the whole image.
    first_row: u32,
    image_height: u32,
    // Maximum number of mirrors and glass surfaces in a row, and minimum throughput of a followed path.
    bounces: u32,
    least_contribution: f32,
    // First pixel of the film's planes of ways, and their number; NO_WORD if they aren't kept.
    ways_plane: u32,
    ways_count: u32,
    // First word of the transmittances before lights in shade_lit; NO_WORD if all of them are one.
    tints_word: u32,
    // Number of the first of these pixels in the image, and of the sample: random points depend on both.
    first_pixel: u32,
    number: u32,
    // Number of points whose visibility from lights is found, and whether ambient visibility is too.
    points: u32,
    looks_around: u32,
}

struct ShadeSurroundings {
    // Coefficients of spherical harmonics; w is unused.
    irradiance: array<vec4<f32>, 9>,
    color: vec3<f32>,
    kind: u32,
    panorama_size: vec2<u32>,
    panorama_levels: u32,
    // Index in shade_texels of the list of each level's first texel.
    panorama_word: u32,
}

struct ShadeScene {
    surroundings: ShadeSurroundings,
    // First words of attributes in shade_attributes.
    material_word: u32,
    normal_word: u32,
    tangent_word: u32,
    color_word: u32,
    tex_coord_words: vec2<u32>,
    light_count: u32,
    sky_light_count: u32,
}

struct ShadeLight {
    position: vec3<f32>,
    kind: u32,
    // Direction of travel.
    direction: vec3<f32>,
    // 0 for a light that never fades to zero.
    range: f32,
    emitted: vec3<f32>,
    // Cosine of a spot light's outer half-angle, and the difference to that of its inner one.
    outer_cosine: f32,
    cosine_span: f32,
}

struct ShadeMaterial {
    base_color: vec4<f32>,
    emissive: vec3<f32>,
    metallic: f32,
    roughness: f32,
    ior: f32,
    transmission: f32,
    normal_scale: f32,
    occlusion_strength: f32,
    is_blended: u32,
    is_unlit: u32,
    catches_shadows: u32,
    // Whether it bounds a volume of glass; the dispersion there, and the distance after which light has the attenuation
    // colour, 0 for never.
    bounds_volume: u32,
    dispersion: f32,
    attenuation_distance: f32,
    // Less opaque points are cut out, unless it is 0.
    mask_cutoff: f32,
    attenuation_color: vec3<f32>,
    // Bits of its layers: LAYER_SPECULAR …
    layer_bits: u32,
    layers: ShadeLayers,
    textures: array<ShadeTexture, ALL_TEXTURES>,
}

// Layers on a material's surface and in it, as far as its bits are set.
struct ShadeLayers {
    specular_color: vec3<f32>,
    specular: f32,
    sheen_color: vec3<f32>,
    sheen_roughness: f32,
    coat: f32,
    coat_roughness: f32,
    coat_normal_scale: f32,
    // Strength of anisotropy, and the cosine and sine of the rotation of its direction.
    stretch: f32,
    stretch_turn: vec2<f32>,
    film: f32,
    film_ior: f32,
    // Thickness where its texture is 0 and 1.
    film_nanometers: vec2<f32>,
}

// A texture as a material uses it.
struct ShadeTexture {
    // Matrix from the mesh's texture coordinates to the image's: two columns, then the translation.
    matrix: vec4<f32>,
    translation: vec2<f32>,
    size: vec2<u32>,
    wrap: vec2<u32>,
    // 0 if there is no texture.
    levels: u32,
    // Index in shade_texels of the list of each level's first texel.
    levels_word: u32,
    tex_coord_set: u32,
    is_nearest: u32,
    is_srgb: u32,
}

@group(0) @binding(0) var<uniform> shade_sample: ShadeSample;
@group(0) @binding(1) var<uniform> shade_scene: ShadeScene;
@group(0) @binding(2) var<uniform> shade_lights: array<ShadeLight, MOST_LIGHTS>;
// The triangle of each slot. Slots that later layers needn't shade are emptied.
@group(0) @binding(3) var<storage, read_write> shade_seen: array<u32>;
// One bit for each slot and light, light after light.
@group(0) @binding(4) var<storage, read> shade_lit: array<u32>;
@group(0) @binding(5) var<storage, read> shade_positions: array<f32>;
// Three vertices and the number of each triangle.
@group(0) @binding(6) var<storage, read> shade_triangles: array<vec4<u32>>;
// Materials of triangles and attributes of vertices.
@group(0) @binding(7) var<storage, read> shade_attributes: array<u32>;
@group(0) @binding(8) var<storage, read> shade_materials: array<ShadeMaterial>;
// Fixed tables, then texels of textures (RGBA8) and of the panorama (three f32).
@group(0) @binding(9) var<storage, read> shade_texels: array<u32>;
// Planes of pixels in rows: colour and coverage summed over the samples; normal and depth at the first sample; the
// layers' transmittance so far.
@group(0) @binding(10) var<storage, read_write> shade_film: array<vec4<f32>>;
