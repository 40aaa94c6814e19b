//! Content of `table4.html`: the table, and the paper's Figures 8, 9 and 10 repeated.

use super::{PaperFigure, RowPicture, Table4, Table4Row, TableImage};
use crate::report::format::{format_count, format_duration, format_percent};
use crate::report::page::{Page, render_figure};
use crate::report::table::{TableRow, number_cell, render_table, text_cell};
use maud::{Markup, html};

const PAGE_STYLE: &str = "\
    .row{display:grid;grid-template-columns:repeat(var(--columns),minmax(0,30rem));gap:1.2rem}\
    tr.group th{text-align:left;padding-top:.9rem}\
    @media (max-width:45rem){.row{grid-template-columns:minmax(0,1fr)}}";

/// Returns the page.
pub fn render_page(table: &Table4) -> String {
    let links = html! {
        a href="#top" { "Table 4" }
        a href="#figure9" { "Figure 9" }
        @for (k, f) in table.figures.iter().enumerate() { a href=(format!("#f{k}")) { (f.title) } }
    };
    let body = html! {
        p.facts {
            (format_count(table.faces[0] as u64)) " faces, " (format_count(table.faces[1] as u64))
            " of them the objects · " (table.adapter)
        }
        p {
            "Settings as in the paper: whole faces shoot, an orthographic item buffer is looked up in one pixel "
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
        (negative_warning(table))
        h2 { "The paper's rows" }
        (render_table("", &PRINTED_HEADS, printed_rows(table).into_iter().map(|(row, (seconds, shots))| {
            printed_row(row, seconds, shots)
        })))
        h2 { "All images" }
        (render_table("", &IMAGE_HEADS, grid_groups(table).flat_map(image_rows)))
        (figure9_section(table))
        @for (k, f) in table.figures.iter().enumerate() { (figure_section(k, f)) }
    };
    Page {
        title: "Radiosity: the paper's Table 4, repeated",
        bar: ("Parts", links),
        verdict: html! {},
        style: PAGE_STYLE,
        body,
    }
    .to_html()
}

const PRINTED_HEADS: [&str; 9] = [
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
const IMAGE_HEADS: [&str; 8] = [
    "Image",
    "#Shots",
    "#Map + object",
    "#Time",
    "#Error",
    "#against rays",
    "#Power missed",
    "#Texels < 0",
];

/// Returns the rows that the paper prints, in its order, with its seconds and shots.
fn printed_rows(table: &Table4) -> Vec<(&Table4Row, (f64, u32))> {
    let rows = table.rows.iter();
    let mut all: Vec<_> = rows.filter_map(|row| Some((row, row.paper?))).collect();
    all.sort_by_key(|(row, _)| (row.image != TableImage::Reference, row.texels, row.item_buffer));
    all
}

/// Groups the rows by texels and item buffer.
fn grid_groups(table: &Table4) -> impl Iterator<Item = &[Table4Row]> {
    let same = |a: &Table4Row, b: &Table4Row| (a.texels, a.item_buffer) == (b.texels, b.item_buffer);
    table.rows.chunk_by(same)
}

/// Warns of images with negative texels.
fn negative_warning(table: &Table4) -> Markup {
    let mut names: Vec<&str> = Vec::new();
    for row in table.rows.iter().filter(|row| row.negative_texels > 0) {
        if !names.contains(&row.image.name()) {
            names.push(row.image.name());
        }
    }
    html! {
        @if !names.is_empty() {
            p.warning {
                b { "Negative radiosity. " }
                "Texels of " (names.join("; ")) " are below 0. They are counted in the table, and black in the pictures."
            }
        }
    }
}

fn printed_row(row: &Table4Row, seconds: f64, shots: u32) -> TableRow {
    TableRow::new([
        text_cell(image_name(row)),
        number_cell(html! { (row.texels) "²" }),
        number_cell(html! { (row.item_buffer) "²" }),
        number_cell(format_count(row.shots as u64)),
        number_cell(shots),
        number_cell(format_duration(row.seconds)),
        number_cell(format_duration(seconds)),
        number_cell(format_percent(row.error)),
        number_cell(format_percent(row.error_rays)),
    ])
}

/// Returns the heading and the rows of a group.
fn image_rows(group: &[Table4Row]) -> Vec<TableRow> {
    let heading = text_cell(html! {
        (group[0].texels) "² texels a face, item buffers of " (group[0].item_buffer) "² pixels"
    });
    let heading = heading.as_heading().with_column_span(IMAGE_HEADS.len());
    let heading = TableRow::new([heading]).with_class_if(true, "group");
    [heading].into_iter().chain(group.iter().map(image_row)).collect()
}

fn image_row(row: &Table4Row) -> TableRow {
    TableRow::new([
        text_cell(image_name(row)),
        number_cell(format_count(row.shots as u64)),
        number_cell(html! { (row.map_shots) " + " (row.object_shots) }),
        number_cell(format_duration(row.seconds)),
        number_cell(format_percent(row.error)),
        number_cell(format_percent(row.error_rays)),
        number_cell(format_percent(row.imbalance)),
        number_cell(format_count(row.negative_texels as u64)),
    ])
}

/// Returns the image's name with no-break spaces.
fn image_name(row: &Table4Row) -> String {
    row.image.name().replace(' ', "\u{a0}")
}

/// Figure 9: item-buffer sizes across, images down, on the coarser texels.
fn figure9_section(table: &Table4) -> Markup {
    let least = table.rows.iter().map(|row| row.texels).min();
    html! {
        section #figure9 {
            h2 { "Figure 9: item buffer size" }
            p { "A coarse item buffer leaves the borders of faces dark: there its pixels show the neighbour." }
            @for image in TableImage::ALL {
                @let row_pictures: Vec<(&RowPicture, &Table4Row)> = pictures_with_rows(table).filter(|(_, row)| row.image == image && Some(row.texels) == least).collect();
                h3 { (image.name()) }
                (figure_row(row_pictures.iter().map(|(shown, row)| render_figure("", &shown.picture.data_uri(), "the room relit", html! {
                    b { (row.item_buffer) "²" } " pixels: " (format_percent(row.error_rays)) " against rays"
                }))))
            }
        }
    }
}

/// Iterates over the pictures and their rows.
fn pictures_with_rows(table: &Table4) -> impl Iterator<Item = (&RowPicture, &Table4Row)> {
    table.shown.iter().map(|shown| (shown, &table.rows[shown.row]))
}

/// Lays figures out in one row.
fn figure_row(figures: impl ExactSizeIterator<Item = Markup>) -> Markup {
    html! { div.row style=(format!("--columns:{}", figures.len())) { @for figure in figures { (figure) } } }
}

fn figure_section(k: usize, f: &PaperFigure) -> Markup {
    html! {
        section id=(format!("f{k}")) {
            h2 { (f.title) }
            (figure_row(f.pictures.iter().map(|(what, picture)| {
                render_figure("", &picture.data_uri(), what, html! { (what) })
            })))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::printed_figures as paper;
    use super::*;
    use crate::report::picture::RgbaPicture;

    /// Table with every image on two resolutions and three item buffers.
    fn table() -> Table4 {
        let mut table = Table4::default();
        for (texels, item_buffer) in [16, 32].iter().flat_map(|t| [256, 512, 1024].map(|n| (*t, n))) {
            for image in TableImage::ALL {
                table.shown.push(RowPicture {
                    row: table.rows.len(),
                    picture: RgbaPicture::from_pixels(1, 1, |_, _| Some([9; 3])),
                });
                table.rows.push(Table4Row {
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
                    negative_texels: usize::from(image == TableImage::Signed),
                    paper: paper(image, texels, item_buffer),
                });
            }
        }
        table
    }

    #[test]
    fn rows_of_the_paper_come_first_in_its_order() {
        let table = table();
        let seconds = printed_rows(&table).into_iter().map(|(_, (seconds, _))| seconds);
        assert_eq!(seconds.collect::<Vec<_>>(), [34.0, 41.0, 11.0, 13.0, 18.0, 24.0]);
        let page = render_page(&table);
        let at = |text: &str| page.find(text).unwrap_or_else(|| panic!("{text}"));
        assert!(at("<h2>The paper's rows") < at("<h2>All images"));
        assert_eq!(page.matches("<tr class=\"group\">").count(), 6);
        assert!(page.contains("1 min 12 s") && page.contains("Texels of signed are below 0"));
    }

    #[test]
    fn rows_of_pictures_are_complete() {
        let page = render_page(&table());
        let rows: Vec<&str> = page.split("<div class=\"row\"").skip(1).collect();
        assert_eq!(rows.len(), TableImage::ALL.len());
        for row in rows {
            let row = &row[..row.find("</div>").unwrap()];
            assert!(row.starts_with(" style=\"--columns:3\"") && row.matches("<img").count() == 3);
        }
    }
}
