//! Rows whose cells say under which heading they stand, so that a narrow page can show each row as a card
//! (`style.css`): a phone has no room for twelve columns, and nobody scrolls sideways.

use maud::{Markup, PreEscaped, html};

/// Each cell of `rows` with its heading as `data-head`.
pub fn labelled(heads: &[&str], rows: &Markup) -> Markup {
    let mut text = String::with_capacity(2 * rows.0.len());
    let mut columns = Columns::default();
    let mut rest = rows.0.as_str();
    while let Some(at) = rest.find("<t") {
        let (before, tag) = rest.split_at(at);
        text.push_str(before);
        let end = tag.find('>').map_or(tag.len(), |end| end + 1);
        let (tag, after) = tag.split_at(end);
        rest = after;
        let is = |name: &str| tag.starts_with(name) && tag[name.len()..].starts_with([' ', '>']);
        if is("<tr") {
            columns.next_row();
        }
        if !is("<td") && !is("<th") {
            text.push_str(tag);
            continue;
        }
        let (own, wide) = columns.take(tag);
        // What spans columns is of none of them.
        let head = heads.get(own).filter(|_| wide == 1).map_or("", |head| head);
        let (name, attributes) = tag.split_at(3);
        text.push_str(name);
        if !head.is_empty() {
            let head = head.trim_start_matches('#').replace('|', " ");
            let escaped = html! { (head) }.into_string();
            text.push_str(&format!(" data-head=\"{escaped}\""));
        }
        text.push_str(attributes);
    }
    text.push_str(rest);
    PreEscaped(text)
}

/// Where the next cell stands, whatever spans rows and columns.
#[derive(Default)]
struct Columns {
    next: usize,
    /// Rows for which a cell above still takes a column.
    held: Vec<usize>,
}

impl Columns {
    fn next_row(&mut self) {
        self.next = 0;
    }

    /// The first column of a cell that begins with `tag`, and how many it takes.
    fn take(&mut self, tag: &str) -> (usize, usize) {
        while let Some(held) = self.held.get_mut(self.next).filter(|held| **held > 0) {
            *held -= 1;
            self.next += 1;
        }
        let (own, wide) = (self.next, number(tag, "colspan"));
        self.next += wide;
        self.held.resize(self.held.len().max(self.next), 0);
        self.held[own..self.next].fill(number(tag, "rowspan") - 1);
        (own, wide)
    }
}

/// What an attribute says, 1 where there is none.
fn number(tag: &str, attribute: &str) -> usize {
    let start = format!("{attribute}=\"");
    let text = tag.split_once(&start).map(|(_, text)| text);
    let text = text.and_then(|text| text.split_once('"'));
    text.and_then(|(n, _)| n.parse().ok()).unwrap_or(1).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_know_their_headings_whatever_spans() {
        let rows = html! {
            tr { td rowspan="2" { "a" } td.n { "1" } td { "x" } }
            tr { td colspan="2" { table { } } }
            tr { td { "b" } td { "2 < 3" } td { br; } }
        };
        let text = labelled(&["Name", "#Of|it", "Why \"so\""], &rows).into_string();
        let heads: Vec<&str> = text
            .split("data-head=\"")
            .skip(1)
            .map(|part| part.split('"').next().unwrap())
            .collect();
        let why = "Why &quot;so&quot;";
        assert_eq!(heads, ["Name", "Of it", why, "Name", "Of it", why]);
        assert!(text.contains("2 &lt; 3") && text.contains("<table></table>"));
    }
}
