//! The list of figures.

use super::{Figure, cost, input, outside, pairs, rays, repeat, surfaces, unsafe_code};

/// Figures that measure an amount, which means nothing for few and small scenes, and those of another program, which
/// isn't built with this one's tests and has its own.
#[cfg(test)]
pub(super) const NOT_TESTED: [usize; 5] = [12, 14, 15, 21, 22];

pub(super) const FIGURES: &[Figure] = &[
    Figure {
        title: "Random rays inside closed surfaces",
        elsewhere: "Embree's own test (`verify`, `WatertightTest`) passes where at most 2e-5 of the rays are lost.",
        find: rays::random,
    },
    Figure {
        title: "Rays exactly at seams",
        elsewhere: "Woop, Benthin and Wald, *Watertight Ray/Triangle Intersection* (JCGT 2013), compute an f32 edge \
                    function that is zero again in f64, and so lose none at shared edges and vertices; the test of \
                    Möller and Trumbore (1997), the most common one, promises nothing there.",
        find: rays::seams,
    },
    Figure {
        title: "Fans and lattices",
        elsewhere: "Vulkan's specification says that implementations *should* neither miss nor hit twice where a \
                    ray meets a shared edge or the shared vertex of a closed fan; its conformance tests \
                    (`watertightness`) try that.",
        find: rays::fans,
    },
    Figure {
        title: "Mixed windings",
        elsewhere: "the bodies in the tests of Embree and pbrt are wound one way.",
        find: rays::windings,
    },
    Figure {
        title: "A ball of random radii",
        elsewhere: "pbrt's unit test `Triangle.Watertight` is of this kind: 200 000 rays at such a ball, none of which may \
                    miss.",
        find: rays::rough_ball,
    },
    Figure {
        title: "Leaving two million hit points",
        elsewhere: "pbrt bounds each hit point's rounding error and moves rays out of that box along the normal; its tests \
                    ask that none meets its own triangle again. OptiX's examples use a fixed `scene_epsilon` of \
                    1e-4, in the scene's own units.",
        find: rays::leaving,
    },
    Figure {
        title: "Layers behind one another",
        elsewhere: "trimesh's ray module goes on from each hit at a distance of 1e-4 of the scene's size \
                    (`_ray_offset_factor`): what is nearer behind is not found.",
        find: surfaces::layers,
    },
    Figure {
        title: "Shells 4e-5 apart",
        elsewhere: "a shadow ray that stops 1e-4 of its length before its end (`ShadowEpsilon` of pbrt, third edition) passes \
                    such a shell, and so does every shadow map.",
        find: surfaces::shells,
    },
    Figure {
        title: "Triangles of 1e-6 from 1e6 away",
        elsewhere: "rays of f32 can't be aimed so: neighbouring f32 numbers near 1e6 are 0.06 apart.",
        find: surfaces::far_and_tiny,
    },
    Figure {
        title: "Holes in closed bodies",
        elsewhere: "a rasteriser's fill rule leaves none, seen from one camera in fixed point; where a ray tracer's \
                    test isn't watertight, single pixels show what is behind.",
        find: surfaces::closed,
    },
    Figure {
        title: "Rays along axes, in planes of triangles",
        elsewhere: "slab tests that compute 0 · ∞ lose boxes here: see Ize, *Robust BVH Ray Traversal* (JCGT 2013).",
        find: surfaces::in_planes,
    },
    Figure {
        title: "Rays that are NaN or infinite",
        elsewhere: "Embree's tests (`NaNTest`, `InfTest`) allow 2.5 times the time of ordinary rays.",
        find: surfaces::unsound,
    },
    Figure {
        title: "Garbage",
        elsewhere: "Vulkan calls triangles inactive whose first coordinates are NaN; what other NaN do is \
                    undefined. Embree's tests ask that nothing crashes.",
        find: input::garbage,
    },
    Figure {
        title: "Identical triangles",
        elsewhere: "hierarchies split such lists in the middle, and a ray that meets one tests all of them.",
        find: input::identical,
    },
    Figure {
        title: "Bytes a triangle",
        elsewhere: "Embree's tests (`MemoryConsumptionTest`) bound what a build may take; its scenes have a flag, \
                    `compact`, for those who need less.",
        find: cost::bytes,
    },
    Figure {
        title: "Allocations in a steady frame",
        elsewhere: "not published, as far as we know.",
        find: cost::allocations,
    },
    Figure {
        title: "Sixteen kinds of change against new structures",
        elsewhere: "Embree's tests (`UpdateTest`) move spheres and ask whether rays still hit them.",
        find: repeat::updates,
    },
    Figure { title: "A long run", elsewhere: "not published, as far as we know.", find: cost::soak },
    Figure {
        title: "One picture, whatever computes it",
        elsewhere: "as far as we know nobody promises equal bits between instruction sets or GPUs.",
        find: repeat::hashes,
    },
    Figure {
        title: "Structures against the referee",
        elsewhere: "not published, as far as we know: others compare structures with one another, or with their own test of \
                    a ray and a triangle.",
        find: repeat::referee,
    },
    Figure {
        title: "Damaged files",
        elsewhere: "the readers that others maintain are fuzzed with libFuzzer or AFL, some of them for years on OSS-Fuzz \
                    (assimp, for one); their findings are public.",
        find: input::files,
    },
    Figure {
        title: "Command lines, options, frames and settings",
        elsewhere: "not published, as far as we know.",
        find: input::command_lines,
    },
    Figure {
        title: "Kept renderers against the referee",
        elsewhere: "not published, as far as we know.",
        find: repeat::kept_renderers,
    },
    Figure { title: "Pairs of options", elsewhere: "not published, as far as we know.", find: pairs::of_options },
    Figure {
        title: "Names and symbolic links that lead out of a folder",
        elsewhere: "glTF allows relative and absolute addresses and leaves safety to readers; OBJ has no rule.",
        find: outside::names,
    },
    Figure {
        title: "Unsafe code in the libraries below",
        elsewhere: "`cargo geiger` counts likewise; C and C++ don't mark such code.",
        find: unsafe_code::below,
    },
];
