// Stage `pose`: computes each vertex of a rig in a pose.
//
// Visibility depends on positions, so they have the bits of the CPU's f32. Only colours depend on normals and tangents,
// so these are plain f32.

import package::dispatch::{Invocation, flat_index};
import package::exact::single::{F32_ONE, F32_SIGN, f32_add, f32_multiply};

struct PoseSize {
    // Vertices to pose: all of them, or those of moving parts, which come first.
    vertices: u32,
    parts: u32,
    // First word of the matrices in `pose_motion`, behind the weights.
    matrix_word: u32,
    // First words of normals and tangents in `pose_attributes`; NO_ATTRIBUTE if the scene has none.
    normal_word: u32,
    tangent_word: u32,
}

// A copy of a shape.
struct PosePart {
    first_posed: u32,
    first_vertex: u32,
    shape: u32,
    first_weight: u32,
    // Index of its matrix, or of joint 0's.
    matrix: u32,
    is_skinned: u32,
}

// First words of a shape's vertices in `pose_vertices`; NO_ATTRIBUTE for normals and tangents that it doesn't have.
struct PoseShape {
    position_word: u32,
    normal_word: u32,
    tangent_word: u32,
    // First word of the first set; the next set is `influence_words` words further on.
    influence_word: u32,
    influence_words: u32,
    influence_sets: u32,
    // First word of its morph targets in `pose_deltas`: for each target the deltas of positions, of normals and of tangents.
    target_word: u32,
    targets: u32,
}

const NO_ATTRIBUTE = 0xffffffffu;
// The number of deltas if every vertex has one.
const DENSE_DELTAS = 0xffffffffu;
// The differences' first word and number for positions, normals and tangents.
const TARGET_WORDS = 6u;
const NORMAL_DELTAS = 2u;
const TANGENT_DELTAS = 4u;
const MATRIX_WORDS = 12u;
// Two words with the indices of four joints, then their weights.
const INFLUENCE_WORDS = 6u;

@group(0) @binding(0) var<uniform> pose_size: PoseSize;
@group(0) @binding(1) var<storage, read> pose_parts: array<PosePart>;
@group(0) @binding(2) var<storage, read> pose_shapes: array<PoseShape>;
@group(0) @binding(3) var<storage, read> pose_vertices: array<u32>;
@group(0) @binding(4) var<storage, read> pose_deltas: array<u32>;
@group(0) @binding(5) var<storage, read> pose_motion: array<u32>;
@group(0) @binding(6) var<storage, read_write> positions: array<u32>;
@group(0) @binding(7) var<storage, read_write> pose_attributes: array<u32>;

// Columns of the bits of f32: three axes, then a translation.
struct PoseMatrix {
    columns: array<vec3<u32>, 4>,
}

// Delta of a vertex in a morph target; zero if it has none.
struct PoseDelta {
    is_there: bool,
    bits: vec3<u32>,
}

// Transform of normals for vertices that a matrix transforms.
struct NormalTransform {
    // The inverse transpose times the determinant's absolute value, which exists for flattening matrices too.
    matrix: mat3x3<f32>,
    // −1 for a mirroring matrix, else 1.
    side: f32,
}

@compute @workgroup_size(64)
fn pose(at: Invocation) {
    let index = flat_index(at, 64u);
    if index >= pose_size.vertices {
        return;
    }
    let part = pose_parts[part_of(index)];
    let shape = pose_shapes[part.shape];
    let vertex_in_shape = index - part.first_posed;
    let vertex = part.first_vertex + vertex_in_shape;

    var position = three_words_of_vertices(shape.position_word + 3u * vertex_in_shape);
    for (var target_index = 0u; target_index < shape.targets; target_index++) {
        let weight = pose_motion[part.first_weight + target_index];
        if (weight & ~F32_SIGN) != 0u {
            let delta = delta_of(shape.target_word + target_index * TARGET_WORDS, vertex_in_shape);
            if delta.is_there {
                position = add_scaled(position, delta.bits, weight);
            }
        }
    }
    let matrix = matrix_of(part, shape, vertex_in_shape);
    let posed = transformed_point(matrix, position);
    positions[3u * vertex] = posed.x;
    positions[3u * vertex + 1u] = posed.y;
    positions[3u * vertex + 2u] = posed.z;

    if pose_size.normal_word != NO_ATTRIBUTE {
        pose_normal_and_tangent(part, shape, vertex_in_shape, vertex, matrix);
    }
}

