//! Section of a comparison's page: where the solvers part, and the share of each stage in the difference.

use crate::report::document::{Blocks, Row, Table, plain_text};
use crate::report::format::format_number;
use oracle::compare::parting::{ChainStep, FirstDivergence};

/// Adds the first divergence with both sides' numbers.
pub fn add_first_divergence(body: &mut Blocks, found: &FirstDivergence) {
    body.add_heading("First divergence").add_paragraph(found.headline());
    if let Some(parting) = found.parting.as_ref().filter(|parting| !parting.steps.is_empty()) {
        body.add_table(Table::new(
            "Quantity;#GPU;#CPU;Unit",
            parting.steps.iter().map(step_row),
        ));
        body.add_remark(
            "From the shooter to the texel. The CPU computes each quantity from the GPU\u{2019}s values of those above.",
        );
    }
    body.add_notes(found.remarks());
}

/// Returns a row of the chain; it is marked where the sides differ by more than rounding.
fn step_row(step: &ChainStep) -> Row {
    let [gpu, cpu] = [step.gpu, step.cpu].map(format_number);
    let cells = [
        plain_text(&step.quantity),
        plain_text(gpu),
        plain_text(cpu),
        plain_text(step.unit),
    ];
    Row::new(cells).with_class_if(step.differs, "bad")
}
