//! Adds counters to a shader.

use naga::valid::{Capabilities, FunctionInfo, ValidationFlags, Validator};
use naga::{
    BinaryOperator, Binding, Block, BuiltIn, EntryPoint, Expression, Function, FunctionArgument, GlobalVariable,
    Handle, Literal, Module, Range, ScalarKind, Span, Statement, SwitchCase, Type, TypeInner,
};

use super::cost::{Cost, Costs};

/// WGSL of the counters, and the function that each invocation calls at its end.
const COUNTERS: &str = include_str!("counters.wgsl");

/// An invocation's counters, in the order of [`Cost`].
const NAMES: [&str; 6] =
    ["counted_floats", "counted_integers", "counted_accesses", "counted_shared", "counted_read", "counted_written"];

/// The functions of the counters, which aren't counted.
const OWN: [&str; 2] = ["add_counted", "sum_counted"];

/// A shader whose blocks count their operations, and whose entry points sum the counts.
///
/// # Panics
/// If the shader isn't valid.
pub(crate) fn instrument(text: &str) -> Module {
    let text = [text, COUNTERS].concat();
    let parsed = naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&text)));
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
    let info = validator.validate(&parsed).expect("a valid shader");
    let mut module = parsed.clone();
    let counters = NAMES.map(|name| {
        let mut all = parsed.global_variables.iter();
        all.find(|(_, variable)| variable.name.as_deref() == Some(name)).expect("a counter").0
    });
    for (handle, function) in parsed.functions.iter() {
        if !function.name.as_deref().is_some_and(|name| OWN.contains(&name)) {
            module.functions[handle] = counted(&parsed, &info[handle], function, counters);
        }
    }
    let sum = parsed.functions.iter().find(|(_, function)| function.name.as_deref() == Some("sum_counted"));
    let sum = sum.expect("it stands in the text").0;
    for (number, entry) in parsed.entry_points.iter().enumerate() {
        let mut inner = counted(&parsed, info.get_entry_point(number), &entry.function, counters);
        inner.name = Some(format!("counted_{}", entry.name));
        inner.arguments.iter_mut().for_each(|argument| argument.binding = None);
        let inner = module.functions.append(inner, Span::UNDEFINED);
        module.entry_points[number].function = around(&mut module, entry, inner, sum);
    }
    module
}

/// A function whose blocks each begin with their counts.
fn counted(module: &Module, info: &FunctionInfo, of: &Function, counters: [Handle<GlobalVariable>; 6]) -> Function {
    let mut function = of.clone();
    let costs = Costs { module, info, function: of };
    function.body = counted_block(&costs, &mut function, &of.body, counters);
    function
}

fn counted_block(
    costs: &Costs<'_>,
    into: &mut Function,
    block: &Block,
    counters: [Handle<GlobalVariable>; 6],
) -> Block {
    let mut statements = Vec::new();
    // Statements that always run together: up to one that may leave the function or the loop.
    let mut rest = &block[..];
    while !rest.is_empty() {
        let end = rest.iter().position(has_blocks).map_or(rest.len(), |last| last + 1);
        let (together, behind) = rest.split_at(end);
        let mut cost = Cost::default();
        for statement in together {
            costs.add_statement(statement, &mut cost);
            if let Statement::Emit(range) = statement {
                range.clone().for_each(|expression| costs.add_expression(expression, &mut cost));
            }
        }
        for (counter, amount) in counters.into_iter().zip(cost).filter(|(_, amount)| *amount > 0) {
            add_to(into, counter, amount, &mut statements);
        }
        let mut inner = |block: &Block| counted_block(costs, into, block, counters);
        statements.extend(together.iter().map(|statement| with_blocks(statement, &mut inner)));
        rest = behind;
    }
    Block::from_vec(statements)
}

fn has_blocks(statement: &Statement) -> bool {
    matches!(statement, Statement::Block(_) | Statement::If { .. } | Statement::Loop { .. } | Statement::Switch { .. })
}

/// A statement with each of its blocks replaced by `inner`.
fn with_blocks(statement: &Statement, inner: &mut dyn FnMut(&Block) -> Block) -> Statement {
    match statement {
        Statement::Block(block) => Statement::Block(inner(block)),
        Statement::If { condition, accept, reject } => {
            Statement::If { condition: *condition, accept: inner(accept), reject: inner(reject) }
        }
        Statement::Loop { body, continuing, break_if } => {
            Statement::Loop { body: inner(body), continuing: inner(continuing), break_if: *break_if }
        }
        Statement::Switch { selector, cases } => {
            let case = |case: &SwitchCase| SwitchCase { body: inner(&case.body), ..case.clone() };
            Statement::Switch { selector: *selector, cases: cases.iter().map(case).collect() }
        }
        other => other.clone(),
    }
}

/// `counter += amount;`
fn add_to(function: &mut Function, counter: Handle<GlobalVariable>, amount: u32, to: &mut Vec<Statement>) {
    let mut append = |expression| function.expressions.append(expression, Span::UNDEFINED);
    let pointer = append(Expression::GlobalVariable(counter));
    let right = append(Expression::Literal(Literal::U32(amount)));
    let left = append(Expression::Load { pointer });
    let value = append(Expression::Binary { op: BinaryOperator::Add, left, right });
    to.push(Statement::Emit(Range::new_from_bounds(left, value)));
    to.push(Statement::Store { pointer, value });
}

/// An entry point that calls its former body, then sums up.
fn around(module: &mut Module, entry: &EntryPoint, inner: Handle<Function>, sum: Handle<Function>) -> Function {
    let (mut arguments, mut expressions) = (entry.function.arguments.clone(), naga::Arena::new());
    let lane = lane_of(module, &mut arguments);
    let given: Vec<_> = (0..arguments.len() as u32)
        .map(|argument| expressions.append(Expression::FunctionArgument(argument), Span::UNDEFINED))
        .collect();
    let passed = given[..entry.function.arguments.len()].to_vec();
    let mut body = vec![Statement::Call { function: inner, arguments: passed, result: None }];
    let lane = match lane {
        (argument, None) => given[argument],
        (argument, Some(index)) => {
            let member = Expression::AccessIndex { base: given[argument], index };
            let lane = expressions.append(member, Span::UNDEFINED);
            body.push(Statement::Emit(Range::new_from_bounds(lane, lane)));
            lane
        }
    };
    body.push(Statement::Call { function: sum, arguments: vec![lane], result: None });
    body.push(Statement::Return { value: None });
    Function { arguments, expressions, body: Block::from_vec(body), ..Function::default() }
}

/// The argument with an invocation's index in its workgroup, and the member if it is a struct; added if there is none.
fn lane_of(module: &mut Module, arguments: &mut Vec<FunctionArgument>) -> (usize, Option<u32>) {
    let is_lane = |binding: &Option<Binding>| *binding == Some(Binding::BuiltIn(BuiltIn::LocalInvocationIndex));
    for (number, argument) in arguments.iter().enumerate() {
        if is_lane(&argument.binding) {
            return (number, None);
        }
        if let TypeInner::Struct { members, .. } = &module.types[argument.ty].inner
            && let Some(member) = members.iter().position(|member| is_lane(&member.binding))
        {
            return (number, Some(member as u32));
        }
    }
    let inner = TypeInner::Scalar(naga::Scalar { kind: ScalarKind::Uint, width: 4 });
    let ty = module.types.insert(Type { name: None, inner }, Span::UNDEFINED);
    let binding = Some(Binding::BuiltIn(BuiltIn::LocalInvocationIndex));
    arguments.push(FunctionArgument { name: None, ty, binding });
    (arguments.len() - 1, None)
}
