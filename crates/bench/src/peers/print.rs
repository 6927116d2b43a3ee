use std::io::{self, Write};

use super::PeersFlags;
use super::contest::Row;
use crate::median::geometric_mean;
use crate::shot::{Lights, viewpoints};

pub(super) fn head(
    out: &mut impl Write,
    flags: &PeersFlags,
    addresses: &[String],
    [major, minor, patch]: [u32; 3],
) -> io::Result<()> {
    let PeersFlags { size: [width, height], samples, frames, rounds, .. } = flags;
    let threads = rayon::current_num_threads();
    let lights = if flags.lights == Lights::First { "the first light" } else { "all lights" };
    let masks = if flags.masks { "asked" } else { "not asked (all triangles opaque)" };
    writeln!(out, "Embree {major}.{minor}.{patch}, {width}x{height}, samples {samples}, threads {threads}, {lights}")?;
    writeln!(out, "alpha masks {masks}; medians of {frames} frames, {rounds} rounds each, in milliseconds")?;
    viewpoints(addresses).iter().try_for_each(|viewpoint| writeln!(out, "{viewpoint}"))?;
    writeln!(
        out,
        "{:<26}{:>9} |{:>7}{:>7}{:>7}{:>7}{:>8} |{:>7}{:>7}{:>7}{:>8} {:<12}|{:>6} |{:>6}{:>6}{:>6}{:>7} | differ",
        "scene",
        "tris",
        "build",
        "see",
        "survey",
        "shadow",
        "frame",
        "build",
        "see",
        "shadow",
        "frame",
        " Embree's",
        "rays",
        "ratio",
        "best",
        "-rays",
        "light"
    )
}

pub(super) fn columns(out: &mut impl Write, row: &Row) -> io::Result<()> {
    let Row { grids, embree, differences, .. } = row;
    write!(out, "{:<26}{:>9} |", row.scene, row.triangles)?;
    write!(
        out,
        "{:>7.2}{:>7.2}{:>7.2}{:>7.2}{:>8.2} |",
        grids.build, grids.see, grids.survey, grids.shadow, grids.frame
    )?;
    write!(
        out,
        "{:>7.2}{:>7.2}{:>7.2}{:>8.2}  {:<11}|",
        embree.build, embree.see, embree.shadow, embree.frame, embree.name
    )?;
    write!(out, "{:>6.2} |", row.ray_generation.frame)?;
    write!(out, "{:>6.2}{:>6.2}", row.ratio, row.ratio_of_best)?;
    write!(out, "{:>6.2}{:>7.2} |", row.ratio_without_ray_generation, row.further_light)?;
    write!(
        out,
        " hit {} id {}+{}",
        differences.hit_or_miss, differences.triangle, differences.triangle_at_same_distance
    )?;
    writeln!(out, " shadow {} of {}", differences.shadow, differences.points)?;
    if let Some(hierarchy) = &row.hierarchy {
        let ratio = hierarchy.frame / grids.frame;
        writeln!(out, "{:<26}{:>9} | {:.2} by our own hierarchy, ratio {ratio:.1}", "", "", hierarchy.frame)?;
    }
    Ok(())
}

/// Geometric means over the scenes that move.
pub(super) fn means(out: &mut impl Write, rows: &[Row]) -> io::Result<()> {
    let moving: Vec<&Row> = rows.iter().filter(|row| !row.is_static).collect();
    let mean = |of: fn(&Row) -> f64| geometric_mean(moving.iter().map(|row| of(row)));
    writeln!(
        out,
        "geometric mean of the {} moving scenes: ratio {:.2}, of best {:.2}, without ray generation {:.2}, \
         a further light {:.2} of Embree's shadow pass",
        moving.len(),
        mean(|row| row.ratio),
        mean(|row| row.ratio_of_best),
        mean(|row| row.ratio_without_ray_generation),
        mean(|row| row.further_light)
    )
}

pub(super) fn csv_head(out: &mut impl Write) -> io::Result<()> {
    writeln!(
        out,
        "scene,static,triangles,lights,grids_build,grids_see,grids_survey,grids_shadow,grids_frame,grids_best_frame,\
         embree_method,embree_build,embree_see,embree_shadow,embree_frame,embree_best_frame,ray_generation,ratio,\
         ratio_of_best,ratio_without_ray_generation,further_light,hit_or_miss,triangle,triangle_at_same_distance,\
         shadow,points,pixels"
    )
}

pub(super) fn values(out: &mut impl Write, row: &Row) -> io::Result<()> {
    let Row { grids, embree, differences, .. } = row;
    let numbers = [grids.build, grids.see, grids.survey, grids.shadow, grids.frame, grids.best_frame];
    write!(out, "{},{},{},{}", row.scene, row.is_static, row.triangles, row.lights)?;
    numbers.iter().try_for_each(|number| write!(out, ",{number:.3}"))?;
    write!(out, ",{}", embree.name.replace(',', ""))?;
    let numbers = [
        embree.build,
        embree.see,
        embree.shadow,
        embree.frame,
        embree.best_frame,
        row.ray_generation.frame,
        row.ratio,
        row.ratio_of_best,
        row.ratio_without_ray_generation,
        row.further_light,
    ];
    numbers.iter().try_for_each(|number| write!(out, ",{number:.3}"))?;
    let counts = [
        differences.hit_or_miss,
        differences.triangle,
        differences.triangle_at_same_distance,
        differences.shadow,
        differences.points,
        differences.pixels,
    ];
    counts.iter().try_for_each(|count| write!(out, ",{count}"))?;
    writeln!(out)
}
