use serde::Serialize;

/// What a frame cost. Times are in milliseconds of wall time.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Stats {
    /// Each stage's name and time, in the order in which they ran.
    pub stages: Vec<Stage>,
    /// Triangles of the frame, counting those left out.
    pub triangles: usize,
    /// Vertices of the frame.
    pub vertices: usize,
    /// Lights of the frame.
    pub lights: usize,
    /// Camera rays traced.
    pub camera_rays: u64,
    /// Shadow rays traced.
    pub shadow_rays: u64,
    /// Bytes held by the acceleration structure.
    pub structure_bytes: usize,
    /// Bytes held by the frame's vertices, triangles and textures.
    pub frame_bytes: usize,
    /// Bytes held by buffers for each pixel.
    pub film_bytes: usize,
    /// Triangles that no ray can hit, by reason.
    pub omitted: Vec<OmittedTriangles>,
}

/// One stage of a frame.
#[derive(Clone, Debug, Serialize)]
pub struct Stage {
    /// The stage's one name.
    pub name: &'static str,
    /// Its wall time.
    pub milliseconds: f64,
}

/// Triangles left out for one reason.
#[derive(Clone, Debug, Serialize)]
pub struct OmittedTriangles {
    /// Why, in words.
    pub reason: &'static str,
    /// How many.
    pub count: u32,
    /// The first of their ids.
    pub first_ids: Vec<u32>,
}
