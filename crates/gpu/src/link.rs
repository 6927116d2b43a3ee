//! Joins WGSL modules into one text.
//!
//! A module imports items by statements `import package::path::{Item, …};`, as in WESL. Names are unique in a linked
//! shader, so joining is concatenation: each needed module once, before the modules that import it. Bindings that each
//! stage declares at a number of its own, such as `triangles`, are imported by `import stage::{triangles};`.
//!
//! Debug builds check that every module imports exactly the items that it uses.

#[cfg(test)]
mod budgets;
mod imports;

/// Declares constants that a module has by the same names, and a test that their values agree.
macro_rules! shared_constants {
    ($path:literal: $($(#[$about:meta])* $name:ident: $type:ty = $value:expr;)+) => {
        $($(#[$about])* pub(crate) const $name: $type = $value;)+

        #[cfg(test)]
        #[test]
        fn constants_are_those_of_the_shader() {
            let shader = crate::layout::module(&crate::link::link($path));
            let constants = [$((stringify!($name), $name as u32)),+];
            assert_eq!(crate::layout::other_constants(&shader, &constants), [""; 0]);
        }
    };
}
pub(crate) use shared_constants;

/// Lists modules by folder; each has a prefix for its path and one for its file.
macro_rules! modules {
    ($($path:literal in $folder:literal: $($name:ident)+;)+) => {
        &[$($((
            concat!($path, stringify!($name)),
            include_str!(concat!($folder, stringify!($name), ".wgsl")),
        )),+),+]
    };
}

/// Every module's path and text.
const MODULES: &[(&str, &str)] = modules! {
    "" in "": dispatch fit omit point_view tile_order wrap;
    "camera::" in "camera/": balance nodes settle trace work;
    "exact::" in "exact/": camera cone corners double expansion mask predicate shadow single vector wide;
    "grid::" in "grid/": fixed header list project projection set_up space;
    "light::" in "light/": assign balance batches blocks cells choices choose cone depths light map points seen_point settle sort
        spread survey trace undecided;
    "light::sphere::" in "light/sphere/": angles arcs choose largest map trace turn vertex;
    "mask::" in "mask/": exact filter flags rough_point table;
    "onward::" in "onward/": add ask ask_around count locate media meet path points put_point send step tinted way;
    "pose::" in "pose/": pose;
    "primitives::" in "primitives/": scan workgroup_scan;
    "rays::" in "rays/": hierarchy light line lit question read records settle space tester write;
    "shade::" in "shade/": attributes brdf coat develop drawn facet film glass gloss grooves hit irradiance layers look meeting
        meeting_words microfacet
        onward painted panorama reflected rows shade sheen shown specular_albedo surface surroundings tables texture tint
        tone_map ways;
};

/// A shader's whole text.
///
/// # Panics
/// If `path`, or a module that it imports, isn't listed here; in debug builds also if imports aren't exactly the used items.
pub(crate) fn link(path: &str) -> String {
    link_with(&[], path)
}

/// As [`link`], with more modules: `others` are pairs of a path and a text, like the crate's own.
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
    /// The text between the braces.
    items: &'a str,
}

/// The path of imports from the root module.
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

/// Takes the import statements out of a module's text; each begins a line.
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

    /// Declarations of stages that modules import from them: variables with a binding, and items that a stage defines
    /// for a module.
    const OF_STAGES: &[(&str, &str)] = &[
        ("blocks", "var<storage, read> blocks: array<u32>;"),
        ("bounds", "var<storage, read> bounds: array<u32>;"),
        ("header", "var<storage, read_write> header: array<u32>;"),
        ("light", "var<uniform> light: Light;"),
        ("lit", "var<storage, read_write> lit: array<atomic<u32>>;"),
        ("masks", "var<storage, read> masks: array<u32>;"),
        ("onward_step", "var<uniform> onward_step: OnwardStep;"),
        ("pairs", "var<storage, read> pairs: array<u32>;"),
        ("point_view", "var<uniform> point_view: PointView;"),
        ("planes", "var<storage, read> planes: array<vec4<f32>>;"),
        ("points", "var<storage, read_write> points: array<u32>;"),
        ("positions", "var<storage, read> positions: array<u32>;"),
        ("records", "var<storage, read_write> records: array<u32>;"),
        ("shadow_light", "var<uniform> shadow_light: ShadowLight;"),
        ("sorted", "var<storage, read> sorted: array<vec4<u32>>;"),
        ("spaces", "var<storage, read_write> spaces: array<Space>;"),
        ("triangles", "var<storage, read> triangles: array<vec4<u32>>;"),
        ("undecided", "var<storage, read_write> undecided: array<atomic<u32>>;"),
        ("vertices", "var<storage, read> vertices: array<vec4<u32>>;"),
        ("Cell", "struct Cell { face: u32 }"),
        ("Point", "struct Point { own: u32 }"),
        ("cell_of_block", "fn cell_of_block(entry: u32) -> Cell { return Cell(entry); }"),
        ("does_shadow", "fn does_shadow(slot: u32, point: Point) -> bool { return slot == point.own; }"),
        ("may_shadow", "fn may_shadow(slot: u32, point: Point) -> bool { return slot == point.own; }"),
        ("point_at", "fn point_at(number: u32, own: u32, cell: Cell) -> Point { return Point(own); }"),
        (
            "point_on",
            "fn point_on(slot: u32, id: u32, point: Point, cell: Cell) -> RoughPoint { return RoughPoint(); }",
        ),
        ("record", "fn record(slot: u32, id: u32, cell: Cell) {}"),
    ];
    /// The modules that declare the types of these variables.
    const TYPES_OF_STAGES: &[(&str, &str)] = &[
        ("Light", "light::light"),
        ("OnwardStep", "onward::step"),
        ("PointView", "point_view"),
        ("RoughPoint", "mask::filter"),
        ("ShadowLight", "rays::light"),
        ("Space", "grid::space"),
    ];

    /// A module's text as a stage, with declarations for all items that it and its imports take from the stage.
    fn as_stage(path: &str, text: &str) -> String {
        let mut modules = Vec::new();
        join(&[], path, &mut modules);
        let imports: Vec<_> = modules.iter().flat_map(|module| &module.imports).collect();
        let left: Vec<&str> =
            imports.iter().filter(|import| import.path == STAGE).flat_map(|import| import.names()).collect();
        let mut declared = String::new();
        for ((name, declaration), binding) in OF_STAGES.iter().zip(100..) {
            let own = [format!("> {name}:"), format!("struct {name} "), format!("fn {name}(")];
            // If any module counts a counter up, it is atomic for all.
            let is_counted = modules.iter().any(|module| module.body.contains(&format!("(&{name}[")));
            if left.contains(name) && !own.iter().any(|own| text.contains(own)) {
                if declaration.starts_with("var") {
                    declared.push_str(&format!("@group(0) @binding({binding}) "));
                }
                let declaration = if is_counted && !declaration.contains("atomic") {
                    declaration.replace("array<u32>", "array<atomic<u32>>")
                } else {
                    (*declaration).to_owned()
                };
                declared.push_str(&(declaration + "\n"));
            }
        }
        // The stage imports the types of its declarations, even if the module doesn't name them.
        let has =
            |text: &str, name: &str| text.split(|letter: char| !letter.is_alphanumeric()).any(|word| word == name);
        let needed = TYPES_OF_STAGES.iter().filter(|(name, _)| has(&declared, name) && !has(text, name));
        let imports: String = needed.map(|(name, path)| format!("import package::{path}::{{{name}}};\n")).collect();
        format!("{imports}{text}\n{declared}")
    }

    #[test]
    fn every_module_links_and_is_valid_wgsl() {
        for (path, text) in MODULES {
            let text = link_text(&as_stage(path, text));
            let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| {
                panic!("{path}: {}", error.emit_to_string(&text));
            });
            let mut validator =
                naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
            validator.validate(&module).unwrap_or_else(|error| panic!("{path}: {}", error.emit_to_string(&text)));
        }
    }

    /// Browsers read WGSL by Tint or by naga. Tint needs parentheses that naga doesn't, and proves that whole
    /// workgroups reach each barrier.
    #[test]
    fn tint_takes_every_stage() {
        let folder = std::env::temp_dir().join(format!("umbrage-wgsl-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let mut stages = 0;
        for (path, _) in MODULES.iter().filter(|(_, text)| text.contains("@compute")) {
            let file = folder.join(format!("{}.wgsl", path.replace("::", "_")));
            std::fs::write(&file, link(path)).expect("a file");
            let read = std::process::Command::new("tint").args(["--format", "wgsl"]).arg(&file).output();
            let Ok(read) = read else {
                eprintln!("not checked: there is no command `tint`");
                break;
            };
            assert!(read.status.success(), "{path}: {}", String::from_utf8_lossy(&read.stderr));
            stages += 1;
        }
        std::fs::remove_dir_all(&folder).expect("removed");
        assert!(stages == 0 || stages > 20, "{stages} stages");
    }

    #[test]
    fn a_module_is_joined_once_and_before_its_users() {
        let text = link_text(
            "import package::dispatch::{Invocation, flat_group};\n\
             import package::primitives::workgroup_scan::{\n    scan_workgroup,\n};\n\
             fn last(at: Invocation) { flat_group(at.group); scan_workgroup(); }",
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
