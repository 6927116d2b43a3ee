use glam::Vec3;

use super::*;
use crate::Bounds;
use crate::random::Random;
use crate::simd::lanes::LANES;

/// Vertices and triangles of a mesh.
type Mesh = (Vec<Vec3>, Vec<[u32; 3]>);

fn triangles((positions, indices): &Mesh) -> Triangles<'_> {
    Triangles { positions, indices }
}

/// A wavy sheet of `side`² quads of two triangles.
fn sheet(side: u32) -> Mesh {
    let at = |row: u32, column: u32| Vec3::new(column as f32, row as f32, (row as f32 * 0.1).sin());
    let positions = (0..=side).flat_map(|row| (0..=side).map(move |column| at(row, column))).collect();
    let quads = (0..side).flat_map(|row| (0..side).map(move |column| row * (side + 1) + column));
    let indices = quads.flat_map(|first| {
        let [a, b, c, d] = [first, first + 1, first + side + 1, first + side + 2];
        [[a, b, c], [c, b, d]]
    });
    (positions, indices.collect())
}

/// The same mesh, with separate vertices for each triangle.
fn flat_shaded((positions, indices): &Mesh) -> Mesh {
    let own = indices.iter().flatten().map(|&vertex| positions[vertex as usize]).collect();
    (own, (0..indices.len() as u32).map(|id| [3 * id, 3 * id + 1, 3 * id + 2]).collect())
}

/// Pseudorandom numbers in [0, 1).
fn random() -> impl FnMut() -> f32 {
    let mut random = Random::new(1);
    move || random.unit() as f32
}

fn shards(count: u32) -> Mesh {
    let mut random = random();
    let mut point = |size: f32| Vec3::new(random(), random(), random()) * size;
    let middles = (0..count).map(|_| point(100.0)).collect::<Vec<_>>();
    let positions = middles.iter().flat_map(|&middle| [middle, middle + point(1.0), middle + point(1.0)]).collect();
    (positions, (0..count).map(|id| [3 * id, 3 * id + 1, 3 * id + 2]).collect())
}

fn fan(count: u32) -> Mesh {
    let rim =
        (0..=count).map(|index| Vec3::new((index as f32 * 0.01).cos(), (index as f32 * 0.01).sin(), index as f32));
    let indices = (1..=count).map(|index| [0, index, index + 1]).collect();
    (std::iter::once(Vec3::ZERO).chain(rim).collect(), indices)
}

/// Meshes that are hard to grow patches in.
fn adversarial() -> Vec<(&'static str, Mesh)> {
    let mut random = random();
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let book = (0..500).map(|page| Vec3::new((page as f32).cos(), (page as f32).sin(), 0.0));
    let (spoilt, spoilt_indices) = sheet(30);
    let mut spoil = |position: &Vec3| match random() {
        share if share < 0.05 => Vec3::new(f32::NAN, position.y, 0.0),
        share if share < 0.1 => Vec3::splat(f32::NEG_INFINITY),
        share if share < 0.15 => Vec3::splat(f32::MAX),
        _ => *position,
    };
    let missing = sheet(30).1.into_iter().enumerate();
    let missing = missing.map(|(id, [a, b, c])| if id % 7 == 0 { [a, 5_000_000, c] } else { [a, b, c] });
    vec![
        ("nothing", (Vec::new(), Vec::new())),
        ("no positions", (Vec::new(), vec![[0, 1, 2]; 3])),
        ("one triangle", (corners.to_vec(), vec![[0, 1, 2]])),
        ("duplicates", (corners.to_vec(), vec![[0, 1, 2]; 1000])),
        ("all windings", (corners.to_vec(), [[0, 1, 2], [2, 1, 0], [1, 2, 0]].repeat(100))),
        ("the same vertex twice", (corners.to_vec(), [[0, 0, 1], [1, 2, 1], [3, 3, 3], [0, 1, 1]].repeat(50))),
        ("all at one point", (vec![Vec3::ONE; 300], (0..100).map(|id| [3 * id, 3 * id + 1, 3 * id + 2]).collect())),
        (
            "pages of a book",
            ([Vec3::ZERO, Vec3::Z].into_iter().chain(book).collect(), (2..502).map(|page| [0, 1, page]).collect()),
        ),
        ("not finite", (spoilt.iter().map(&mut spoil).collect(), spoilt_indices)),
        ("nothing finite", (vec![Vec3::NAN; 3000], shards(1000).1)),
        ("vertices that don't exist", (sheet(30).0, missing.collect())),
        ("a fan", fan(1 << 18)),
        ("shards", shards(3000)),
        ("flat shading", flat_shaded(&sheet(60))),
    ]
}

fn grown(mesh: &Mesh) -> Patches {
    let mut patches = Patches::default();
    patches.grow(triangles(mesh));
    patches.bound(triangles(mesh), SimdLevel::default());
    patches
}

fn triangles_a_patch(patches: &Patches) -> f32 {
    patches.triangles as f32 / patches.len() as f32
}

