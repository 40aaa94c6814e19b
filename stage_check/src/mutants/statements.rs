//! Mutations of statements.

use super::{MutationOperator, SiteFinder};
use crate::tokens::{find_condition, find_operator};
use std::ops::Range;
use wgpu::naga::{Block, Expression, Handle, Span, Statement, UnaryOperator};

impl SiteFinder<'_> {
    /// Adds the mutations of the statements of a block. naga stores the operands of `&&` and `||` by statements of the
    /// span of the whole expression, `operands`: these are none of the text's.
    pub(super) fn visit_block(&mut self, block: &Block, operands: Option<Span>) {
        for (statement, span) in block.span_iter() {
            let Some(range) = self.trim(*span) else {
                continue;
            };
            match statement {
                Statement::Block(inner) => self.visit_block(inner, None),
                Statement::If {
                    condition,
                    accept,
                    reject,
                } => match stores_operand(accept, *span) {
                    true => {
                        self.visit_logic(*condition, range);
                        self.visit_block(accept, Some(*span));
                    }
                    false => {
                        self.visit_condition(*condition, range, [accept, reject]);
                        self.visit_block(accept, None);
                        self.visit_block(reject, None);
                    }
                },
                Statement::Switch { cases, .. } => cases.iter().for_each(|case| self.visit_block(&case.body, None)),
                Statement::Loop { body, continuing, .. } => {
                    self.visit_block(body, None);
                    self.visit_block(continuing, None);
                }
                Statement::ControlBarrier(_) | Statement::MemoryBarrier(_) => {
                    self.add(MutationOperator::Barrier, range, "");
                }
                Statement::Store { .. } if operands != Some(*span) => self.remove_statement(range),
                Statement::Call {
                    arguments,
                    result: None,
                    ..
                } => {
                    self.swap_arguments(&range, arguments);
                    self.remove_statement(range);
                }
                Statement::Call { arguments, .. } => self.swap_arguments(&range, arguments),
                Statement::ImageStore { .. } | Statement::Atomic { result: None, .. } => self.remove_statement(range),
                _ => {}
            }
        }
    }

    /// Replaces `&&` by `||` and the other way round; parentheses keep the mutant within the grammar.
    fn visit_logic(&mut self, condition: Handle<Expression>, range: Range<usize>) {
        let expressions = &self.function.expressions;
        let is_or = match expressions[condition] {
            Expression::Unary {
                op: UnaryOperator::LogicalNot,
                ..
            } => self.trim(expressions.get_span(condition)) == Some(range.clone()),
            _ => false,
        };
        let (sign, other) = if is_or { ("||", "&&") } else { ("&&", "||") };
        let text = self.text_at(&range);
        if let Some(at) = find_operator(text, sign) {
            let (left, right) = (text[..at.start].trim(), text[at.end..].trim());
            self.add(MutationOperator::Logic, range, format!("(({left}) {other} ({right}))"));
        }
    }

    /// Negates the condition of an `if` or of a loop; drops that of an `if` which leaves the block.
    fn visit_condition(
        &mut self,
        condition: Handle<Expression>,
        statement: Range<usize>,
        [accept, reject]: [&Block; 2],
    ) {
        let of_if = find_condition(self.text_at(&statement));
        let range = match of_if {
            Some(at) => Some(statement.start + at.start..statement.start + at.end),
            None => self.range_of(condition),
        };
        let Some(range) = range else {
            return;
        };
        let leaves = matches!(
            accept.last(),
            Some(Statement::Return { .. } | Statement::Continue | Statement::Break)
        );
        if leaves && reject.is_empty() {
            self.add(MutationOperator::Guard, range.clone(), "false");
        }
        let text = self.text_at(&range);
        self.add(MutationOperator::Condition, range, format!("!({text})"));
    }

    /// Removes a statement that declares nothing.
    fn remove_statement(&mut self, range: Range<usize>) {
        let text = self.text_at(&range);
        let is_declaration = ["var ", "let ", "const "].iter().any(|word| text.starts_with(word));
        if !is_declaration {
            self.add(
                MutationOperator::Statement,
                range,
                if text.ends_with(';') { ";" } else { "" },
            );
        }
    }
}

/// Returns whether the last statement of a block stores an operand: its span is that of the whole expression.
fn stores_operand(block: &Block, span: Span) -> bool {
    let last = block.span_iter().last();
    matches!(last, Some((Statement::Store { .. }, stored)) if *stored == span)
}
