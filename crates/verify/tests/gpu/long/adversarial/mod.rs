//! Input that breaks ray tracers, through the GPU's grids: triangles and shadows are the truth's in every pixel.

mod angles;
mod crowds;
mod grids;
mod lights;
mod seams;
mod shapes;
mod sides;
