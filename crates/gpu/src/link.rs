//! Joins WGSL modules into one text.
//!
//! A module names what it needs in lines `import package::path::{Item, …};` at its top, as in WESL. Names are unique in
//! the whole crate, so joining is concatenation: each needed module once, before those that need it.

/// Every module's path and text.
const MODULES: &[(&str, &str)] = &[
    ("camera::balance", include_str!("camera/balance.wgsl")),
    ("camera::nodes", include_str!("camera/nodes.wgsl")),
    ("camera::settle", include_str!("camera/settle.wgsl")),
    ("camera::trace", include_str!("camera/trace.wgsl")),
    ("camera::work", include_str!("camera/work.wgsl")),
    ("dispatch", include_str!("dispatch.wgsl")),
    ("exact::camera", include_str!("exact/camera.wgsl")),
    ("exact::corners", include_str!("exact/corners.wgsl")),
    ("exact::double", include_str!("exact/double.wgsl")),
    ("exact::expansion", include_str!("exact/expansion.wgsl")),
    ("exact::mask", include_str!("exact/mask.wgsl")),
    ("exact::predicate", include_str!("exact/predicate.wgsl")),
    ("exact::shadow", include_str!("exact/shadow.wgsl")),
    ("exact::single", include_str!("exact/single.wgsl")),
    ("exact::vector", include_str!("exact/vector.wgsl")),
    ("fit", include_str!("fit.wgsl")),
    ("grid::header", include_str!("grid/header.wgsl")),
    ("grid::list", include_str!("grid/list.wgsl")),
    ("grid::project", include_str!("grid/project.wgsl")),
    ("grid::set_up", include_str!("grid/set_up.wgsl")),
    ("grid::space", include_str!("grid/space.wgsl")),
    ("grid::transform", include_str!("grid/transform.wgsl")),
    ("light::assign", include_str!("light/assign.wgsl")),
    ("light::balance", include_str!("light/balance.wgsl")),
    ("light::blocks", include_str!("light/blocks.wgsl")),
    ("light::cells", include_str!("light/cells.wgsl")),
    ("light::choose", include_str!("light/choose.wgsl")),
    ("light::light", include_str!("light/light.wgsl")),
    ("light::locate", include_str!("light/locate.wgsl")),
    ("light::locate_view", include_str!("light/locate_view.wgsl")),
    ("light::map", include_str!("light/map.wgsl")),
    ("light::points", include_str!("light/points.wgsl")),
    ("light::settle", include_str!("light/settle.wgsl")),
    ("light::sort", include_str!("light/sort.wgsl")),
    ("light::spread", include_str!("light/spread.wgsl")),
    ("light::trace", include_str!("light/trace.wgsl")),
    ("mask::exact", include_str!("mask/exact.wgsl")),
    ("mask::filter", include_str!("mask/filter.wgsl")),
    ("mask::flags", include_str!("mask/flags.wgsl")),
    ("mask::table", include_str!("mask/table.wgsl")),
    ("omit", include_str!("omit.wgsl")),
    ("pose::pose", include_str!("pose/pose.wgsl")),
    ("primitives::compact", include_str!("primitives/compact.wgsl")),
    ("primitives::scan", include_str!("primitives/scan.wgsl")),
    ("primitives::sort", include_str!("primitives/sort.wgsl")),
    ("primitives::workgroup_scan", include_str!("primitives/workgroup_scan.wgsl")),
    ("shade::attributes", include_str!("shade/attributes.wgsl")),
    ("shade::brdf", include_str!("shade/brdf.wgsl")),
    ("shade::develop", include_str!("shade/develop.wgsl")),
    ("shade::hit", include_str!("shade/hit.wgsl")),
    ("shade::irradiance", include_str!("shade/irradiance.wgsl")),
    ("shade::panorama", include_str!("shade/panorama.wgsl")),
    ("shade::rows", include_str!("shade/rows.wgsl")),
    ("shade::shade", include_str!("shade/shade.wgsl")),
    ("shade::shown", include_str!("shade/shown.wgsl")),
    ("shade::specular_albedo", include_str!("shade/specular_albedo.wgsl")),
    ("shade::surface", include_str!("shade/surface.wgsl")),
    ("shade::surroundings", include_str!("shade/surroundings.wgsl")),
    ("shade::tables", include_str!("shade/tables.wgsl")),
    ("shade::texture", include_str!("shade/texture.wgsl")),
    ("shade::tone_map", include_str!("shade/tone_map.wgsl")),
    ("tile_order", include_str!("tile_order.wgsl")),
];

