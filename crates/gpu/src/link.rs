//! Joins WGSL modules into one text.
//!
//! A module names what it needs in lines `import package::path::{Item, …};` at its top, as in WESL. Names are unique in
//! the whole crate, so joining is concatenation: each needed module once, before those that need it.

/// Every module's path and text.
const MODULES: &[(&str, &str)] = &[
    ("dispatch", include_str!("dispatch.wgsl")),
    ("primitives::scan", include_str!("primitives/scan.wgsl")),
    ("shade::attributes", include_str!("shade/attributes.wgsl")),
    ("shade::brdf", include_str!("shade/brdf.wgsl")),
    ("shade::develop", include_str!("shade/develop.wgsl")),
    ("shade::hit", include_str!("shade/hit.wgsl")),
    ("shade::irradiance", include_str!("shade/irradiance.wgsl")),
    ("shade::panorama", include_str!("shade/panorama.wgsl")),
    ("shade::rows", include_str!("shade/rows.wgsl")),
    ("shade::shade", include_str!("shade/shade.wgsl")),
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
    let mut joined = Vec::new();
    let mut text = String::new();
    join(path, &mut joined, &mut text);
    text
}

/// A shader's whole text, for a root module that isn't listed here, such as a test's.
pub(crate) fn link_text(root: &str) -> String {
    let mut text = String::new();
    join_text(root, &mut Vec::new(), &mut text);
    text
}

fn join<'a>(path: &'a str, joined: &mut Vec<&'a str>, text: &mut String) {
    if joined.contains(&path) {
        return;
    }
    joined.push(path);
    let Some((_, module)) = MODULES.iter().find(|(name, _)| *name == path) else { panic!("no shader module {path}") };
    join_text(module, joined, text);
}

fn join_text<'a>(module: &'a str, joined: &mut Vec<&'a str>, text: &mut String) {
    for path in module.lines().filter_map(imported) {
        join(path, joined, text);
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
            let text = link(path);
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
