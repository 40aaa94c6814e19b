//! Pages as data: text, tables, figures and plots, rendered to one HTML file that opens offline and fits any screen.

use super::format::format_percent;
use super::picture::DIVERGING_COLOURS;
use super::plot::{PLOT_STYLE, Plot};
use maud::{DOCTYPE, Markup, PreEscaped, Render, html};
use std::fmt::Display;
use std::ops::Add;

const PAGE_STYLE: &str = include_str!("style.css");
/// Maximum columns of a table that stays a table on a narrow screen.
const MAX_NARROW_COLUMNS: usize = 4;

/// Section of a page.
pub struct Section {
    /// Anchor.
    pub id: String,
    /// Heading.
    pub title: Text,
    /// Content.
    pub body: Blocks,
}

/// Renders a page as one self-contained file: heading, navigation bar, the blocks before the first section, and the
/// sections, each linked from the bar. `style` is a style sheet in addition to the common one.
pub fn render_document(title: &str, opening: &Blocks, sections: &[Section], style: &str) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (PreEscaped(PAGE_STYLE)) (PreEscaped(PLOT_STYLE)) (PreEscaped(style)) }
            }
            body {
                nav aria-label="Sections" {
                    a href="#top" { "Overview" }
                    @for section in sections { a href={ "#" (section.id) } { (section.title) } }
                }
                main {
                    header #top { h1 { (title) } }
                    (opening)
                    @for section in sections {
                        section id=(section.id) { h2 { (section.title) } (section.body) }
                    }
                }
            }
        }
    };
    // Names of files may have control characters, which HTML forbids.
    let is_control = |letter: char| letter.is_control() && !"\t\n\r".contains(letter);
    page.into_string().replace(is_control, "\u{fffd}")
}

/// Text of a line, escaped when it is made.
#[derive(Clone)]
pub struct Text(Markup);

impl<T: Display> From<T> for Text {
    fn from(text: T) -> Self {
        Self(html! { (text.to_string()) })
    }
}

impl<T: Into<Text>> Add<T> for Text {
    type Output = Self;

    fn add(mut self, more: T) -> Self {
        self.0.0 += &more.into().0.0;
        self
    }
}

impl Render for Text {
    fn render(&self) -> Markup {
        self.0.clone()
    }
}

/// Returns unstyled text, to begin a line.
pub fn plain_text(text: impl Into<Text>) -> Text {
    text.into()
}

/// Returns bold text.
pub fn bold_text(text: impl Into<Text>) -> Text {
    Text(html! { b { (text.into()) } })
}

/// Returns text in the type of commands and file names.
pub fn code_text(text: impl Into<Text>) -> Text {
    Text(html! { code { (text.into()) } })
}

/// Returns text of a class of the style sheet: cpu, gpu, pass, fail, facts, ….
pub fn styled_text(class: &str, text: impl Into<Text>) -> Text {
    Text(html! { span class=(class) { (text.into()) } })
}

/// Returns a link to the anchor `id`.
pub fn link_text(id: impl Display, text: impl Into<Text>) -> Text {
    Text(html! { a href=(format!("#{id}")) { (text.into()) } })
}

/// Returns a line break.
pub fn line_break() -> Text {
    Text(html! { br; })
}

/// Returns ✓ or ✗.
pub fn pass_mark(pass: bool) -> Text {
    let (class, title, sign) = match pass {
        true => ("pass", "holds", "✓"),
        false => ("fail", "does not hold", "✗"),
    };
    Text(html! { span class=(class) title=(title) { (sign) } })
}

/// Returns the diverging colour scale from −range to +range.
pub fn colour_bar(range: f64) -> Text {
    let stops = DIVERGING_COLOURS.map(|[r, g, b]| format!("rgb({r} {g} {b})"));
    Text(html! { span.scale {
        span { "−" (format_percent(range)) }
        span.ramp style=(format!("background:linear-gradient(to right,{})", stops.join(","))) {}
        span { "+" (format_percent(range)) }
    } })
}

/// Sequence of paragraphs, tables and figures.
#[derive(Default)]
pub struct Blocks(Vec<Markup>);

impl Render for Blocks {
    fn render(&self) -> Markup {
        html! { @for block in &self.0 { (block) } }
    }
}

/// Tone of a verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VerdictTone {
    /// All is well.
    Good,
    /// A failure.
    Bad,
    /// No failure, but it needs attention.
    Careful,
    /// No judgement.
    Neutral,
}

impl Blocks {
    /// Makes a section of these blocks.
    pub fn into_section(self, id: impl Into<String>, title: impl Into<Text>) -> Section {
        Section {
            id: id.into(),
            title: title.into(),
            body: self,
        }
    }

    /// Adds an element made elsewhere, such as a viewer.
    pub fn add_element(&mut self, element: Markup) -> &mut Self {
        self.0.push(element);
        self
    }

    /// Adds a heading below that of the section.
    pub fn add_heading(&mut self, text: impl Into<Text>) -> &mut Self {
        self.add_element(html! { h3 { (text.into()) } })
    }