/// The total area, seen from above, of the boxes around each `together` consecutive patches.
fn covered(patches: &Patches, mesh: &Mesh, together: usize) -> f32 {
    let numbers = (0..patches.len()).collect::<Vec<_>>();
    let sizes = numbers.chunks(together).map(|numbers| {
        let vertices = numbers.iter().flat_map(|&number| patches.get(number).vertices);
        let size = Bounds::of_points(vertices.map(|&vertex| mesh.0[vertex as usize])).size();
        size.x * size.y
    });
    sizes.sum()
}

#[test]
fn each_triangle_is_in_one_patch_whatever_comes() {
    for (name, mesh) in &adversarial() {
        let check =
            |patches: &Patches| patches.validate(triangles(mesh)).unwrap_or_else(|what| panic!("{name}: {what}"));
        check(&grown(mesh));
        let mut patches = Patches::default();
        patches.update(triangles(mesh), SimdLevel::default());
        check(&patches);
    }
}

#[test]
fn patches_of_sheets_are_full_round_and_near_the_next_ones() {
    let mesh = sheet(160);
    let patches = grown(&mesh);
    assert!(triangles_a_patch(&patches) > 58.0, "{} triangles a patch", triangles_a_patch(&patches));
    let area = 160.0 * 160.0;
    let (each, sixteen) = (covered(&patches, &mesh, 1), covered(&patches, &mesh, LANES));
    assert!(each < 1.9 * area, "boxes of {} times the sheet", each / area);
    assert!(sixteen < 1.7 * area, "boxes of sixteen of {} times the sheet", sixteen / area);
    // Holds for any order of triangles.
    let (positions, mut indices) = mesh;
    let mut random = random();
    indices.sort_by_cached_key(|_| random().to_bits());
    let shuffled = (positions, indices);
    let patches = grown(&shuffled);
    assert!(triangles_a_patch(&patches) > 58.0, "{} triangles a patch, shuffled", triangles_a_patch(&patches));
    assert!(covered(&patches, &shuffled, 1) < 1.9 * area);
}

#[test]
fn what_is_not_connected_is_gathered() {
    // Three vertices a triangle, and room for 64.
    for mesh in [shards(20_000), flat_shaded(&sheet(100)), (vec![Vec3::NAN; 9000], shards(3000).1)] {
        let patches = grown(&mesh);
        assert!(triangles_a_patch(&patches) > 16.0, "{} triangles a patch", triangles_a_patch(&patches));
    }
}

fn grouped(mesh: &Mesh) -> Patches {
    let mut patches = Patches::default();
    patches.update(triangles(mesh), SimdLevel::default());
    patches.validate(triangles(mesh)).expect("valid");
    assert!(!patches.are_grown);
    patches
}

#[test]
fn groups_are_near_each_other_whatever_order_triangles_come_in() {
    let mut random = random();
    let (positions, mut indices) = sheet(160);
    indices.sort_by_cached_key(|_| random().to_bits());
    let mesh = (positions, indices);
    let groups = grouped(&mesh);
    assert!(triangles_a_patch(&groups) > 45.0, "{} triangles a patch", triangles_a_patch(&groups));
    let (groups, grown) = (covered(&groups, &mesh, 1), covered(&grown(&mesh), &mesh, 1));
    assert!(groups < 2.0 * grown, "boxes of {groups}, and of {grown} when grown");
    let mesh = shards(20_000);
    let (groups, grown) = (covered(&grouped(&mesh), &mesh, 1), covered(&self::grown(&mesh), &mesh, 1));
    assert!(groups < 1.7 * grown, "boxes of {groups}, and of {grown} when grown");
}

#[test]
fn outliers_do_not_spoil_the_groups_of_others() {
    let (mut positions, mut indices) = shards(20_000);
    let near = covered(&grouped(&(positions.clone(), indices.clone())), &(positions.clone(), indices.clone()), 1);
    let far = [Vec3::splat(f32::MAX), Vec3::splat(-1e30), Vec3::NAN, Vec3::splat(f32::INFINITY), Vec3::X * 1e9];
    for (id, corner) in far.iter().cycle().take(200).enumerate() {
        indices.insert(id * 97, [positions.len() as u32; 3]);
        positions.push(*corner);
    }
    let mesh = (positions, indices);
    let patches = grouped(&mesh);
    let areas = (0..patches.len()).map(|number| {
        let vertices = patches.get(number).vertices.iter();
        let size = Bounds::of_points(vertices.map(|&vertex| mesh.0[vertex as usize])).size();
        size.x * size.y
    });
    // Patches with an outlier have no useful bounds.
    let of_others = areas.filter(|area| *area < 1e6).sum::<f32>();
    assert!(of_others < 1.2 * near, "boxes of {of_others}, and of {near} without outliers");
}

