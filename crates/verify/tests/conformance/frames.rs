//! Properties of whole frames: the same bits everywhere, and no new memory when nothing changes.

use glam::Vec3;
use umbrage_rays::{Counts, LightMask, LightSource, SeenPixels, SimdLevel, Structure, Work};
use umbrage_verify::lights::{point, sun};
use umbrage_verify::views::{camera, view};
use umbrage_verify::{Case, Random, TestMesh};

use crate::check::is_same;
use umbrage_verify::structures::Make;

pub(crate) fn on_threads<T: Send>(count: usize, run: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("threads").install(run)
}

/// Triangles of all sizes, in more tiles than one.
fn crowd(soup: usize, rings: u32, width: u32, height: u32, lights: &[LightSource]) -> Case {
    let mut mesh = TestMesh::soup(&mut Random::new(10), soup, 0.01);
    mesh.append(&TestMesh::bumpy_ball(1.0, rings));
    mesh.append(&TestMesh::plane(2, 5.0).placed(1.0, Vec3::NEG_Y));
    // Many in one cell.
    mesh.append(&TestMesh::bumpy_ball(1e-3, 16).placed(1.0, Vec3::new(1.1, 0.2, 0.3)));
    mesh.positions[17].x = f32::NAN;
    Case::new("a crowd", mesh, view(camera(), width, height), lights)
}

/// A frame, and the camera's counts; the counts of shadows depend on which thread finds a first one.
fn frame(structure: &mut dyn Structure, case: &Case, seen: &mut SeenPixels, masks: &mut [LightMask]) -> Counts {
    let shot = case.shot();
    structure.build_parts(shot.triangles, case.parts());
    let Work { counts, .. } = structure.see(&shot, seen).expect("a small image");
    structure.shadow(&shot, seen, &case.lights, masks);
    counts
}

/// Each number of threads and each SIMD level gives the same bits, and the same work for the camera.
pub(crate) fn are_the_same_everywhere(make: Make) {
    let lights = [point(Vec3::new(2.0, 4.0, 1.0)), point(Vec3::new(0.3, 0.2, 1.3)), sun(0.2, -1.0, 0.1)];
    let case = crowd(1000, 24, 140, 70, &lights);
    let levels = SimdLevel::available();
    let mut forms: Vec<(usize, SimdLevel)> = levels.iter().map(|&level| (1, level)).collect();
    forms.extend([2, 3, 7].into_iter().enumerate().map(|(number, threads)| (threads, levels[number % levels.len()])));
    let mut reference: Option<(SeenPixels, Vec<LightMask>, Counts)> = None;
    for (threads, level) in forms {
        let (mut seen, mut masks) = (SeenPixels::default(), vec![LightMask::default(); lights.len()]);
        let counts = on_threads(threads, || frame(&mut *make(level), &case, &mut seen, &mut masks));
        let Some((first_seen, first_masks, first_counts)) = &reference else {
            assert!(masks.iter().all(|mask| mask.count() > 1000));
            reference = Some((seen, masks, counts));
            continue;
        };
        let form = format!("{threads} threads with {level}");
        assert!(is_same(&seen, first_seen), "{form}: other triangles or depths");
        assert!(masks == *first_masks, "{form}: other shadows");
        assert_eq!(counts, *first_counts, "{form}");
    }
}

/// The structures that are also rebuilt without new memory.
const REBUILT: [&str; 3] = ["direct", "listed", "uniform"];

/// After a frame has been seen and lit twice, the next allocates nothing.
pub(crate) fn allocate_nothing_when_steady(name: &str, make: Make) {
    let lights = [point(Vec3::new(2.0, 4.0, 1.0)), point(Vec3::new(0.3, 0.2, 1.3)), sun(0.2, -1.0, 0.1)];
    let case = crowd(300, 16, 100, 70, &lights);
    let shot = case.shot();
    let is_rebuilt = REBUILT.iter().any(|rebuilt| name.starts_with(rebuilt));
    // One thread does all the work, so that all allocations are counted.
    let counted = on_threads(1, || {
        let mut structure = make(SimdLevel::default());
        let (mut seen, mut masks) = (SeenPixels::default(), vec![LightMask::default(); lights.len()]);
        [0; 4].map(|taken| {
            let is_first = masks[0].count() == 0;
            let before = allocations::on_this_thread();
            if is_rebuilt || is_first {
                structure.build_parts(shot.triangles, case.parts());
            }
            structure.see(&shot, &mut seen).expect("a small image");
            structure.shadow(&shot, &seen, &lights, &mut masks);
            allocations::on_this_thread() - before + taken
        })
    });
    assert!(counted[0] > 0, "the first frame is counted: {counted:?}");
    // In the second frame patches of connected triangles are made.
    assert_eq!(counted[2..], [0, 0], "{counted:?}");
}

/// Validation fails when triangles have moved since the structure was built, if it keeps any data.
pub(crate) fn notice_moved_triangles(make: Make) {
    let mut case = crowd(50, 8, 40, 30, &[point(Vec3::new(2.0, 4.0, 1.0))]);
    let mut structure = make(SimdLevel::default());
    let (mut seen, mut masks) = (SeenPixels::default(), [LightMask::default()]);
    frame(&mut *structure, &case, &mut seen, &mut masks);
    assert_eq!(structure.validate(&case.shot(), &seen, &case.lights), Ok(()));
    if structure.bytes().triangles == 0 {
        return;
    }
    // Far from all cells that list them, and in front of the camera.
    case.mesh.positions.iter_mut().skip(20).step_by(40).for_each(|position| *position = Vec3::new(0.9, 1.2, 3.0));
    assert!(structure.validate(&case.shot(), &seen, &case.lights).is_err());
}
