use std::f32::consts::TAU;

use glam::{Affine3A, Quat, Vec2, Vec3};

use super::architecture::{self, Opening, Vault, Wall};
use super::build::math::{mix, rotation, rotation_between, sin_cos, turned, wave};
use super::build::{Detail, MeshBuilder, Random, srgb};
use super::furniture::{self, CASE_LENGTH, SHELVES_IN_CASE};
use super::hall_paints as paints;
use super::{DemoScene, Moment, Pose, studio};

pub(crate) const SCENE: DemoScene = DemoScene {
    name: "hall",
    about: "the reading room of an old library, with vaults, books and swinging chandeliers",
    triangles: 284_000,
    seconds: 16.0,
    still_seconds: 3.0,
    open,
};

/// Length of a bay and number of bays; the hall goes from z = 0 towards −Z.
pub(super) const BAY: f32 = 5.0;
pub(super) const BAYS: u32 = 6;
/// Distances of the columns and the outer walls from the middle.
pub(super) const NAVE: f32 = 4.5;
pub(super) const AISLE: f32 = 8.7;
/// Heights at which the arches of the nave, and the vaults of the nave and the aisles, begin.
const ARCADE_SPRING: f32 = 3.4;
const NAVE_SPRING: f32 = 6.4;
const NAVE_RISE: f32 = 4.6;
const AISLE_ROOF: f32 = 6.1;
const CHANDELIER_DROP: f32 = 6.4;
const GLOBE: Vec3 = Vec3::new(-1.85, furniture::GLOBE_HEIGHT, -3.5);

fn open(triangles: usize) -> Pose {
    let detail = Detail::for_triangles(triangles, SCENE.triangles);
    let (mut builder, moving) = detail.within(
        triangles * 13 / 20,
        |detail| (still_parts(detail), moving_parts(detail)),
        |(still, moving)| still.triangles.len() + moving.iter().map(|part| part.triangles.len()).sum::<usize>(),
    );
    let taken = builder.triangles.len() + moving.iter().map(|part| part.triangles.len()).sum::<usize>();
    books(&mut builder, triangles.saturating_sub(taken));
    let [chandeliers @ .., globe] = moving.map(|part| {
        let first = builder.positions.len();
        builder.part().instance(&part, Affine3A::IDENTITY);
        first..builder.positions.len()
    });
    let still = builder.finish();

    Box::new(move |Moment { part, .. }, frame| {
        frame.copy_surfaces(&still);
        for (index, vertices) in chandeliers.iter().enumerate() {
            studio::turn(frame, vertices.clone(), hook(index), swing(index, part));
        }
        let axis = Vec3::new(0.39, 0.92, 0.0).normalize();
        studio::turn(frame, globe.clone(), GLOBE, rotation_between(Vec3::Y, axis) * turned(TAU * part));
        let eye = Vec3::new(1.35 + 0.35 * wave(part), 1.72 + 0.1 * wave(part + 0.25), -0.35);
        studio::look(frame, "reader", eye, Vec3::new(-0.35 + 0.25 * wave(part + 0.1), 3.0, -12.0), 0.56);
        let sun = Vec3::new(-0.5, -0.82 + 0.03 * wave(part), 0.2 + 0.1 * wave(part + 0.25));
        studio::sun(frame, sun, srgb(0xff_ee_d2), 4.0);
        for index in 0..2 {
            let flicker = 1.0 + 0.03 * wave(23.0 * part + 0.4 * index as f32);
            // Under the ring, whose shadow falls on the vault.
            let below = Vec3::NEG_Y * (CHANDELIER_DROP + 0.5);
            let position = hook(index) + swing(index, part) * below;
            studio::lamp(frame, "candles", position, srgb(0xff_c8_80), 20.0 * flicker, None);
        }
    })
}

/// Hook of chandelier `index`.
fn hook(index: usize) -> Vec3 {
    Vec3::new(0.0, NAVE_SPRING + NAVE_RISE - 0.2, -BAY * (1.5 + 1.5 * index as f32))
}

/// Rotation of chandelier `index` at `part` of the cycle.
fn swing(index: usize, part: f32) -> Quat {
    let phase = 0.31 * index as f32;
    rotation(Vec3::Z, 0.085 * wave(4.0 * part + phase)) * rotation(Vec3::X, 0.05 * wave(4.0 * part + phase + 0.19))
}