#[test]
fn loose_triangles_are_grouped_anew_when_they_have_gone_apart() {
    let level = SimdLevel::default();
    let (positions, indices) = shards(20_000);
    let mut random = random();
    // Skips the numbers that placed the shards: as speeds they would only scale the scene.
    (0..9 * indices.len()).for_each(|_| _ = random());
    let speeds = indices.iter().map(|_| Vec3::new(random(), random(), random()) - 0.5).collect::<Vec<_>>();
    let at = |time: f32| {
        let moved = positions.iter().zip(speeds.iter().flat_map(|speed| [speed; 3]));
        (moved.map(|(&position, &speed)| position + time * speed).collect(), indices.clone())
    };
    let mut patches = Patches::default();
    let mut ids = |mesh: &Mesh| {
        patches.update(triangles(mesh), level);
        patches.validate(triangles(mesh)).expect("valid");
        patches.ids.clone()
    };
    let first = ids(&at(0.0));
    assert_eq!(ids(&at(0.1)), first);
    // Larger and moved as a whole, they need no new groups.
    let elsewhere =
        |(positions, indices): Mesh| (positions.iter().map(|&position| 8.0 * position + Vec3::X).collect(), indices);
    assert_eq!(ids(&elsewhere(at(0.1))), first);
    let later = ids(&at(20.0));
    assert_ne!(later, first);
    assert_eq!(later, grouped(&at(20.0)).ids);
    assert_eq!(ids(&at(20.1)), later);
}

#[test]
fn any_number_of_threads_makes_the_same() {
    for (mesh, make) in
        [(sheet(150), grown as fn(&Mesh) -> Patches), (shards(40_000), grown), (shards(100_000), grouped)]
    {
        let [one, two, three] = [1, 2, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| make(&mesh))
        });
        for other in [two, three] {
            assert_eq!(one.ids, other.ids);
            assert_eq!(one.vertices, other.vertices);
            assert_eq!(one.corners, other.corners);
        }
    }
}

#[test]
fn patches_grow_once_and_stay_while_the_index_buffer_does() {
    let level = SimdLevel::default();
    let (first, second) = (sheet(40), sheet(41));
    let mut patches = Patches::default();
    let mut update = |mesh: &Mesh| {
        patches.update(triangles(mesh), level);
        patches.validate(triangles(mesh)).expect("valid");
        patches.ids.clone()
    };
    let groups = update(&first);
    let grown = update(&first);
    assert_ne!(groups, grown);
    let moved =
        (first.0.iter().map(|position| Vec3::new(position.y, position.z, 3.0 * position.x)).collect(), first.1.clone());
    assert_eq!(update(&moved), grown);
    // Alternating between two buffers leaves no time to grow.
    update(&second);
    assert_eq!(update(&first), groups);
    update(&second);
    assert_eq!(update(&first), groups);
    assert_eq!(update(&first), grown);
    // A change of any single index, of a few triangles.
    for (id, corner) in [(0, 0), (1234, 1), (3199, 2)] {
        let mut changed = first.clone();
        changed.1[id][corner] ^= 1;
        assert_eq!(update(&first), update(&first), "grown");
        update(&changed);
        update(&first);
    }
}

#[test]
fn a_steady_frame_allocates_nothing() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    pool.install(|| {
        let mut mesh = sheet(60);
        let mut patches = Patches::default();
        let mut allocated = [0; 4].map(|_| {
            let before = allocations::on_this_thread();
            patches.update(triangles(&mesh), SimdLevel::default());
            allocations::on_this_thread() - before
        });
        allocated[..2].sort_unstable();
        assert!(allocated[0] > 0 && allocated[2..] == [0, 0], "{allocated:?}");
        // Grouping a buffer that changes every frame doesn't allocate either.
        let allocated = [0; 4].map(|_| {
            let before = allocations::on_this_thread();
            mesh.1.swap(0, 1);
            patches.update(triangles(&mesh), SimdLevel::default());
            allocations::on_this_thread() - before
        });
        assert!(!patches.are_grown && allocated[0] > 0 && allocated[2..] == [0, 0], "{allocated:?}");
    });
}

#[test]
fn positions_may_vanish_and_come_back() {
    let level = SimdLevel::default();
    let mesh = sheet(40);
    let fewer = (mesh.0[..1000].to_vec(), mesh.1.clone());
    let mut patches = Patches::default();
    for mesh in [&mesh, &mesh, &fewer, &fewer, &fewer, &mesh, &mesh, &fewer] {
        patches.update(triangles(mesh), level);
        patches.validate(triangles(mesh)).expect("valid");
    }
    assert!(!patches.in_none.is_empty(), "triangles without corners");
}

#[test]
fn validation_notices_what_is_wrong() {
    let mesh = sheet(20);
    let patches = grown(&mesh);
    let errors: [fn(&mut Patches); 5] = [
        |patches: &mut Patches| patches.ids[3] = patches.ids[4],
        |patches: &mut Patches| patches.corners[3].swap(0, 1),
        |patches: &mut Patches| patches.starts[1].count -= 1,
        |patches: &mut Patches| patches.bounds.sixteens[0].low[1][2] += 1.0,
        |patches: &mut Patches| patches.in_none.push(7),
    ];
    for error in errors {
        let mut patches = grown(&mesh);
        error(&mut patches);
        assert!(patches.validate(triangles(&mesh)).is_err());
    }
    patches.validate(triangles(&mesh)).expect("valid");
}
