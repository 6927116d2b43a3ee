//! Joins WGSL modules into one text.
//!
//! A module names what it needs in statements `import package::path::{Item, …};`, as in WESL. Names are unique in what is
//! linked, so joining is concatenation: each needed module once, before those that need it. Bindings that each stage
//! declares at a number of its own, such as `triangles`, are imported by `import stage::{triangles};`.
//!
//! Debug builds check that every module imports what it uses, and nothing else.

mod imports;

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
    ("grid::fixed", include_str!("grid/fixed.wgsl")),
    ("grid::set_up", include_str!("grid/set_up.wgsl")),
    ("grid::space", include_str!("grid/space.wgsl")),
    ("grid::project", include_str!("grid/project.wgsl")),
    ("light::assign", include_str!("light/assign.wgsl")),
    ("light::balance", include_str!("light/balance.wgsl")),
    ("light::blocks", include_str!("light/blocks.wgsl")),
    ("light::cells", include_str!("light/cells.wgsl")),
    ("light::choose", include_str!("light/choose.wgsl")),
    ("light::light", include_str!("light/light.wgsl")),
    ("light::survey", include_str!("light/survey.wgsl")),
    ("light::point_view", include_str!("light/point_view.wgsl")),
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
    ("primitives::scan", include_str!("primitives/scan.wgsl")),
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
    ("wrap", include_str!("wrap.wgsl")),
];

/// A shader's whole text.
///
/// # Panics
/// If `path`, or a module that it imports, isn't listed here; in debug builds also where imports aren't what is used.
pub(crate) fn link(path: &str) -> String {
    link_with(&[], path)
}

/// As [`link`], where a module may also be one of `others`, which have paths and texts as the crate's own.
///
/// # Panics
/// As [`link`] does.
#[doc(hidden)]
#[must_use]
pub fn link_with(others: &[(&str, &str)], path: &str) -> String {
    let mut linked = Vec::new();
    join(others, path, &mut linked);
    text_of(&linked)
}

/// A shader's whole text, for a root module that isn't listed here, such as a test's.
///
/// # Panics
/// As [`link`] does.
pub(crate) fn link_text(root: &str) -> String {
    let mut linked = Vec::new();
    join_text(&[], "the root", root, &mut linked);
    text_of(&linked)
}

/// A module that has been read.
#[derive(Debug)]
struct Module<'a> {
    path: &'a str,
    imports: Vec<Import<'a>>,
    /// Its text without import statements.
    body: String,
}

/// One import statement.
#[derive(Debug)]
struct Import<'a> {
    /// `a::b`, or [`STAGE`].
    path: &'a str,
    /// What stands between the braces.
    items: &'a str,
}

/// What items are imported from that the root module declares.
const STAGE: &str = "stage";

impl Import<'_> {
    fn names(&self) -> impl Iterator<Item = &str> {
        self.items.split(',').map(str::trim).filter(|name| !name.is_empty())
    }
}

fn join<'a>(others: &[(&str, &'a str)], path: &'a str, linked: &mut Vec<Module<'a>>) {
    let mut modules = MODULES.iter().chain(others);
    let Some((_, text)) = modules.find(|(name, _)| *name == path) else { panic!("no shader module {path}") };
    if linked.iter().all(|module| module.path != path) {
        join_text(others, path, text, linked);
    }
}

fn join_text<'a>(others: &[(&str, &'a str)], path: &'a str, text: &'a str, linked: &mut Vec<Module<'a>>) {
    let module = read(path, text);
    for import in module.imports.iter().filter(|import| import.path != STAGE) {
        join(others, import.path, linked);
    }
    linked.push(module);
}

/// The modules' joined text.
fn text_of(linked: &[Module<'_>]) -> String {
    if cfg!(debug_assertions) {
        let faults = imports::faults(linked);
        assert!(faults.is_empty(), "{}", faults.join("\n"));
    }
    linked.iter().map(|module| module.body.as_str()).collect()
}

/// Takes the import statements, each of which begins a line, out of a module's text.
fn read<'a>(path: &'a str, text: &'a str) -> Module<'a> {
    let (mut imports, mut body, mut rest) = (Vec::new(), String::new(), text);
    while let Some(start) =
        if rest.starts_with("import ") { Some(0) } else { rest.find("\nimport ").map(|end| end + 1) }
    {
        let (before, from_here) = rest.split_at(start);
        body.push_str(before);
        let (statement, after) = from_here.split_once(';').unwrap_or((from_here, ""));
        let parts = statement.strip_suffix('}').and_then(|import| import["import ".len()..].split_once("::{"));
        let Some((from, items)) = parts else { panic!("{path}: can't read `{statement}`") };
        imports.push(Import { path: from.strip_prefix("package::").unwrap_or(from), items });
        rest = after.strip_prefix('\n').unwrap_or(after);
    }
    body.push_str(rest);
    body.push('\n');
    Module { path, imports, body }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the stages declare that modules import from them.
    const OF_STAGES: [(&str, &str); 5] = [
        ("point_view", "var<uniform> point_view: PointView;"),
        ("masks", "var<storage, read> masks: array<u32>;"),
        ("positions", "var<storage, read> positions: array<u32>;"),
        ("triangles", "var<storage, read> triangles: array<vec4<u32>>;"),
        ("vertices", "var<storage, read> vertices: array<vec4<u32>>;"),
    ];

    #[test]
    fn every_module_links_and_is_valid_wgsl() {
        for (path, text) in MODULES {
            // As part of a stage that declares what this module and those that it imports leave to it.
            let mut modules = Vec::new();
            join(&[], path, &mut modules);
            let imports: Vec<_> = modules.iter().flat_map(|module| &module.imports).collect();
            let left: Vec<&str> =
                imports.iter().filter(|import| import.path == STAGE).flat_map(|import| import.names()).collect();
            let mut stage = (*text).to_owned();
            for ((name, declaration), binding) in OF_STAGES.into_iter().zip(100..) {
                if left.contains(&name) && !text.contains(&format!("> {name}:")) {
                    stage.push_str(&format!("@group(0) @binding({binding}) {declaration}\n"));
                }
            }
            let text = link_text(&stage);
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
        let text = link_text(
            "import package::dispatch::{Invocation, flat_group};\n\
             import package::primitives::workgroup_scan::{\n    scan_workgroup,\n};\n\
             fn last(at: Invocation) { flat_group(at); scan_workgroup(); }",
        );
        assert_eq!(text.matches("fn flat_group").count(), 1);
        assert!(text.find("fn flat_group") < text.find("fn last"));
        assert!(!text.contains("import"));
    }

    #[test]
    #[should_panic(expected = "can't read `import package::dispatch::flat_group`")]
    fn what_is_no_import_is_named() {
        link_text("import package::dispatch::flat_group;\n");
    }
}
