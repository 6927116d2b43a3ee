// Stage `raster`: primary hits by rasterisation, nearest first by a depth test (Horn et al. 2007, §4). Vertices are
// pulled from the scene's own buffers, the only way for fragments to know their triangle on every device.

struct KdRaster {
    position: vec3<f32>,
    // Half the width of the view: a tangent, or for parallel rays a length.
    half_width: f32,
    right: vec3<f32>,
    half_height: f32,
    up: vec3<f32>,
    // Depth of the near plane.
    near: f32,
    forward: vec3<f32>,
    // Depth of the far plane for parallel rays; zero for others.
    far: f32,
}

@group(0) @binding(0) var<uniform> kd_raster: KdRaster;
@group(0) @binding(1) var<storage, read> triangles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> positions: array<u32>;

struct RasterVertex {
    @builtin(position) clip: vec4<f32>,
    // The triangle's index plus one.
    @location(0) @interpolate(flat, either) triangle: u32,
}

@vertex
fn raster_vertex(@builtin(vertex_index) index: u32) -> RasterVertex {
    let id = index / 3u;
    let corners = triangles[id].xyz;
    if any(corners >= vec3(arrayLength(&positions) / 3u)) {
        // A corner doesn't exist, so the triangle is dropped.
        return RasterVertex(vec4(0.0, 0.0, -1.0, 1.0), 0u);
    }
    let vertex = corners[index % 3u];
    let bits = vec3(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
    let offset = bitcast<vec3<f32>>(bits) - kd_raster.position;
    let x = dot(offset, kd_raster.right) / kd_raster.half_width;
    let y = dot(offset, kd_raster.up) / kd_raster.half_height;
    let depth = dot(offset, kd_raster.forward);
    var clip = vec4(x, y, kd_raster.near, depth);
    if kd_raster.far > 0.0 {
        clip = vec4(x, y, 1.0 - depth / kd_raster.far, 1.0);
    }
    return RasterVertex(clip, id + 1u);
}

@fragment
fn raster_fragment(@location(0) @interpolate(flat, either) triangle: u32) -> @location(0) u32 {
    return triangle;
}