// The last part that starts at a vertex or before it.
fn part_of(index: u32) -> u32 {
    var first = 0u;
    var end = pose_size.parts;
    while end - first > 1u {
        let middle = (first + end) / 2u;
        let is_before = pose_parts[middle].first_posed <= index;
        first = select(first, middle, is_before);
        end = select(middle, end, is_before);
    }
    return first;
}

// A point transformed as on the CPU: axis by axis, then the translation.
fn transformed_point(matrix: PoseMatrix, point: vec3<u32>) -> vec3<u32> {
    // Adding negative zero changes no number.
    var sum = vec3<u32>(F32_SIGN);
    var columns = matrix.columns;
    var factors = vec4<u32>(point, F32_ONE);
    for (var column = 0u; column < 4u; column++) {
        sum = add_scaled(sum, columns[column], factors.x);
        factors = factors.yzwx;
    }
    return sum;
}

fn matrix_of(part: PosePart, shape: PoseShape, vertex_in_shape: u32) -> PoseMatrix {
    if part.is_skinned == 0u {
        return matrix_at(part.matrix);
    }
    // Sums start at +0, as on the CPU.
    var sum: PoseMatrix;
    for (var set_index = 0u; set_index < shape.influence_sets; set_index++) {
        let word = shape.influence_word + set_index * shape.influence_words + vertex_in_shape * INFLUENCE_WORDS;
        for (var influence = 0u; influence < 4u; influence++) {
            let joint = (pose_vertices[word + influence / 2u] >> (16u * (influence & 1u))) & 0xffffu;
            let weight = pose_vertices[word + 2u + influence];
            let matrix = matrix_at(part.matrix + joint);
            // Adding zeros doesn't change a sum that starts at +0.
            if (weight & ~F32_SIGN) != 0u || !is_finite(matrix) {
                sum = add_scaled_matrix(sum, matrix, weight);
            }
        }
    }
    return sum;
}

fn matrix_at(index: u32) -> PoseMatrix {
    let word = pose_size.matrix_word + index * MATRIX_WORDS;
    return PoseMatrix(array<vec3<u32>, 4>(
        three_words_of_motion(word),
        three_words_of_motion(word + 3u),
        three_words_of_motion(word + 6u),
        three_words_of_motion(word + 9u),
    ));
}

fn is_finite(matrix: PoseMatrix) -> bool {
    let exponents = vec3<u32>(0x7f800000u);
    let columns = matrix.columns;
    return all((columns[0] & exponents) != exponents) && all((columns[1] & exponents) != exponents)
        && all((columns[2] & exponents) != exponents) && all((columns[3] & exponents) != exponents);
}

fn add_scaled_matrix(sum: PoseMatrix, matrix: PoseMatrix, factor: u32) -> PoseMatrix {
    var result: PoseMatrix;
    var sums = sum.columns;
    var columns = matrix.columns;
    for (var column = 0u; column < 4u; column++) {
        result.columns[column] = add_scaled(sums[column], columns[column], factor);
    }
    return result;
}

// sum + vector · factor, each operation rounded.
fn add_scaled(sum: vec3<u32>, vector: vec3<u32>, factor: u32) -> vec3<u32> {
    var result = sum;
    var turned = vector;
    for (var axis = 0u; axis < 3u; axis++) {
        result = vec3<u32>(result.yz, f32_add(result.x, f32_multiply(turned.x, factor)));
        turned = turned.yzx;
    }
    return result;
}

// Delta of a vertex, from the list of deltas at `record` in `pose_deltas`.
fn delta_of(record: u32, vertex_in_shape: u32) -> PoseDelta {
    let first = pose_deltas[record];
    let count = pose_deltas[record + 1u];
    if count == DENSE_DELTAS {
        return PoseDelta(true, three_words_of_deltas(first + 3u * vertex_in_shape));
    }
    // Ascending vertex numbers, then their deltas.
    var found = 0u;
    var end = count;
    while found < end {
        let middle = (found + end) / 2u;
        let is_before = pose_deltas[first + middle] < vertex_in_shape;
        found = select(found, middle + 1u, is_before);
        end = select(middle, end, is_before);
    }
    if found == count || pose_deltas[first + found] != vertex_in_shape {
        return PoseDelta(false, vec3<u32>(0u));
    }
    return PoseDelta(true, three_words_of_deltas(first + count + 3u * found));
}

