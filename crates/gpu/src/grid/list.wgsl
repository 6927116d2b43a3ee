// Stages `count` and `scatter`: list the triangles that each cell may need. `count` counts them; `scatter`, after a
// prefix sum over the counts, writes them one cell after the other.
//
// Both must make the same decisions, and two pipelines may round differently. So decisions are made in integers, or by
// `count` alone, which notes them for `scatter`.

import package::dispatch::{Invocation, flat_group, flat_index, groups_of};
import package::grid::header::{HEADER_KEYS, HEADER_LARGE, HEADER_LARGE_GROUPS, HEADER_POINT_KEYS};
import package::grid::set_up::{RECT_EMPTY, Rect, corners_of, edges_near, misses_box, rect_of};
import package::grid::space::{Space, VERTEX_REGULAR, ordered_bits, slice_between};
import package::light::cells::{SPREAD_STARTS, spread_base};
import package::light::sphere::arcs::{arc_of, bins_of, merged, nearest_key, seen_angles};
import package::light::sphere::turn::{ANGLE_NOWHERE};
import package::mask::flags::{TRIANGLE_SHADOWLESS};

struct ListSize {
    triangles: u32,
    vertices: u32,
}

// A triangle over more cells than this is taken by workgroups, one for each CHUNK cells.
const MOST_CELLS_AT_ONCE: u32 = 4u;
const CHUNK: u32 = 256u;
// Words of a chunk: id, face, rectangle of tiles (first, last: row · 2¹⁶ + column), slice, chunk, nearest key, and from
// LARGE_BITS on a bit for each cell.
const LARGE_WORDS: u32 = 16u;
const LARGE_BITS: u32 = 8u;

// Whether only cells with points matter, up to the farthest of these.
override HAS_POINTS: bool = false;
// Whether the cells are those of a light that sees by angles.
override HAS_ANGLES: bool = false;

@group(0) @binding(0) var<uniform> list_size: ListSize;
@group(0) @binding(1) var<uniform> spaces: array<Space, 6>;
// Three vertices, and the material and flags.
@group(0) @binding(2) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> vertices: array<vec4<u32>>;
// `count`: the number of triangles; `scatter`: the index of the next pair.
@group(0) @binding(4) var<storage, read_write> cells: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> large: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> header: array<atomic<u32>>;
// For each tile the complement of its farthest point's key, as ordered bits; zero if it has no points.
@group(0) @binding(7) var<storage, read> farthest_point: array<u32>;
// For each axis of a face the column of each bin.
@group(0) @binding(8) var<storage, read> spread: array<u32>;
@group(0) @binding(9) var<storage, read_write> pairs: array<u32>;

struct Listed {
    // Whether all decisions about it are made in integers.
    is_simple: bool,
    tiles: Rect,
    // For angles, more columns and rows beyond the seam.
    beyond: Rect,
    slice: u32,
    // Ordered bits of a key that isn't below the key of any point of the triangle.
    nearest: u32,
}

fn tile_count(tiles: Rect) -> u32 {
    let size = max(tiles.last - tiles.first + 1, vec2<i32>(0));
    return u32(size.x) * u32(size.y);
}

const LISTED_NOWHERE: Listed = Listed(false, RECT_EMPTY, RECT_EMPTY, 0u, 0u);

fn listed(face: u32, id: u32) -> Listed {
    let triangle = triangles[id].xyz;
    let is_shadowless = HAS_POINTS && (triangles[id].w & TRIANGLE_SHADOWLESS) != 0u;
    if is_shadowless || any(triangle >= vec3<u32>(list_size.vertices)) {
        return LISTED_NOWHERE;
    }
    if HAS_ANGLES {
        return listed_by_angles(triangle);
    }
    let raster = spaces[face].raster;
    let base = face * list_size.vertices;
    let corners = corners_of(vertices[base + triangle.x], vertices[base + triangle.y], vertices[base + triangle.z]);
    let pixels = rect_of(corners, raster);
    if any(pixels.last < pixels.first) {
        return LISTED_NOWHERE;
    }
    let tiles = Rect(tile_of(face, pixels.first), tile_of(face, pixels.last));
    var nearest = 0xffffffffu;
    if corners.kind == VERTEX_REGULAR {
        // Points have an error of `depth_error` as well.
        let keys = bitcast<vec3<f32>>(vec3<u32>(corners.a.z, corners.b.z, corners.c.z)) + 2.0 * raster.depth_error;
        let highest = max(max(ordered_bits(keys.x), ordered_bits(keys.y)), ordered_bits(keys.z));
        // The corners' keys have an error of one or two units in the last place.
        nearest = highest + min(8u, 0xffffffffu - highest);
    }
    return Listed(corners.kind == VERTEX_REGULAR, tiles, RECT_EMPTY, slice_of(face, nearest), nearest);
}

