//! Energy balances on the pages of `compare`, `check` and `relight`: a table of shares of the emitted power.

use super::document::{Blocks, Cell, Row, Table, bold_text, plain_text};
use super::format::{format_number, format_percent};
use common::energy::EnergyBalance;

/// Destinations of emitted power, and what they are.
const ENERGY_PARTS: [(&str, &str); 4] = [
    ("absorbed", "by surfaces"),
    ("unshot", "at the end of the solve"),
    ("escaped", "from the scene or behind a face"),
    ("closure", "error of the form factors, whose sums are not 1"),
];
/// Adds balances (name, balance) as shares of emitted power, which are independent of the file's unit of length. A
/// single balance may have an empty name.
pub fn add_energy_balances(body: &mut Blocks, balances: &[(&str, &EnergyBalance)]) {
    let parts = |e: &EnergyBalance| [e.absorbed, e.unshot, e.escaped, e.closure];
    if let Some((_, e)) = balances.first() {
        let [r, g, b] = e.emitted.map(format_number);
        let emitted = bold_text(format!("R {r}, G {g}, B {b} W"));
        body.add_paragraph(plain_text("Emitted: ") + emitted + " if the file’s unit of length is the metre.");
    }
    let channels = balances
        .iter()
        .flat_map(|(name, _)| ["R", "G", "B", "all"].map(|channel| (*name, channel)));
    let heads = channels.map(|(name, channel)| match name {
        "" => format!("#{channel}"),
        name => format!("#{name}|{channel}"),
    });
    let first = "Of what was emitted".to_owned();
    let heads = [first].into_iter().chain(heads).chain(["~".to_owned()]);
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
        let [name, meaning] = <[&str; 2]>::from(ENERGY_PARTS[k]).map(str::to_owned);
        Row::new([name].into_iter().chain(values).chain([meaning]))
    };
    let imbalances = balances.iter().map(|(_, e)| Cell {
        columns: 4,
        class: "n",
        ..format_percent(e.imbalance).into()
    });
    let imbalances = [Cell::from("imbalance")].into_iter().chain(imbalances);
    let imbalances = Row::new(imbalances.chain(["the unexplained rest".into()]));
    body.add_table(Table {
        heads: heads.collect(),
        rows: (0..ENERGY_PARTS.len()).map(part_row).chain([imbalances]).collect(),
        ..Table::default()
    });
}
