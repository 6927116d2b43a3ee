// What shading reads, as tables.rs writes it, and the film.

const NO_TRIANGLE: u32 = 0xffffffffu;
// Stands for attributes that no vertex has.
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
// So many, and behind them those of layers.
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

// Where fixed tables are in shade_texels.
const LINEAR_FROM_SRGB_WORD: u32 = 0u;
const SPECULAR_ALBEDO_WORD: u32 = 256u;
const SPECULAR_ALBEDO_SIDE: u32 = 24u;
// As large as the other.
const SHEEN_ALBEDO_WORD: u32 = 1408u;

// The camera rays of one sample, and which layer of surfaces they meet.
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
    // Of the rows that are shaded at once.
    size_pixels: vec2<u32>,
    // What the film's first plane says of a pixel that shows nothing.
    miss_depth: f32,
    words_per_light: u32,
    is_first_sample: u32,
    is_first_layer: u32,
    is_last_layer: u32,
    // Where planes of the film are, in pixels; NO_WORD for one that isn't kept.
    first_plane: u32,
    through_plane: u32,
    flat_plane: u32,
    // The first of these rows, and how many the whole image has.
    first_row: u32,
    image_height: u32,
    // How many mirrors and surfaces of glass in a row are followed, and what isn't of what they show since it is less.
    bounces: u32,
    least_contribution: f32,
    // Where the film's planes of ways are, in pixels, and how many; NO_WORD where they aren't kept.
    ways_plane: u32,
    ways_count: u32,
    // Where in shade_lit it says how much of lights comes through what is before surfaces; NO_WORD where all of it does.
    tints_word: u32,
    // The first of these pixels among all of the image, and the number of the sample: what is drawn depends on them.
    first_pixel: u32,
    number: u32,
    // How many points lights are asked about, and whether light from all around is too.
    points: u32,
    looks_around: u32,
}

struct ShadeSurroundings {
    // Coefficients of spherical harmonics; w is nothing.
    irradiance: array<vec4<f32>, 9>,
    color: vec3<f32>,
    kind: u32,
    panorama_size: vec2<u32>,
    panorama_levels: u32,
    // Where in shade_texels each level's first texel is listed.
    panorama_word: u32,
}

struct ShadeScene {
    surroundings: ShadeSurroundings,
    // Where attributes are in shade_attributes.
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
    // In which the light travels.
    direction: vec3<f32>,
    // 0 for a light that never fades to nothing.
    range: f32,
    emitted: vec3<f32>,
    // Of a spot light's outer half-angle, and how much greater that of its inner one is.
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
    // Whether it is the surface of a body of glass; how far apart colours are refracted there, and what colour is left of
    // light after some distance, which is 0 where all is.
    bounds_volume: u32,
    dispersion: f32,
    attenuation_distance: f32,
    // Less opaque points aren't there, unless it is 0.
    mask_cutoff: f32,
    attenuation_color: vec3<f32>,
    // Which layers it has: LAYER_SPECULAR …
    layer_bits: u32,
    layers: ShadeLayers,
    textures: array<ShadeTexture, ALL_TEXTURES>,
}

// What lies on a material's surface and in it, as far as its bits say.
struct ShadeLayers {
    specular_color: vec3<f32>,
    specular: f32,
    sheen_color: vec3<f32>,
    sheen_roughness: f32,
    coat: f32,
    coat_roughness: f32,
    coat_normal_scale: f32,
    // How strongly highlights are stretched, and the cosine and sine of what the direction is turned by.
    stretch: f32,
    stretch_turn: vec2<f32>,
    film: f32,
    film_ior: f32,
    // Where its texture has 0 and 1.
    film_nanometers: vec2<f32>,
}

// A texture as a material uses it.
struct ShadeTexture {
    // From the mesh's texture coordinates to the image's: two columns, then what is added.
    matrix: vec4<f32>,
    translation: vec2<f32>,
    size: vec2<u32>,
    wrap: vec2<u32>,
    // 0 where there is no texture.
    levels: u32,
    // Where in shade_texels each level's first texel is listed.
    levels_word: u32,
    tex_coord_set: u32,
    is_nearest: u32,
    is_srgb: u32,
}

@group(0) @binding(0) var<uniform> shade_sample: ShadeSample;
@group(0) @binding(1) var<uniform> shade_scene: ShadeScene;
@group(0) @binding(2) var<uniform> shade_lights: array<ShadeLight, MOST_LIGHTS>;
// What each slot shows.
// Slots that later layers needn't look at are emptied.
@group(0) @binding(3) var<storage, read_write> shade_seen: array<u32>;
// One bit a slot for each light, light after light.
@group(0) @binding(4) var<storage, read> shade_lit: array<u32>;
@group(0) @binding(5) var<storage, read> shade_positions: array<f32>;
// Three vertices and the number of each triangle.
@group(0) @binding(6) var<storage, read> shade_triangles: array<vec4<u32>>;
// Materials of triangles and attributes of vertices.
@group(0) @binding(7) var<storage, read> shade_attributes: array<u32>;
@group(0) @binding(8) var<storage, read> shade_materials: array<ShadeMaterial>;
// Fixed tables, then texels of textures (RGBA8) and of the panorama (three f32).
@group(0) @binding(9) var<storage, read> shade_texels: array<u32>;
// Planes of pixels in rows: colour and coverage summed over the samples; normal and depth at the first sample; what the
// layers so far let through.
@group(0) @binding(10) var<storage, read_write> shade_film: array<vec4<f32>>;