// A vertex has two records: α, behind its position, and β, behind its offset from the light.
fn listed_by_angles(triangle: vec3<u32>) -> Listed {
    let record = 2u * triangle;
    let a = vertices[record.x + 1u];
    let b = vertices[record.y + 1u];
    let c = vertices[record.z + 1u];
    let alpha = vec3<i32>(vec3<u32>(vertices[record.x].w, vertices[record.y].w, vertices[record.z].w));
    let beta = vec3<i32>(vec3<u32>(a.w, b.w, c.w));
    if any(alpha == vec3<i32>(ANGLE_NOWHERE)) {
        return LISTED_NOWHERE;
    }
    let columns = columns_of(0u, alpha);
    let rows = columns_of(1u, beta);
    let tiles = Rect(vec2<i32>(columns.x, rows.x), vec2<i32>(columns.y, rows.y));
    let beyond = Rect(vec2<i32>(columns.z, rows.z), vec2<i32>(columns.w, rows.w));
    let nearest = nearest_key(a.xyz, b.xyz, c.xyz);
    return Listed(true, tiles, beyond, slice_of(0u, nearest), nearest);
}

// The columns, or rows, that a triangle may be in: first and last before the seam, first and last beyond it; none if
// first > last.
fn columns_of(plane: u32, corners: vec3<i32>) -> vec4<i32> {
    let seen = seen_angles(plane);
    var columns = bins_of(arc_of(corners, seen), seen);
    for (var end = 0u; end < 4u; end++) {
        // An empty range stays empty.
        columns[end] = select(columns[end], i32(spread[spread_base(0u, plane) + u32(max(columns[end], 0))]), columns[end] >= 0);
    }
    return merged(columns);
}

// The tile of a pixel; of a light, the cell of a bin.
fn tile_of(face: u32, pixel: vec2<i32>) -> vec2<i32> {
    if HAS_POINTS {
        let column = spread[spread_base(face, 0u) + u32(pixel.x)];
        let row = spread[spread_base(face, 1u) + u32(pixel.y)];
        return vec2<i32>(i32(column), i32(row));
    }
    return pixel >> vec2<u32>(spaces[face].raster.tile_bits);
}

// The pixels (or bins) of a tile: the first, and the end.
fn pixels_of(face: u32, tile: vec2<i32>) -> vec4<i32> {
    if HAS_POINTS {
        let column = spread_base(face, 0u) + SPREAD_STARTS + u32(tile.x);
        let row = spread_base(face, 1u) + SPREAD_STARTS + u32(tile.y);
        return vec4<i32>(vec4<u32>(spread[column], spread[row], spread[column + 1u], spread[row + 1u]));
    }
    let side = 1 << spaces[face].raster.tile_bits;
    return vec4<i32>(tile * side, tile * side + side);
}

// Slices are equal parts of the visible range; for lights, of the range of points.
fn slice_of(face: u32, nearest: u32) -> u32 {
    let word = select(HEADER_KEYS + 2u * face, HEADER_POINT_KEYS, HAS_POINTS);
    let first = atomicLoad(&header[word]);
    let last = ~atomicLoad(&header[word + 1u]);
    return slice_between(nearest, first, last, spaces[face].raster.slices);
}

fn index_of_cell(face: u32, tile: vec2<i32>, slice: u32) -> u32 {
    let raster = spaces[face].raster;
    return raster.first_cell + (u32(tile.y) * raster.tile_columns + u32(tile.x)) * raster.slices + slice;
}

// Whether the tile of a cell has a point farther away than the key `nearest`.
fn is_wanted(face: u32, cell: u32, nearest: u32) -> bool {
    if !HAS_POINTS {
        return true;
    }
    let farthest = farthest_point[cell / spaces[face].raster.slices];
    // Zero marks a tile without points: no point has that key.
    return farthest != 0u && nearest > ~farthest;
}

fn take(cell: u32, id: u32, is_scatter: bool) {
    let slot = atomicAdd(&cells[cell], 1u);
    if is_scatter && slot < arrayLength(&pairs) {
        pairs[slot] = id;
    }
}

fn list_small(face: u32, id: u32, is_scatter: bool) {
    var listed = listed(face, id);
    if !HAS_ANGLES {
        list_part(face, id, listed, is_scatter);
        return;
    }
    // Columns before or beyond the seam, rows before or beyond it.
    let columns = vec4<i32>(listed.tiles.first.x, listed.tiles.last.x, listed.beyond.first.x, listed.beyond.last.x);
    let rows = vec4<i32>(listed.tiles.first.y, listed.tiles.last.y, listed.beyond.first.y, listed.beyond.last.y);
    for (var part = 0u; part < 4u; part++) {
        let of_columns = select(columns.xy, columns.zw, (part & 1u) != 0u);
        let of_rows = select(rows.xy, rows.zw, (part & 2u) != 0u);
        listed.tiles = Rect(vec2<i32>(of_columns.x, of_rows.x), vec2<i32>(of_columns.y, of_rows.y));
        list_part(face, id, listed, is_scatter);
    }
}

fn list_part(face: u32, id: u32, listed: Listed, is_scatter: bool) {
    let count = tile_count(listed.tiles);
    if count == 0u {
        return;
    }
    if count > MOST_CELLS_AT_ONCE || !listed.is_simple {
        if !is_scatter {
            split(face, id, listed, count);
        }
        return;
    }
    for (var y = listed.tiles.first.y; y <= listed.tiles.last.y; y++) {
        for (var x = listed.tiles.first.x; x <= listed.tiles.last.x; x++) {
            let cell = index_of_cell(face, vec2<i32>(x, y), listed.slice);
            if is_wanted(face, cell, listed.nearest) {
                take(cell, id, is_scatter);
            }
        }
    }
}

