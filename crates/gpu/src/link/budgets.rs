//! Compile cost of each kernel, as a table that is kept beside the crate, so that reviews show changes.
//!
//! Shader compilers inline every call: a function's cost counts once for each path of calls that leads to it.

use std::fmt::Write;

use naga::proc::Layouter;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, EntryPoint, Expression, Function, Module, Statement};

use super::{MODULES, link};

/// The kept table, and the path to which it is written anew.
const KEPT: &str = include_str!("../../budgets.tsv");
const KEPT_PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/budgets.tsv");

/// Cost of a function with all calls inlined.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cost {
    /// Operations and statements.
    operations: usize,
    /// Bytes of function-scope variables.
    variables: u32,
}

/// A module, and the costs of its functions, in order.
struct Costs {
    module: Module,
    info: ModuleInfo,
    layouter: Layouter,
    of_functions: Vec<Cost>,
}

impl Costs {
    fn new(text: &str) -> Self {
        let module = naga::front::wgsl::parse_str(text).expect("WGSL");
        let info = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module).expect("valid WGSL");
        let mut layouter = Layouter::default();
        layouter.update(module.to_ctx()).expect("valid types");
        let mut costs = Self { module, info, layouter, of_functions: Vec::new() };
        // A function comes after the functions that it calls.
        for (_, function) in costs.module.functions.iter() {
            let cost = costs.of(function);
            costs.of_functions.push(cost);
        }
        costs
    }

    fn of(&self, function: &Function) -> Cost {
        let is_operation = |expression: &Expression| {
            !matches!(
                expression,
                Expression::Literal(_)
                    | Expression::Constant(_)
                    | Expression::Override(_)
                    | Expression::ZeroValue(_)
                    | Expression::FunctionArgument(_)
                    | Expression::GlobalVariable(_)
                    | Expression::LocalVariable(_)
                    | Expression::CallResult(_)
            )
        };
        let operations = function.expressions.iter().filter(|(_, expression)| is_operation(expression)).count();
        let variables = function.local_variables.iter().map(|(_, variable)| self.layouter[variable.ty].size).sum();
        let mut cost = Cost { operations, variables };
        self.add_statements(&function.body, &mut cost);
        cost
    }

    fn add_statements(&self, block: &naga::Block, cost: &mut Cost) {
        for statement in block {
            cost.operations += usize::from(!matches!(statement, Statement::Emit(_) | Statement::Block(_)));
            match statement {
                Statement::Call { function, .. } => {
                    let called = self.of_functions[function.index()];
                    cost.operations += called.operations;
                    cost.variables += called.variables;
                }
                Statement::Block(block) => self.add_statements(block, cost),
                Statement::If { accept, reject, .. } => {
                    self.add_statements(accept, cost);
                    self.add_statements(reject, cost);
                }
                Statement::Loop { body, continuing, .. } => {
                    self.add_statements(body, cost);
                    self.add_statements(continuing, cost);
                }
                Statement::Switch { cases, .. } => cases.iter().for_each(|case| self.add_statements(&case.body, cost)),
                _ => {}
            }
        }
    }

    /// The table's line of an entry point.
    fn line(&self, path: &str, number: usize, entry: &EntryPoint) -> String {
        let uses = self.info.get_entry_point(number);
        let (mut workgroup_bytes, mut storage_bindings) = (0, 0);
        for (_, variable) in self.module.global_variables.iter().filter(|(handle, _)| !uses[*handle].is_empty()) {
            match variable.space {
                AddressSpace::WorkGroup => workgroup_bytes += self.layouter[variable.ty].size,
                AddressSpace::Storage { .. } => storage_bindings += 1,
                _ => {}
            }
        }
        let Cost { operations, variables } = self.of(&entry.function);
        format!("{path}::{}\t{operations}\t{variables}\t{workgroup_bytes}\t{storage_bindings}", entry.name)
    }
}

fn table() -> String {
    let mut table = "kernel\toperations\tbytes of variables\tbytes of workgroup memory\tstorage bindings\n".to_owned();
    for (path, _) in MODULES.iter().filter(|(_, text)| text.contains("@compute")) {
        let costs = Costs::new(&link(path));
        for (number, entry) in costs.module.entry_points.iter().enumerate() {
            writeln!(table, "{}", costs.line(path, number, entry)).expect("a text");
        }
    }
    table
}

#[test]
fn kernels_cost_what_the_kept_table_says() {
    let table = table();
    if std::env::var_os("UMBRAGE_WRITE_BUDGETS").is_some() {
        std::fs::write(KEPT_PATH, &table).expect("the table written");
        return;
    }
    let changed: Vec<_> = table.lines().filter(|line| KEPT.lines().all(|kept| kept != *line)).collect();
    assert!(
        changed.is_empty() && table.lines().count() == KEPT.lines().count(),
        "kernels cost other than crates/gpu/budgets.tsv says (write it anew by running this test with \
         UMBRAGE_WRITE_BUDGETS=1, and look at the difference): {changed:#?}",
    );
}

#[test]
fn a_function_costs_once_for_each_way_to_it() {
    let once = "fn f(a: u32) -> u32 { var b = a; b += 3u; return b; }
        @group(0) @binding(0) var<storage, read_write> out: array<u32>;
        @compute @workgroup_size(1) fn main() { out[0] = f(1u); }";
    let twice = once.replace("f(1u)", "f(1u) + f(2u)");
    let [once, twice] = [once, &twice].map(|text| {
        let costs = Costs::new(text);
        (costs.of_functions[0], costs.of(&costs.module.entry_points[0].function))
    });
    let (function, main) = once;
    // The second also has a call and a sum.
    assert!(function.operations >= 4, "{function:?}");
    assert_eq!(twice.1.operations, main.operations + function.operations + 2);
    assert_eq!([function.variables, main.variables, twice.1.variables], [4, 4, 8]);
}