    /// Adds a paragraph.
    pub fn add_paragraph(&mut self, text: impl Into<Text>) -> &mut Self {
        self.add_element(html! { p { (text.into()) } })
    }

    /// Adds a paragraph in small, grey type.
    pub fn add_remark(&mut self, text: impl Into<Text>) -> &mut Self {
        self.add_element(html! { p.small { (text.into()) } })
    }

    /// Adds a paragraph that calls for attention.
    pub fn add_warning(&mut self, text: impl Into<Text>) -> &mut Self {
        self.add_element(html! { p.warning { (text.into()) } })
    }

    /// Adds a verdict: a word in large type and what it says.
    pub fn add_verdict(&mut self, tone: VerdictTone, word: &str, text: impl Into<Text>) -> &mut Self {
        let class = match tone {
            VerdictTone::Good => "verdict agree",
            VerdictTone::Bad => "verdict disagree",
            VerdictTone::Careful => "verdict careful",
            VerdictTone::Neutral => "verdict",
        };
        self.add_element(html! { p class=(class) { strong { (word) } " " (text.into()) } })
    }

    /// Adds framed notes, one per line; nothing without notes.
    pub fn add_notes(&mut self, lines: impl IntoIterator<Item = impl Into<Text>>) -> &mut Self {
        let mut lines = lines.into_iter().peekable();
        match lines.peek() {
            Some(_) => self.add_element(html! { div.notes { @for line in lines { p { (line.into()) } } } }),
            None => self,
        }
    }

    /// Adds blocks that the reader unfolds.
    pub fn add_details(&mut self, summary: impl Into<Text>, is_open: bool, body: Blocks) -> &mut Self {
        self.add_element(html! { details open[is_open] { summary { (summary.into()) } (body) } })
    }

    /// Adds a table.
    pub fn add_table(&mut self, table: Table) -> &mut Self {
        self.add_element(table.render())
    }

    /// Adds a figure of the page's width.
    pub fn add_figure(&mut self, figure: &Figure) -> &mut Self {
        self.add_element(figure.render_with_class("wide"))
    }

    /// Adds figures side by side, as many in a row as fit.
    pub fn add_figures(&mut self, figures: &[Figure]) -> &mut Self {
        self.add_element(html! { div.grid { @for figure in figures { (figure) } } })
    }

    /// Adds figures in one row, on a narrow screen below each other.
    pub fn add_figure_row(&mut self, figures: &[Figure]) -> &mut Self {
        let columns = format!("--columns:{}", figures.len());
        self.add_element(html! { div.row style=(columns) { @for figure in figures { (figure) } } })
    }
}

/// Picture or plot with its caption.
pub struct Figure {
    content: Markup,
    caption: Text,
}

impl Figure {
    fn new(content: Markup, caption: impl Into<Text>) -> Self {
        Self {
            content,
            caption: caption.into(),
        }
    }

    /// Creates a figure of a picture; without a `source` it says that there is none.
    pub fn from_picture(source: &str, alt: &str, caption: impl Into<Text>) -> Self {
        let content = html! {
            @if source.is_empty() { p.none { "no picture" } } @else { img src=(PreEscaped(source)) alt=(alt); }
        };
        Self::new(content, caption)
    }

    /// Creates a figure of a plot, or of the text `otherwise` if there is nothing to draw.
    pub fn from_plot(plot: &Plot, otherwise: &str, caption: impl Into<Text>) -> Self {
        let content =
            html! { @match plot.render_svg() { Some(svg) => (PreEscaped(svg)), None => p.none { (otherwise) } } };
        Self::new(content, caption)
    }

    fn render_with_class(&self, class: &str) -> Markup {
        html! { figure class=[nonempty_attribute(class)] { (self.content) figcaption { (self.caption) } } }
    }
}

impl Render for Figure {
    fn render(&self) -> Markup {
        self.render_with_class("")
    }
}

/// Table. It scrolls by itself; with more than four columns it becomes one card per row on a narrow screen, and each
/// cell shows its heading.
#[derive(Default)]
pub struct Table {
    /// Classes of the style sheet.
    pub class: &'static str,
    /// Headings: one that begins with # stands over numbers, with ~ over long text; | separates its lines.
    pub heads: Vec<String>,
    /// Rows.
    pub rows: Vec<Row>,
}

/// Row of a table.
pub struct Row {
    class: &'static str,
    cells: Vec<Cell>,
}

/// Cell of a table.
pub struct Cell {
    /// Content.
    pub content: Text,
    /// Class of the style sheet.
    pub class: &'static str,
    /// Columns that it covers; a cell of several belongs to no heading.
    pub columns: usize,
}

impl<T: Into<Text>> From<T> for Cell {
    fn from(content: T) -> Self {
        Self {
            content: content.into(),
            class: "",
            columns: 1,
        }
    }
}