/// Everything that stands still, except the books.
fn still_parts(detail: Detail) -> MeshBuilder {
    let mut builder = MeshBuilder::new();
    shell(&mut builder, detail);
    let mut bay = MeshBuilder::new();
    one_bay(&mut bay, detail);
    for index in 0..BAYS {
        builder.instance(&bay, Affine3A::from_translation(Vec3::NEG_Z * (BAY * (index as f32 + 0.5))));
    }
    let mut column = MeshBuilder::new();
    architecture::column(&mut column, 0.42, ARCADE_SPRING, detail);
    for index in 0..=BAYS {
        for x in [-NAVE, NAVE] {
            builder.instance(&column, Affine3A::from_translation(Vec3::new(x, 0.0, -BAY * index as f32)));
        }
    }
    paints::lay_floors(&mut builder);
    dais(&mut builder, detail);
    furnish(&mut builder, detail);
    builder
}

/// The three chandeliers and the globe, each around the origin.
fn moving_parts(detail: Detail) -> [MeshBuilder; 4] {
    let mut chandelier = MeshBuilder::new();
    furniture::chandelier(&mut chandelier, CHANDELIER_DROP, detail);
    let mut globe = MeshBuilder::new();
    furniture::globe(&mut globe, detail);
    [chandelier.clone(), chandelier.clone(), chandelier, globe]
}

/// Outer walls at both ends, and the roofs that keep the sun out.
fn shell(builder: &mut MeshBuilder, detail: Detail) {
    let length = BAY * BAYS as f32;
    builder.paint(paints::ASHLAR);
    for [low, high] in [
        [Vec3::new(-AISLE - 0.5, AISLE_ROOF, -length - 0.5), Vec3::new(-NAVE, AISLE_ROOF + 0.2, 0.5)],
        [Vec3::new(NAVE, AISLE_ROOF, -length - 0.5), Vec3::new(AISLE + 0.5, AISLE_ROOF + 0.2, 0.5)],
        [Vec3::new(-NAVE - 0.4, 11.6, -length - 0.5), Vec3::new(NAVE + 0.4, 11.9, 0.5)],
        [Vec3::new(-AISLE - 0.5, 0.0, 0.5), Vec3::new(AISLE + 0.5, 12.0, 0.8)],
        [Vec3::new(-AISLE - 0.5, 0.0, -length - 0.5), Vec3::new(-NAVE, AISLE_ROOF, -length - 0.2)],
        [Vec3::new(NAVE, 0.0, -length - 0.5), Vec3::new(AISLE + 0.5, AISLE_ROOF, -length - 0.2)],
    ] {
        builder.cuboid(low, high);
    }
    let great = Opening { half_width: 2.1, sill: 2.6, spring: 6.2 };
    let end = Wall { half_width: NAVE + 0.4, bottom: 0.0, top: 11.8, thickness: 0.6, opening: great };
    builder.place(Affine3A::from_translation(Vec3::NEG_Z * (length + 0.4)), |builder| {
        architecture::wall(builder, end, detail);
        let half = Opening { half_width: 1.05, sill: 2.6, spring: 5.6 };
        for x in [-1.05, 1.05] {
            builder.place(Affine3A::from_translation(Vec3::X * x), |builder| {
                architecture::tracery(builder, half, detail);
            });
        }
        builder.paint(paints::STONE).tube(
            &[Vec3::new(0.0, 2.6, 0.0), Vec3::new(0.0, 7.2, 0.0)],
            |_| 0.09,
            detail.quads(8, 3),
        );
    });
    if detail.is_ornate() {
        rose(builder, Vec3::new(0.0, 7.6, -length - 0.4), 0.82, detail);
    }
}

/// A wheel of tracery, around `middle`, facing +Z.
fn rose(builder: &mut MeshBuilder, middle: Vec3, radius: f32, detail: Detail) {
    let mut circle = |center: Vec3, radius: f32, thickness: f32, around: u32| {
        let sheet = [detail.quads(8, 3), detail.quads(around, 5)];
        builder.paint(paints::STONE).ring(center, radius, [thickness; 2], sheet);
    };
    circle(middle, radius, 0.08, 48);
    circle(middle, 0.26 * radius, 0.045, 24);
    for petal in 0..8 {
        let (sin, cos) = sin_cos(TAU * petal as f32 / 8.0);
        circle(middle + Vec3::new(cos, sin, 0.0) * (0.63 * radius), 0.25 * radius, 0.035, 20);
    }
}

