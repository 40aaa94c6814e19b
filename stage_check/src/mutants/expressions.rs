//! Mutations of expressions.

use super::{MutationOperator, SiteFinder};
use crate::tokens::{find_arguments, find_index, find_operator};
use std::ops::Range;
use wgpu::naga::{BinaryOperator, Expression, Handle, Literal, MathFunction, Scalar, TypeInner, UnaryOperator};

/// Letters of the components of a vector.
const COMPONENT_LETTERS: [&str; 2] = ["xyzw", "rgba"];

impl SiteFinder<'_> {
    /// Adds the mutations of all expressions.
    pub(super) fn visit_expressions(&mut self) {
        let function = self.function;
        for (handle, expression) in function.expressions.iter() {
            let Some(range) = self.range_of(handle) else {
                continue;
            };
            match expression {
                Expression::Literal(value) => self.visit_literal(range, value),
                Expression::Binary { op, .. } => self.visit_binary(*op, &range),
                Expression::Unary { op, .. } => self.visit_unary(*op, range),
                Expression::Access { .. } => self.visit_index(&range),
                Expression::AccessIndex { base, .. } => {
                    self.visit_index(&range);
                    self.visit_component(*base, &range);
                }
                Expression::Constant(constant) => {
                    let inner = &self.module.types[self.module.constants[*constant].ty].inner;
                    self.visit_constant(range, inner);
                }
                Expression::Swizzle { .. } => self.visit_swizzle(&range),
                Expression::Select {
                    accept,
                    reject,
                    condition,
                } => self.swap_arguments(&range, &[*reject, *accept, *condition]),
                Expression::Compose { components, .. } => self.swap_arguments(&range, components),
                Expression::Math {
                    fun, arg, arg1, arg2, ..
                } => {
                    let arguments: Vec<_> = [Some(*arg), *arg1, *arg2].into_iter().flatten().collect();
                    self.visit_call(*fun, range, &arguments);
                }
                _ => {}
            }
        }
    }

    fn visit_literal(&mut self, range: Range<usize>, value: &Literal) {
        let text = self.text_at(&range);
        let number = text.trim_end_matches(['u', 'i', 'f', 'h']);
        let suffix = &text[number.len()..];
        match value {
            Literal::F32(_) | Literal::AbstractFloat(_) => {
                let Ok(value) = number.parse::<f32>() else {
                    return;
                };
                let other = if value == 0.0 { 1.0 } else { 2.0 * value };
                self.add(MutationOperator::Constant, range, format!("{other:?}{suffix}"));
            }
            Literal::Bool(value) if ["true", "false"].contains(&text) => {
                self.add(MutationOperator::Constant, range, (!value).to_string());
            }
            _ => {
                let Ok(value) = number.parse::<i64>() else {
                    return;
                };
                self.add(MutationOperator::Constant, range, format!("{}{suffix}", value + 1));
            }
        }
    }

    fn visit_constant(&mut self, range: Range<usize>, inner: &TypeInner) {
        let name = self.text_at(&range);
        let other = match inner {
            TypeInner::Scalar(Scalar::F32) => format!("(2.0 * {name})"),
            TypeInner::Scalar(Scalar::U32 | Scalar::I32) => format!("({name} + 1)"),
            _ => return,
        };
        self.add(MutationOperator::Constant, range, other);
    }

    fn visit_binary(&mut self, op: BinaryOperator, range: &Range<usize>) {
        use MutationOperator::{Arithmetic, Comparison};
        let (kind, sign, others): (_, _, &[&str]) = match op {
            BinaryOperator::Add => (Arithmetic, "+", &["-"]),
            BinaryOperator::Subtract => (Arithmetic, "-", &["+"]),
            BinaryOperator::Multiply => (Arithmetic, "*", &["/"]),
            BinaryOperator::Divide => (Arithmetic, "/", &["*"]),
            BinaryOperator::Modulo => (Arithmetic, "%", &["*"]),
            BinaryOperator::And => (Arithmetic, "&", &["|"]),
            BinaryOperator::InclusiveOr => (Arithmetic, "|", &["&"]),
            BinaryOperator::ExclusiveOr => (Arithmetic, "^", &["&"]),
            BinaryOperator::ShiftLeft => (Arithmetic, "<<", &[">>"]),
            BinaryOperator::ShiftRight => (Arithmetic, ">>", &["<<"]),
            BinaryOperator::Equal => (Comparison, "==", &["!="]),
            BinaryOperator::NotEqual => (Comparison, "!=", &["=="]),
            BinaryOperator::Less => (Comparison, "<", &["<=", ">"]),
            BinaryOperator::LessEqual => (Comparison, "<=", &["<", ">="]),
            BinaryOperator::Greater => (Comparison, ">", &[">=", "<"]),
            BinaryOperator::GreaterEqual => (Comparison, ">=", &[">", "<="]),
            BinaryOperator::LogicalAnd | BinaryOperator::LogicalOr => return,
        };
        if let Some(at) = find_operator(self.text_at(range), sign) {
            let at = range.start + at.start..range.start + at.end;
            for other in others {
                self.add(kind, at.clone(), *other);
            }
        }
    }

    fn visit_unary(&mut self, op: UnaryOperator, range: Range<usize>) {
        let (kind, sign) = match op {
            UnaryOperator::Negate => (MutationOperator::Sign, "-"),
            UnaryOperator::LogicalNot => (MutationOperator::Condition, "!"),
            UnaryOperator::BitwiseNot => (MutationOperator::Arithmetic, "~"),
        };
        if self.text_at(&range).starts_with(sign) {
            self.add(kind, range.start..range.start + sign.len(), "");
        }
    }

    fn visit_index(&mut self, range: &Range<usize>) {
        if let Some(at) = find_index(self.text_at(range)) {
            let at = range.start + at.start..range.start + at.end;
            let text = self.text_at(&at);
            match text.trim_end_matches(['u', 'i']).parse::<u32>() {
                Ok(0) => self.add(MutationOperator::Index, at, "1"),
                Ok(number) => {
                    self.add(MutationOperator::Index, at.clone(), (number - 1).to_string());
                    self.add(MutationOperator::Index, at, number.saturating_add(1).to_string());
                }
                Err(_) => {
                    self.add(MutationOperator::Index, at.clone(), format!("({text}) + 1"));
                    self.add(MutationOperator::Index, at, format!("({text}) - 1"));
                }
            }
        }
    }

    /// Takes the next component of a vector.
    fn visit_component(&mut self, base: Handle<Expression>, range: &Range<usize>) {
        let types = &self.module.types;
        let size = match self.info[base].ty.inner_with(types) {
            TypeInner::Vector { size, .. } | TypeInner::ValuePointer { size: Some(size), .. } => *size,
            TypeInner::Pointer { base, .. } => match types[*base].inner {
                TypeInner::Vector { size, .. } => size,
                _ => return,
            },
            _ => return,
        };
        let Some((_, component)) = self.text_at(range).rsplit_once('.') else {
            return;
        };
        for letters in COMPONENT_LETTERS {
            if let Some(at) = letters.find(component)
                && component.len() == 1
            {
                let next = (at + 1) % size as usize;
                let place = range.end - 1..range.end;
                self.add(MutationOperator::Swizzle, place, &letters[next..=next]);
            }
        }
    }

    /// Rotates the letters of a swizzle.
    fn visit_swizzle(&mut self, range: &Range<usize>) {
        if let Some((_, letters)) = self.text_at(range).rsplit_once('.')
            && letters.is_ascii()
            && letters.len() > 1
        {
            let rotated = format!("{}{}", &letters[1..], &letters[..1]);
            self.add(MutationOperator::Swizzle, range.end - letters.len()..range.end, rotated);
        }
    }

    /// Drops a function that limits its argument, or swaps the arguments of another.
    fn visit_call(&mut self, fun: MathFunction, range: Range<usize>, arguments: &[Handle<Expression>]) {
        let kept = match fun {
            MathFunction::Min | MathFunction::Max => 2,
            MathFunction::Clamp | MathFunction::Saturate | MathFunction::Abs => 1,
            MathFunction::Pow | MathFunction::Atan2 | MathFunction::Step | MathFunction::Mix | MathFunction::Cross => {
                return self.swap_arguments(&range, arguments);
            }
            _ => return,
        };
        let call = self.text_at(&range);
        for (at, argument) in find_arguments(call).into_iter().zip(arguments).take(kept) {
            let expression = &self.function.expressions[*argument];
            if !matches!(expression, Expression::Literal(_) | Expression::Splat { .. }) {
                self.add(MutationOperator::Clamp, range.clone(), format!("({})", &call[at]));
            }
        }
    }
}
