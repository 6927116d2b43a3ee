//! Cost of each expression and statement.

use naga::proc::TypeResolution;
use naga::valid::FunctionInfo;
use naga::{AddressSpace, BinaryOperator, Expression, Function, Handle, MathFunction, Module, ScalarKind, Statement};
use naga::{TypeInner, VectorSize};

/// Amounts that are added to an invocation's counters, in their order.
pub(super) type Cost = [u32; 6];

const FLOATS: usize = 0;
const INTEGERS: usize = 1;
const ACCESSES: usize = 2;
const SHARED: usize = 3;
const READ: usize = 4;
const WRITTEN: usize = 5;

/// Costs above one operation: long functions of f32, and integer division.
const LONG_FLOAT: u32 = 8;
const INTEGER_DIVISION: u32 = 20;

/// A function whose expressions and statements are counted.
pub(super) struct Costs<'a> {
    pub(super) module: &'a Module,
    pub(super) info: &'a FunctionInfo,
    pub(super) function: &'a Function,
}

impl Costs<'_> {
    /// Adds the cost of evaluating an expression.
    pub(super) fn add_expression(&self, expression: Handle<Expression>, cost: &mut Cost) {
        match &self.function.expressions[expression] {
            Expression::Load { pointer } => self.add_access(*pointer, Some(expression), READ, cost),
            Expression::Access { .. } | Expression::ArrayLength(_) => cost[INTEGERS] += 1,
            Expression::Unary { .. } | Expression::Select { .. } => self.add_arithmetic(expression, 1, cost),
            Expression::Binary { op, left, .. } => {
                let of = self.arithmetic(*left);
                let each = match op {
                    BinaryOperator::Divide | BinaryOperator::Modulo if of.is_float => LONG_FLOAT,
                    BinaryOperator::Divide | BinaryOperator::Modulo => INTEGER_DIVISION,
                    _ => 1,
                };
                // Either side may be a vector.
                let components = of.components.max(self.arithmetic(expression).components);
                cost[if of.is_float { FLOATS } else { INTEGERS }] += each * components;
            }
            Expression::Relational { argument, .. } => self.add_arithmetic(*argument, 1, cost),
            Expression::As { convert: Some(_), .. } => cost[INTEGERS] += self.arithmetic(expression).components,
            Expression::Math { fun, arg, .. } => self.add_arithmetic(*arg, operations(*fun), cost),
            _ => {}
        }
    }

    /// Adds the cost of a statement, without the blocks in it.
    pub(super) fn add_statement(&self, statement: &Statement, cost: &mut Cost) {
        match statement {
            Statement::If { .. } | Statement::Loop { .. } | Statement::Switch { .. } => cost[INTEGERS] += 1,
            Statement::Store { pointer, value } => self.add_access(*pointer, Some(*value), WRITTEN, cost),
            Statement::Atomic { pointer, .. } => self.add_access(*pointer, None, WRITTEN, cost),
            Statement::WorkGroupUniformLoad { .. } => cost[SHARED] += 1,
            _ => {}
        }
    }

    fn add_arithmetic(&self, expression: Handle<Expression>, each: u32, cost: &mut Cost) {
        let of = self.arithmetic(expression);
        cost[if of.is_float { FLOATS } else { INTEGERS }] += each * of.components;
    }

    /// Adds the cost of reading or writing `value`, or the four bytes of an atomic.
    fn add_access(
        &self,
        pointer: Handle<Expression>,
        value: Option<Handle<Expression>>,
        direction: usize,
        cost: &mut Cost,
    ) {
        let bytes = value.map_or(4, |value| self.inner(value).size(self.module.to_ctx()));
        match self.inner(pointer).pointer_space() {
            Some(AddressSpace::Storage { .. }) => {
                cost[ACCESSES] += bytes.div_ceil(16);
                cost[direction] += bytes;
            }
            Some(AddressSpace::WorkGroup) => cost[SHARED] += bytes.div_ceil(16),
            // The same for all invocations, from a constant cache.
            Some(AddressSpace::Uniform) => cost[INTEGERS] += 1,
            _ => {}
        }
    }

    fn inner(&self, expression: Handle<Expression>) -> &TypeInner {
        match &self.info[expression].ty {
            TypeResolution::Handle(ty) => &self.module.types[*ty].inner,
            TypeResolution::Value(inner) => inner,
        }
    }

    fn arithmetic(&self, expression: Handle<Expression>) -> Arithmetic {
        let (scalar, components) = match *self.inner(expression) {
            TypeInner::Scalar(scalar) => (scalar, 1),
            TypeInner::Vector { size, scalar } => (scalar, size as u32),
            TypeInner::Matrix { columns, rows, scalar } => (scalar, columns as u32 * rows as u32),
            _ => return Arithmetic { is_float: false, components: 0 },
        };
        Arithmetic { is_float: scalar.kind == ScalarKind::Float, components }
    }
}

/// Type of an operation.
struct Arithmetic {
    is_float: bool,
    components: u32,
}

/// Operations for each component of a function's first argument.
const fn operations(function: MathFunction) -> u32 {
    use MathFunction as Math;
    match function {
        Math::Clamp | Math::Dot | Math::Mix | Math::Fract | Math::Step => 2,
        Math::Cross | Math::Reflect | Math::SmoothStep | Math::Frexp | Math::Modf | Math::Ldexp => 3,
        Math::Length | Math::Distance | Math::Normalize => 2 + LONG_FLOAT / VectorSize::Tri as u32,
        Math::Sqrt
        | Math::InverseSqrt
        | Math::Sin
        | Math::Cos
        | Math::Tan
        | Math::Asin
        | Math::Acos
        | Math::Atan
        | Math::Exp
        | Math::Exp2
        | Math::Log
        | Math::Log2 => LONG_FLOAT,
        Math::Pow | Math::Atan2 | Math::Refract => 2 * LONG_FLOAT,
        _ => 1,
    }
}