/// One bay around z = 0, both sides.
fn one_bay(builder: &mut MeshBuilder, detail: Detail) {
    let nave = Vault { half_size: Vec2::new(NAVE, 0.5 * BAY), spring: NAVE_SPRING, rise: NAVE_RISE };
    architecture::vault(builder, nave, 0.1, detail);
    let half_width = 0.5 * BAY;
    let arcade = Opening { half_width: half_width - 0.62, sill: 0.0, spring: ARCADE_SPRING };
    let arcade = Wall { half_width, bottom: 0.0, top: AISLE_ROOF + 0.2, thickness: 0.62, opening: arcade };
    let clerestory = Opening { half_width: 1.3, sill: 6.8, spring: 8.0 };
    let upper = Wall { half_width, bottom: AISLE_ROOF + 0.2, top: 11.7, thickness: 0.5, opening: clerestory };
    let lancet = Opening { half_width: 0.85, sill: 2.2, spring: 3.7 };
    let outer = Wall { half_width, bottom: 0.0, top: AISLE_ROOF + 0.1, thickness: 0.5, opening: lancet };
    for side in [-1.0, 1.0] {
        // Fronts face the nave.
        let facing = turned(-side * 0.25 * TAU);
        let at = |out: f32| Affine3A::from_rotation_translation(facing, Vec3::X * (side * out));
        builder.place(at(NAVE), |builder| architecture::wall(builder, arcade, detail));
        builder.place(at(NAVE), |builder| {
            architecture::wall(builder, upper, detail);
            architecture::tracery(builder, clerestory, detail);
        });
        builder.place(at(AISLE), |builder| {
            architecture::wall(builder, outer, detail);
            architecture::tracery(builder, lancet, detail);
        });
        let middle = 0.5 * (NAVE + AISLE);
        let aisle = Vault {
            half_size: Vec2::new(0.5 * (AISLE - NAVE), 0.5 * BAY),
            spring: ARCADE_SPRING,
            rise: AISLE_ROOF - ARCADE_SPRING - 0.35,
        };
        builder.place(Affine3A::from_translation(Vec3::X * (side * middle)), |builder| {
            architecture::vault(builder, aisle, 0.07, detail);
        });
        if !detail.is_ornate() {
            continue;
        }
        // Slender shafts carry the ribs of the nave's vault.
        let shaft = Vec3::new(side * (NAVE - 0.36), 0.0, half_width);
        builder.place(Affine3A::from_translation(shaft), |builder| {
            let outline = [
                (0.02, ARCADE_SPRING + 0.1),
                (0.13, ARCADE_SPRING + 0.3),
                (0.17, ARCADE_SPRING + 0.42),
                (0.11, ARCADE_SPRING + 0.5),
                (0.1, NAVE_SPRING - 0.5),
                (0.14, NAVE_SPRING - 0.45),
                (0.11, NAVE_SPRING - 0.4),
                (0.13, NAVE_SPRING - 0.2),
                (0.22, NAVE_SPRING),
                (0.22, NAVE_SPRING + 0.08),
            ]
            .map(Vec2::from);
            builder.paint(paints::STONE).lathe(&outline, detail.quads(14, 3));
        });
    }
}

/// Steps up to the far end, a rail, and a lectern with a book.
fn dais(builder: &mut MeshBuilder, detail: Detail) {
    let rear = -BAY * BAYS as f32;
    builder.paint(paints::STONE);
    for step in 0..4 {
        let height = 0.16 * step as f32;
        let front = rear + 6.2 - 0.36 * step as f32;
        builder.cuboid(Vec3::new(-NAVE + 0.4, height, rear), Vec3::new(NAVE - 0.4, height + 0.16, front));
    }
    paints::runner(builder, Vec3::new(0.0, 0.645, rear + 2.5), Vec2::new(2.0, 5.0));
    if !detail.is_ornate() {
        return;
    }
    let (height, front) = (0.64, rear + 4.85);
    for side in [-1.0, 1.0] {
        let [inner, outer] = [1.25, NAVE - 0.6].map(|x| side * x);
        let balusters = detail.things(14).max(1);
        for index in 0..balusters {
            let x = mix(inner, outer, (index as f32 + 0.5) / balusters as f32);
            furniture::baluster(builder, Vec3::new(x, height, front), 0.72, paints::STONE, detail);
        }
        let rail = Vec3::new(0.5 * (inner + outer), height + 0.78, front);
        builder.place(Affine3A::from_translation(rail), |builder| {
            builder.rounded_cuboid(Vec3::new(0.5 * (outer - inner).abs() + 0.1, 0.06, 0.12), 0.03, detail.quads(2, 1));
        });
    }
    let lectern = Vec3::new(0.0, height, rear + 3.4);
    builder.place(Affine3A::from_translation(lectern), |builder| {
        furniture::baluster(builder, Vec3::ZERO, 1.05, paints::BRASS, detail);
        let lean = Affine3A::from_rotation_translation(rotation(Vec3::X, 0.5), Vec3::Y * 1.12);
        builder.place(lean, |builder| {
            builder.paint(paints::WOOD).cuboid(Vec3::new(-0.32, -0.04, -0.25), Vec3::new(0.32, 0.0, 0.25));
            furniture::open_book(builder, detail);
        });
    });
}