impl Row {
    /// Creates a row.
    pub fn new(cells: impl IntoIterator<Item = impl Into<Cell>>) -> Self {
        Self {
            class: "",
            cells: cells.into_iter().map(Into::into).collect(),
        }
    }

    /// Sets the class if `condition` holds.
    pub fn with_class_if(self, condition: bool, class: &'static str) -> Self {
        Self {
            class: if condition { class } else { self.class },
            ..self
        }
    }
}

impl Table {
    /// Creates a table; semicolons separate its headings (see [`Table::heads`]).
    pub fn new(heads: &str, rows: impl IntoIterator<Item = Row>) -> Self {
        Self {
            heads: heads.split_terminator(';').map(str::to_owned).collect(),
            rows: rows.into_iter().collect(),
            ..Self::default()
        }
    }

    /// Creates a table of names and values.
    pub fn of_values(rows: impl IntoIterator<Item = (impl Into<Cell>, impl Into<Cell>)>) -> Self {
        let rows = rows
            .into_iter()
            .map(|(name, value)| Row::new([name.into(), value.into()]));
        Self::new("", rows)
    }

    /// Renders a row; each cell of a card is labelled with its heading.
    fn render_row(&self, row: &Row, has_cards: bool) -> Markup {
        let starts = row.cells.iter().scan(0, |next, cell| {
            *next += cell.columns;
            Some(*next - cell.columns)
        });
        html! { tr class=[nonempty_attribute(row.class)] { @for (cell, start) in row.cells.iter().zip(starts) {
            @let head = self.heads.get(start).filter(|_| cell.columns == 1);
            @let class = [head.map_or("", |head| column_class(head)), cell.class].join(" ");
            @let label = head.filter(|_| has_cards).map(|head| head.trim_start_matches(['#', '~']).replace('|', " "));
            @let span = (cell.columns > 1).then_some(cell.columns);
            td data-head=[label.filter(|label| !label.is_empty())] class=[nonempty_attribute(class.trim())] colspan=[span] {
                (cell.content)
            }
        } } }
    }
}

impl Render for Table {
    fn render(&self) -> Markup {
        let has_cards = self.heads.len() > MAX_NARROW_COLUMNS;
        let class = [self.class, if has_cards { "cards" } else { "" }].join(" ");
        html! { div.scroll { table class=[nonempty_attribute(class.trim())] {
            @if !self.heads.is_empty() { thead {
                tr { @for head in &self.heads {
                    th class=[nonempty_attribute(column_class(head)).filter(|class| *class == "n")] {
                        @for (k, line) in head.trim_start_matches(['#', '~']).split('|').enumerate() {
                            @if k > 0 { br; } (line)
                        }
                    }
                } }
            } }
            tbody { @for row in &self.rows { (self.render_row(row, has_cards)) } }
        } } }
    }
}

/// Returns the class of the cells under a heading.
fn column_class(head: &str) -> &'static str {
    match head.chars().next() {
        Some('#') => "n",
        Some('~') => "reason",
        _ => "",
    }
}

/// Returns the value of an attribute, none if it is empty.
fn nonempty_attribute(value: &str) -> Option<&str> {
    Some(value).filter(|value| !value.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn card_cells_carry_their_headings_except_spanning_cells() {
        let wide = Cell {
            columns: 2,
            ..Cell::from("b")
        };
        let rows = [
            Row::new(["a", "1", "x", "", ""]),
            Row::new([wide, "2 < 3".into()]).with_class_if(true, "bad"),
        ];
        let text = Table::new("Name;#Of|it;~Why \"so\";;End", rows).render().into_string();
        let labels = text
            .split("data-head=\"")
            .skip(1)
            .filter_map(|part| part.split('"').next());
        let why = "Why &quot;so&quot;";
        let expected = ["Name", "Of it", why, "End", why];
        assert_eq!(labels.collect::<Vec<_>>(), expected);
        assert!(text.contains("2 &lt; 3") && text.contains("<tr class=\"bad\">") && text.contains("colspan=\"2\""));
        assert!(text.contains("<td data-head=\"Of it\" class=\"n\">1<") && text.contains("class=\"reason\">x<"));
        let narrow = Table::new("Name;#Of|it;~Why;Last", [Row::new(["a", "1"])]);
        assert!(!narrow.render().into_string().contains("data-head"));
    }

    #[test]
    fn text_is_escaped_wherever_it_comes_from() {
        let bad = "<b>&\"";
        let mut body = Blocks::default();
        body.add_paragraph(plain_text(bad) + bold_text(bad) + styled_text("pass", bad))
            .add_notes([bad])
            .add_verdict(VerdictTone::Good, bad, bad)
            .add_figure(&Figure::from_picture("data:", bad, bad))
            .add_table(Table::of_values([(bad, bad)]));
        let page = render_document(bad, &Blocks::default(), &[body.into_section("part", bad)], "");
        assert!(!page.contains(bad));
        assert!(page.contains("<a href=\"#part\">&lt;b&gt;&amp;&quot;</a>"));
    }
}