fn pose_normal_and_tangent(part: PosePart, shape: PoseShape, vertex_in_shape: u32, vertex: u32, matrix: PoseMatrix) {
    let axes = mat3x3<f32>(
        bitcast<vec3<f32>>(matrix.columns[0]),
        bitcast<vec3<f32>>(matrix.columns[1]),
        bitcast<vec3<f32>>(matrix.columns[2]),
    );
    let normals = normal_transform(axes);
    var normal = vec3<f32>(0.0);
    if shape.normal_word != NO_ATTRIBUTE {
        let bind = bitcast<vec3<f32>>(three_words_of_vertices(shape.normal_word + 3u * vertex_in_shape));
        normal = unit_or_zero(normals.matrix * (bind + morphed(part, shape, vertex_in_shape, NORMAL_DELTAS)));
    }
    write_three(pose_size.normal_word + 3u * vertex, normal);

    if pose_size.tangent_word == NO_ATTRIBUTE {
        return;
    }
    var tangent = vec3<f32>(0.0);
    var sign = 0.0;
    if shape.tangent_word != NO_ATTRIBUTE {
        let word = shape.tangent_word + 4u * vertex_in_shape;
        let bind = bitcast<vec3<f32>>(three_words_of_vertices(word));
        tangent = unit_or_zero(axes * (bind + morphed(part, shape, vertex_in_shape, TANGENT_DELTAS)));
        // The bitangent is made from the world's normal and tangent, whose cross product a mirror reverses.
        sign = bitcast<f32>(pose_vertices[word + 3u]) * normals.side;
    }
    let word = pose_size.tangent_word + 4u * vertex;
    write_three(word, tangent);
    pose_attributes[word + 3u] = bitcast<u32>(select(sign, 0.0, all(tangent == vec3<f32>(0.0))));
}

// Weighted sum of all morph targets' deltas to a vertex's normal or tangent.
fn morphed(part: PosePart, shape: PoseShape, vertex_in_shape: u32, first_word: u32) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    for (var target_index = 0u; target_index < shape.targets; target_index++) {
        let weight = bitcast<f32>(pose_motion[part.first_weight + target_index]);
        if weight != 0.0 {
            let record = shape.target_word + target_index * TARGET_WORDS + first_word;
            sum += bitcast<vec3<f32>>(delta_of(record, vertex_in_shape).bits) * weight;
        }
    }
    return sum;
}

fn normal_transform(matrix: mat3x3<f32>) -> NormalTransform {
    // Products of very small or large scales would leave the range of f32.
    let largest = max(largest_magnitude(matrix[0]), max(largest_magnitude(matrix[1]), largest_magnitude(matrix[2])));
    let scale = select(1.0, 1.0 / largest, largest > 0.0);
    let x = matrix[0] * scale;
    let y = matrix[1] * scale;
    let z = matrix[2] * scale;
    let x_normal = cross(y, z);
    let side = select(1.0, -1.0, dot(x, x_normal) < 0.0);
    return NormalTransform(mat3x3<f32>(x_normal * side, cross(z, x) * side, cross(x, y) * side), side);
}

fn unit_or_zero(vector: vec3<f32>) -> vec3<f32> {
    let largest = largest_magnitude(vector);
    if !(largest > 0.0) {
        return vec3<f32>(0.0);
    }
    // Scaled to a largest component of one, so that no square leaves the range of f32.
    return normalize(vector / largest);
}

fn largest_magnitude(vector: vec3<f32>) -> f32 {
    let magnitude = abs(vector);
    return max(magnitude.x, max(magnitude.y, magnitude.z));
}

fn write_three(word: u32, vector: vec3<f32>) {
    let bits = bitcast<vec3<u32>>(vector);
    pose_attributes[word] = bits.x;
    pose_attributes[word + 1u] = bits.y;
    pose_attributes[word + 2u] = bits.z;
}

fn three_words_of_vertices(word: u32) -> vec3<u32> {
    return vec3<u32>(pose_vertices[word], pose_vertices[word + 1u], pose_vertices[word + 2u]);
}

fn three_words_of_deltas(word: u32) -> vec3<u32> {
    return vec3<u32>(pose_deltas[word], pose_deltas[word + 1u], pose_deltas[word + 2u]);
}

fn three_words_of_motion(word: u32) -> vec3<u32> {
    return vec3<u32>(pose_motion[word], pose_motion[word + 1u], pose_motion[word + 2u]);
}
