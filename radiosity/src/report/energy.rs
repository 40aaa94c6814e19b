//! Energy balances on a page: bars, and a table of shares of the emitted power.

use super::document::{Blocks, Cell, Row, Table, Text, bold_text, colour_key, plain_text, stacked_bar};
use super::format::{format_number, format_percent};
use common::energy::EnergyBalance;

/// Destinations of emitted power: name, CSS colour.
const ENERGY_PARTS: [(&str, &str); 4] = [
    ("absorbed", "#3d6f9e"),
    ("unshot", "#a8842c"),
    ("escaped", "#6b6f75"),
    ("closure", "#7a5296"),
];
/// Emitted power in W above which the scene's unit is unlikely to be the metre.
const MAX_METRE_POWER: f64 = 1e4;

/// Adds balances (name, balance) as shares of emitted power, which are independent of the file's unit of length. A
/// single balance may have an empty name.
pub fn add_energy_balances(body: &mut Blocks, balances: &[(&str, &EnergyBalance)]) {
    let parts = |e: &EnergyBalance| [e.absorbed, e.unshot, e.escaped, e.closure];
    if let Some((_, e)) = balances.first() {
        body.add_paragraph(describe_emitted_power(e));
    }
    let bar = |e: &EnergyBalance| {
        let shares = parts(e).map(|power| e.share_of_emitted(power));
        let shown = ENERGY_PARTS.iter().zip(shares);
        stacked_bar(shown.map(|((name, colour), share)| (*colour, share, format!("{name} {}", format_percent(share)))))
    };
    body.add_table(Table::of_values(balances.iter().map(|(name, e)| (*name, bar(e)))));
    let keys = ENERGY_PARTS.iter().map(|(name, colour)| colour_key(colour, name));
    body.add_remark(keys.fold(plain_text(""), |line, key| line + key + " "));
    let channels = balances
        .iter()
        .flat_map(|(name, _)| ["R", "G", "B", "all"].map(|channel| (*name, channel)));
    let heads = channels.map(|(name, channel)| match name {
        "" => format!("#{channel}"),
        name => format!("#{name}|{channel}"),
    });
    let heads = ["Of what was emitted".to_owned()].into_iter().chain(heads);
    let share = |part: f64, whole: f64| match whole {
        0.0 => "–".to_owned(),
        whole => format_percent(part / whole),
    };
    let part_row = |k: usize| {
        let values = balances.iter().flat_map(|(_, e)| {
            let power = parts(e)[k];
            let [r, g, b] = [0, 1, 2].map(|c| share(power[c], e.emitted[c]));
            [r, g, b, format_percent(e.share_of_emitted(power))]
        });
        Row::new([ENERGY_PARTS[k].0.to_owned()].into_iter().chain(values))
    };
    let imbalances = balances.iter().map(|(_, e)| Cell {
        columns: 4,
        class: "n",
        ..format_percent(e.imbalance).into()
    });
    let imbalances = Row::new([Cell::from("imbalance")].into_iter().chain(imbalances));
    body.add_table(Table {
        heads: heads.collect(),
        rows: (0..ENERGY_PARTS.len()).map(part_row).chain([imbalances]).collect(),
        ..Table::default()
    });
    body.add_remark(
        bold_text("Absorbed")
            + " by surfaces; "
            + bold_text("unshot")
            + " at the end of the solve; "
            + bold_text("escaped")
            + " from the scene or behind a face; "
            + bold_text("closure")
            + " error of the form factors, whose sums are not 1; "
            + bold_text("imbalance")
            + ": the unexplained rest.",
    );
}

/// Describes the emitted power under the likely unit of length, which files do not state.
fn describe_emitted_power(e: &EnergyBalance) -> Text {
    let watts = |unit: f64| {
        let [r, g, b] = e.emitted.map(|power| format_number(power * unit * unit));
        format!("R {r}, G {g}, B {b} W")
    };
    if e.emitted.iter().sum::<f64>() > MAX_METRE_POWER {
        let metres = watts(1.0);
        return plain_text("Emitted: ")
            + bold_text(watts(1e-3))
            + format!(" if the file’s unit of length is the millimetre; {metres} if it is the metre.");
    }
    plain_text("Emitted: ") + bold_text(watts(1.0)) + " if the file’s unit of length is the metre."
}
