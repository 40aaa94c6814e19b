//! `table4.html`: the table, and the paper's Figures 8, 9 and 10 again.

use super::{Figure, Image, Row, Shown, Table};
use crate::show::number::{count, duration, percent};
use crate::show::page::{self, Page, figure};
use maud::{Markup, html};

const STYLE: &str = "\
    .row{display:grid;grid-template-columns:repeat(var(--columns),minmax(0,30rem));gap:1.2rem}\
    tr.group th{text-align:left;padding-top:.9rem}\
    @media (max-width:45rem){.row{grid-template-columns:minmax(0,1fr)}}";

/// The page.
pub fn html(table: &Table) -> String {
    let links = html! {
        a href="#top" { "Table 4" }
        a href="#figure9" { "Figure 9" }
        @for (k, f) in table.figures.iter().enumerate() { a href=(format!("#f{k}")) { (f.title) } }
    };
    let body = html! {
        p.facts {
            (count(table.faces[0] as u64)) " faces, " (count(table.faces[1] as u64))
            " of them the objects · " (table.adapter)
        }
        p {
            "As the paper did it: whole faces shoot, an orthographic item buffer is looked up in one pixel "
            "per texel, and shooting ends when 5 % is unshot. The room was captured by solving it empty. "
            "Error is relative RMS of B − E: against everything solved again on the same item "
            "buffers, and against the same by rays."
        }
        p {
            "The paper prints neither its room nor where it stops, so both were chosen: unit walls of 5×5 "
            "faces, one red and one green; sizes and places of the lamp box and of the two blocks; the "
            "reflectances, 0.7 where white, and 5 % unshot, such that the reference takes about the "
            "paper's 322 shots (reflectances of 0.5, 0.6 and 0.9 would take 180, 244 and 726; 1 % "
            "unshot with 0.5 fits as well). That these shot counts agree therefore confirms nothing; "
            "how errors and shots of the methods compare does not depend on it."
        }
        (below_zero(table))
        h2 { "The paper's rows" }
        (page::table("", &PRINTED, html! {
            @for (row, (seconds, shots)) in printed(table) { (printed_line(row, seconds, shots)) }
        }))
        h2 { "All images" }
        (page::table("", &HEADS, html! { @for cell in cells(table) {
            tr.group { th colspan=(HEADS.len()) {
                (cell[0].texels) "² texels a face, item buffers of " (cell[0].item_buffer) "² pixels"
            } }
            @for row in cell { (line(row)) }
        } }))
        (figure9(table))
        @for (k, f) in table.figures.iter().enumerate() { (pictures(k, f)) }
    };
    Page {
        title: "Radiosity: the paper's Table 4, repeated",
        bar: ("Parts", links),
        verdict: html! {},
        style: STYLE,
        body,
    }
    .html()
}

const PRINTED: [&str; 9] = [
    "Image",
    "#Texels",
    "#Item buffer",
    "#Shots",
    "#the paper's",
    "#Time",
    "#the paper's, 2006",
    "#Error",
    "#against rays",
];
const HEADS: [&str; 8] = [
    "Image",
    "#Shots",
    "#Map + object",
    "#Time",
    "#Error",
    "#against rays",
    "#Power missed",
    "#Texels < 0",
];

/// What the paper prints, in its order: images down, texels and item buffers rising.
fn printed(table: &Table) -> Vec<(&Row, (f64, u32))> {
    let rows = table.rows.iter();
    let mut all: Vec<_> = rows.filter_map(|row| Some((row, row.paper?))).collect();
    all.sort_by_key(|(row, _)| (row.image != Image::Reference, row.texels, row.item_buffer));
    all
}

/// Rows on the same texels and item buffer.
fn cells(table: &Table) -> impl Iterator<Item = &[Row]> {
    let same = |a: &Row, b: &Row| (a.texels, a.item_buffer) == (b.texels, b.item_buffer);
    table.rows.chunk_by(same)
}

/// Negative light is no light: which images hold some is said before they are shown.
fn below_zero(table: &Table) -> Markup {
    let mut names: Vec<&str> = Vec::new();
    for row in table.rows.iter().filter(|row| row.negative_texels > 0) {
        if !names.contains(&row.image.name()) {
            names.push(row.image.name());
        }
    }
    html! {
        @if !names.is_empty() {
            p.warning {
                b { "Less than no light. " }
                "Texels of " (names.join("; ")) " are below 0. They are counted in the table, and black in the pictures."
            }
        }
    }
}