fn furnish(builder: &mut MeshBuilder, detail: Detail) {
    let mut random = Random::new(3);
    let [mut chair, mut table, mut lamp, mut book, mut case] = std::array::from_fn(|_| MeshBuilder::new());
    furniture::chair(&mut chair, detail);
    furniture::table(&mut table, 1.6, detail);
    furniture::lamp(&mut lamp, detail);
    furniture::open_book(&mut book, detail);
    furniture::bookcase(&mut case, detail);
    for stand in case_transforms() {
        builder.instance(&case, stand);
    }
    for bay in 0..detail.things(4) {
        for side in [-1.0, 1.0] {
            let middle = Vec3::new(side * 2.45, 0.0, -6.4 - 4.7 * bay as f32);
            builder.instance(&table, Affine3A::from_translation(middle));
            for z in [-0.8, 0.8] {
                let top = middle + Vec3::new(0.0, 0.77, z);
                builder.instance(&lamp, Affine3A::from_rotation_translation(turned(0.25 * TAU), top));
            }
            for seat in 0..6 {
                let facing = if seat < 3 { -1.0 } else { 1.0 };
                let z = 1.05 * ((seat % 3) as f32 - 1.0) + random.range(-0.07, 0.07);
                let away = if random.unit() < 0.2 { random.range(0.35, 0.5) } else { random.range(0.02, 0.16) };
                let turn = turned(facing * -0.25 * TAU + random.range(-0.14, 0.14));
                let foot = middle + Vec3::new(-facing * (0.62 + away), 0.0, z);
                builder.instance(&chair, Affine3A::from_rotation_translation(turn, foot));
                if random.unit() < 0.45 {
                    let turn = turned(facing * -0.25 * TAU + random.range(-0.3, 0.3));
                    let top = middle + Vec3::new(-facing * 0.3, 0.77, z + random.range(-0.1, 0.1));
                    builder.instance(&book, Affine3A::from_rotation_translation(turn, top));
                }
            }
        }
    }
    if !detail.is_ornate() {
        return;
    }
    builder.place(Affine3A::from_translation(GLOBE.with_y(0.0)), |builder| {
        furniture::globe_stand(builder, detail);
    });
}

/// Transforms of the bookcases: across the aisles at the piers between the windows.
fn case_transforms() -> impl Iterator<Item = Affine3A> {
    (0..BAYS).flat_map(|pier| {
        [-1.0, 1.0].map(|side| {
            let middle = Vec3::new(side * (AISLE - 0.35 - 0.5 * CASE_LENGTH), 0.0, -BAY * (pier as f32 + 1.0));
            Affine3A::from_translation(middle)
        })
    })
}

/// Fills the bookcases, in about `triangles` triangles.
fn books(builder: &mut MeshBuilder, triangles: usize) {
    const USUAL_ON_SHELF: usize = 46;
    let mut random = Random::new(17);
    let transforms: Vec<Affine3A> = case_transforms().collect();
    let shelves = transforms.len() * SHELVES_IN_CASE as usize;
    let bends = (triangles / (USUAL_ON_SHELF * shelves)).saturating_sub(5) / 3;
    let bends = bends.clamp(1, 1 << 12) as u32;
    let mut left = triangles / furniture::book_triangles(bends);
    for (shelf, transform) in (0..shelves).map(|shelf| (shelf, transforms[shelf / SHELVES_IN_CASE as usize])) {
        // The remaining shelves share the remaining books.
        let count = left.div_ceil(shelves - shelf);
        left -= count;
        builder.place(transform, |builder| {
            let shelf = (shelf % SHELVES_IN_CASE as usize) as u32;
            furniture::books(builder, &mut random, shelf, count as u32, bends);
        });
    }
}
