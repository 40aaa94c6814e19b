//! Tables of a page: rows and cells as data, rendered as a table or, on a narrow screen, as one card per row.
//!
//! A card shows each value with its heading, which the renderer writes into the cell (`data-head`, see `style.css`).

use maud::{Markup, Render, html};

/// Class of tables that become cards on a narrow screen.
const CARDS_CLASS: &str = "cards";
/// Maximum columns of a table that stays a table on a narrow screen.
const MAX_NARROW_COLUMNS: usize = 4;

/// Cell of a table.
pub struct TableCell {
    content: Markup,
    class: Option<&'static str>,
    title: Option<String>,
    columns: usize,
    is_heading: bool,
}

/// Creates a cell of text.
pub fn text_cell(content: impl Render) -> TableCell {
    TableCell {
        content: content.render(),
        class: None,
        title: None,
        columns: 1,
        is_heading: false,
    }
}

/// Creates a cell of a right-aligned number.
pub fn number_cell(content: impl Render) -> TableCell {
    text_cell(content).with_class("n")
}

impl TableCell {
    /// Sets the class.
    pub fn with_class(self, class: &'static str) -> Self {
        Self {
            class: Some(class),
            ..self
        }
    }

    /// Sets the tooltip.
    pub fn with_title(self, title: impl ToString) -> Self {
        Self {
            title: Some(title.to_string()),
            ..self
        }
    }

    /// Extends the cell over `columns` columns; such a cell belongs to no heading.
    pub fn with_column_span(self, columns: usize) -> Self {
        Self { columns, ..self }
    }

    /// Makes the cell a heading of its row.
    pub fn as_heading(self) -> Self {
        Self {
            is_heading: true,
            ..self
        }
    }

    fn render_under(&self, heading: Option<&str>) -> Markup {
        let span = (self.columns > 1).then_some(self.columns);
        let (class, title) = (self.class, self.title.as_deref());
        html! {
            @if self.is_heading {
                th data-head=[heading] class=[class] title=[title] colspan=[span] { (self.content) }
            } @else {
                td data-head=[heading] class=[class] title=[title] colspan=[span] { (self.content) }
            }
        }
    }
}

/// Row of a table.
pub struct TableRow {
    class: Option<&'static str>,
    cells: Vec<TableCell>,
}

impl TableRow {
    /// Creates a row.
    pub fn new(cells: impl IntoIterator<Item = TableCell>) -> Self {
        Self {
            class: None,
            cells: cells.into_iter().collect(),
        }
    }

    /// Sets the class if `condition` holds.
    pub fn with_class_if(self, condition: bool, class: &'static str) -> Self {
        Self {
            class: condition.then_some(class),
            ..self
        }
    }

    /// Renders the row; each cell of a card is labelled with its column's heading.
    fn render_under(&self, headings: &[String]) -> Markup {
        let starts = self.cells.iter().scan(0, |next, cell| {
            let start = *next;
            *next += cell.columns;
            Some(start)
        });
        html! {
            tr class=[self.class] {
                @for (cell, start) in self.cells.iter().zip(starts) {
                    @let heading = headings.get(start).filter(|head| cell.columns == 1 && !head.is_empty());
                    (cell.render_under(heading.map(String::as_str)))
                }
            }
        }
    }
}

/// Renders a table that scrolls by itself. With more than four columns, or of class `cards`, it becomes one card per
/// row on a narrow screen. A heading that begins with # stands over numbers; its lines are separated by |.
pub fn render_table(class: &str, heads: &[&str], rows: impl IntoIterator<Item = TableRow>) -> Markup {
    let has_cards = class == CARDS_CLASS || heads.len() > MAX_NARROW_COLUMNS;
    let classes = [
        class,
        if has_cards && class != CARDS_CLASS {
            CARDS_CLASS
        } else {
            ""
        },
    ]
    .join(" ");
    let classes = classes.trim();
    let label = |head: &&str| head.trim_start_matches('#').replace('|', " ");
    let labels: Vec<String> = match has_cards {
        true => heads.iter().map(label).collect(),
        false => Vec::new(),
    };
    html! {
        div.scroll { table class=[(!classes.is_empty()).then_some(classes)] {
            @if !heads.is_empty() { thead { tr { @for text in heads { (render_head_cell(text)) } } } }
            tbody { @for row in rows { (row.render_under(&labels)) } }
        } }
    }
}

fn render_head_cell(text: &str) -> Markup {
    let name = text.trim_start_matches('#');
    html! {
        th.n[name.len() < text.len()] {
            @for (k, line) in name.split('|').enumerate() { @if k > 0 { br; } (line) }
        }
    }
}

/// Renders a table of names and values.
pub fn render_name_value_table<K: Render, V: Render>(rows: impl IntoIterator<Item = (K, V)>) -> Markup {
    let rows = rows.into_iter();
    render_table(
        "",
        &[],
        rows.map(|(name, value)| TableRow::new([text_cell(name), number_cell(value)])),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn card_cells_carry_their_headings_except_spanning_cells() {
        let rows = [
            TableRow::new([text_cell("a"), number_cell(1), text_cell("x")]),
            TableRow::new([text_cell("b").with_column_span(2), text_cell("2 < 3")]).with_class_if(true, "bad"),
            TableRow::new([text_cell("c").as_heading(), text_cell(html! { br; })]),
        ];
        let heads = ["Name", "#Of|it", "Why \"so\""];
        let text = render_table("cards", &heads, rows).into_string();
        let labels: Vec<&str> = text
            .split("data-head=\"")
            .skip(1)
            .filter_map(|part| part.split('"').next())
            .collect();
        let why = "Why &quot;so&quot;";
        assert_eq!(labels, ["Name", "Of it", why, why, "Name", "Of it"]);
        assert!(text.contains("2 &lt; 3") && text.contains("<tr class=\"bad\">") && text.contains("colspan=\"2\""));
    }

    #[test]
    fn narrow_table_has_no_labels() {
        let text = render_table(
            "",
            &["Name", "#Value"],
            [TableRow::new([text_cell("a"), number_cell(1)])],
        );
        assert!(!text.into_string().contains("data-head"));
    }
}