/// A shader's whole text.
///
/// # Panics
/// If `path`, or a module that it imports, isn't listed here.
pub(crate) fn link(path: &str) -> String {
    link_with(&[], path)
}

/// As [`link`], where a module may also be one of `others`, which have paths and texts as the crate's own.
///
/// # Panics
/// If `path`, or a module that it imports, is neither listed here nor among `others`.
#[doc(hidden)]
#[must_use]
pub fn link_with(others: &[(&str, &str)], path: &str) -> String {
    let mut text = String::new();
    join(others, path, &mut Vec::new(), &mut text);
    text
}

/// A shader's whole text, for a root module that isn't listed here, such as a test's.
pub(crate) fn link_text(root: &str) -> String {
    let mut text = String::new();
    join_text(&[], root, &mut Vec::new(), &mut text);
    text
}

fn join<'a>(others: &[(&str, &'a str)], path: &'a str, joined: &mut Vec<&'a str>, text: &mut String) {
    if joined.contains(&path) {
        return;
    }
    joined.push(path);
    let mut modules = MODULES.iter().chain(others);
    let Some((_, module)) = modules.find(|(name, _)| *name == path) else { panic!("no shader module {path}") };
    join_text(others, module, joined, text);
}

fn join_text<'a>(others: &[(&str, &'a str)], module: &'a str, joined: &mut Vec<&'a str>, text: &mut String) {
    for path in module.lines().filter_map(imported) {
        join(others, path, joined, text);
    }
    for line in module.lines().filter(|line| imported(line).is_none()) {
        text.push_str(line);
        text.push('\n');
    }
}

/// `a::b` in `import package::a::b::{Item};`.
fn imported(line: &str) -> Option<&str> {
    let path = line.strip_prefix("import package::")?;
    path.split_once("::{").map(|(path, _)| path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_module_links_and_is_valid_wgsl() {
        for (path, _) in MODULES {
            let mut text = link(path);
            // Some modules leave it to the stage to declare what they read.
            if text.contains("masks[") && !text.contains("> masks:") {
                text.push_str("@group(0) @binding(0) var<storage, read> masks: array<u32>;");
            }
            if text.contains("triangles[") && !text.contains("> triangles:") {
                text.push_str("@group(0) @binding(0) var<storage, read> triangles: array<vec4<u32>>;");
                text.push_str("@group(0) @binding(1) var<storage, read> positions: array<u32>;");
            }
            if text.contains("locate_view.") && !text.contains("> locate_view:") {
                text.push_str("@group(0) @binding(0) var<uniform> locate_view: LocateView;");
            }
            let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| {
                panic!("{path}: {}", error.emit_to_string(&text));
            });
            let mut validator =
                naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
            validator.validate(&module).unwrap_or_else(|error| panic!("{path}: {}", error.emit_to_string(&text)));
        }
    }

    #[test]
    fn a_module_is_joined_once_and_before_its_users() {
        let text =
            link_text("import package::dispatch::{flat_group};\nimport package::primitives::scan::{};\nfn last() {}");
        assert_eq!(text.matches("fn flat_group").count(), 1);
        assert!(text.find("fn flat_group") < text.find("fn last"));
        assert!(!text.contains("import"));
    }
}