fn printed_line(row: &Row, seconds: f64, shots: u32) -> Markup {
    html! { tr {
        td { (name(row)) }
        td.n { (row.texels) "²" }
        td.n { (row.item_buffer) "²" }
        td.n { (count(row.shots as u64)) }
        td.n { (shots) }
        td.n { (duration(row.seconds)) }
        td.n { (duration(seconds)) }
        td.n { (percent(row.error)) }
        td.n { (percent(row.error_rays)) }
    } }
}

fn line(row: &Row) -> Markup {
    html! { tr {
        td { (name(row)) }
        td.n { (count(row.shots as u64)) }
        td.n { (row.map_shots) " + " (row.object_shots) }
        td.n { (duration(row.seconds)) }
        td.n { (percent(row.error)) }
        td.n { (percent(row.error_rays)) }
        td.n { (percent(row.imbalance)) }
        td.n { (count(row.negative_texels as u64)) }
    } }
}

/// In one line: no-break spaces.
fn name(row: &Row) -> String {
    row.image.name().replace(' ', "\u{a0}")
}

/// Item buffer size across, image down; on the coarser texels.
fn figure9(table: &Table) -> Markup {
    let least = table.rows.iter().map(|row| row.texels).min();
    html! {
        section #figure9 {
            h2 { "Figure 9: item buffer size" }
            p { "A coarse item buffer leaves the borders of faces dark: there its pixels show the neighbour." }
            @for image in Image::ALL {
                @let own: Vec<(&Shown, &Row)> = shown(table).filter(|(_, row)| row.image == image && Some(row.texels) == least).collect();
                h3 { (image.name()) }
                (in_a_row(own.iter().map(|(shown, row)| figure("", &shown.picture.data_uri(), "the room relit", html! {
                    b { (row.item_buffer) "²" } " pixels: " (percent(row.error_rays)) " against rays"
                }))))
            }
        }
    }
}

/// Pictures and the rows that they show.
fn shown(table: &Table) -> impl Iterator<Item = (&Shown, &Row)> {
    table
        .shown
        .iter()
        .map(|shown| (shown, &table.rows[shown.row]))
}

/// Side by side, as many as there are: no row of a grid ends in a hole.
fn in_a_row(figures: impl ExactSizeIterator<Item = Markup>) -> Markup {
    html! { div.row style=(format!("--columns:{}", figures.len())) { @for figure in figures { (figure) } } }
}

fn pictures(k: usize, f: &Figure) -> Markup {
    html! {
        section id=(format!("f{k}")) {
            h2 { (f.title) }
            (in_a_row(f.pictures.iter().map(|(what, picture)| {
                figure("", &picture.data_uri(), what, html! { (what) })
            })))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::printed as paper;
    use super::*;
    use crate::show::picture::Picture;

    /// Every image on two sorts of texels and three item buffers, as `table4` measures them.
    fn table() -> Table {
        let mut table = Table::default();
        for (texels, item_buffer) in [16, 32]
            .iter()
            .flat_map(|t| [256, 512, 1024].map(|n| (*t, n)))
        {
            for image in Image::ALL {
                table.shown.push(Shown {
                    row: table.rows.len(),
                    picture: Picture::from_pixels(1, 1, |_, _| Some([9; 3])),
                });
                table.rows.push(Row {
                    image,
                    texels,
                    item_buffer,
                    seconds: 72.0,
                    shots: 300,
                    map_shots: 150,
                    object_shots: 10,
                    error: 0.1,
                    error_rays: 0.2,
                    imbalance: 0.01,
                    negative_texels: usize::from(image == Image::Signed),
                    paper: paper(image, texels, item_buffer),
                });
            }
        }
        table
    }

    #[test]
    fn the_papers_rows_come_first_and_in_its_order() {
        let table = table();
        let seconds = printed(&table).into_iter().map(|(_, (seconds, _))| seconds);
        assert_eq!(
            seconds.collect::<Vec<_>>(),
            [34.0, 41.0, 11.0, 13.0, 18.0, 24.0]
        );
        let page = html(&table);
        let at = |text: &str| page.find(text).unwrap_or_else(|| panic!("{text}"));
        assert!(at("<h2>The paper's rows") < at("<h2>All images"));
        assert_eq!(page.matches("<tr class=\"group\">").count(), 6);
        assert!(page.contains("1 min 12 s") && page.contains("Texels of signed are below 0"));
    }

    #[test]
    fn no_row_of_pictures_has_a_hole() {
        let page = html(&table());
        let rows: Vec<&str> = page.split("<div class=\"row\"").skip(1).collect();
        assert_eq!(rows.len(), Image::ALL.len());
        for row in rows {
            let row = &row[..row.find("</div>").unwrap()];
            assert!(row.starts_with(" style=\"--columns:3\"") && row.matches("<img").count() == 3);
        }
    }
}