// Leaves a triangle to `list_large`, in chunks.
fn split(face: u32, id: u32, listed: Listed, count: u32) {
    let chunks = (count + CHUNK - 1u) / CHUNK;
    let first = atomicAdd(&header[HEADER_LARGE], chunks);
    for (var chunk = 0u; chunk < chunks; chunk++) {
        let base = (first + chunk) * LARGE_WORDS;
        if base + LARGE_WORDS > arrayLength(&large) {
            return;
        }
        atomicStore(&large[base], id);
        atomicStore(&large[base + 1u], face);
        atomicStore(&large[base + 2u], (u32(listed.tiles.first.y) << 16u) | u32(listed.tiles.first.x));
        atomicStore(&large[base + 3u], (u32(listed.tiles.last.y) << 16u) | u32(listed.tiles.last.x));
        atomicStore(&large[base + 4u], listed.slice);
        atomicStore(&large[base + 5u], chunk);
        atomicStore(&large[base + 6u], listed.nearest);
        for (var word = 0u; word < CHUNK / 32u; word++) {
            atomicStore(&large[base + LARGE_BITS + word], 0u);
        }
    }
}

fn list_large(entry: u32, lane: u32, is_scatter: bool) {
    let base = entry * LARGE_WORDS;
    if entry >= atomicLoad(&header[HEADER_LARGE]) || base + LARGE_WORDS > arrayLength(&large) {
        return;
    }
    let id = atomicLoad(&large[base]);
    let face = atomicLoad(&large[base + 1u]);
    let first = (vec2<u32>(atomicLoad(&large[base + 2u])) >> vec2<u32>(0u, 16u)) & vec2<u32>(0xffffu);
    let last = (vec2<u32>(atomicLoad(&large[base + 3u])) >> vec2<u32>(0u, 16u)) & vec2<u32>(0xffffu);
    let slice = atomicLoad(&large[base + 4u]);
    let chunk = atomicLoad(&large[base + 5u]);
    let nearest = atomicLoad(&large[base + 6u]);
    let columns = last.x - first.x + 1u;
    let count = columns * (last.y - first.y + 1u);
    for (var index = lane; index < CHUNK; index += 64u) {
        let number = chunk * CHUNK + index;
        if number >= count {
            return;
        }
        let tile = vec2<i32>(first + vec2<u32>(number % columns, number / columns));
        let cell = index_of_cell(face, tile, slice);
        let word = base + LARGE_BITS + index / 32u;
        let bit = 1u << (index & 31u);
        if is_scatter {
            if (atomicLoad(&large[word]) & bit) != 0u {
                take(cell, id, true);
            }
        } else if is_wanted(face, cell, nearest) && reaches(face, id, tile) {
            atomicOr(&large[word], bit);
            take(cell, id, false);
        }
    }
}

// Whether a triangle may touch a tile.
fn reaches(face: u32, id: u32, tile: vec2<i32>) -> bool {
    if HAS_ANGLES {
        return true;
    }
    let raster = spaces[face].raster;
    let base = face * list_size.vertices;
    let triangle = triangles[id].xyz;
    let corners = corners_of(vertices[base + triangle.x], vertices[base + triangle.y], vertices[base + triangle.z]);
    let pixels = pixels_of(face, tile);
    // Relative to the tile's middle, which may be between two pixels.
    let size = pixels.zw - pixels.xy;
    let origin = (pixels.xy << vec2<u32>(raster.fraction_bits)) + size * (1 << (raster.fraction_bits - 1u));
    let half = 0.5 * vec2<f32>(size) + 0.01;
    return !misses_box(edges_near(corners, origin, max(half.x, half.y), raster), half);
}

@compute @workgroup_size(256)
fn count_small(at: Invocation) {
    let id = flat_index(at, 256u);
    if id < list_size.triangles {
        list_small(at.group.z, id, false);
    }
}

@compute @workgroup_size(64)
fn count_large(at: Invocation) {
    list_large(flat_group(at.group), at.lane, false);
}

@compute @workgroup_size(256)
fn scatter_small(at: Invocation) {
    let id = flat_index(at, 256u);
    if id < list_size.triangles {
        list_small(at.group.z, id, true);
    }
}

@compute @workgroup_size(64)
fn scatter_large(at: Invocation) {
    list_large(flat_group(at.group), at.lane, true);
}

// Writes the size of the dispatch that takes the chunks.
@compute @workgroup_size(1)
fn size_large() {
    let groups = groups_of(min(atomicLoad(&header[HEADER_LARGE]), arrayLength(&large) / LARGE_WORDS));
    atomicStore(&header[HEADER_LARGE_GROUPS], groups.x);
    atomicStore(&header[HEADER_LARGE_GROUPS + 1u], groups.y);
    atomicStore(&header[HEADER_LARGE_GROUPS + 2u], groups.z);
}
