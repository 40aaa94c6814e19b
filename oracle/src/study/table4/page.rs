//! `table4.html`: the table, and the paper's Figures 8, 9 and 10 again.

use super::{Figure, Image, Row, Table};
use crate::show::number::{count, number, percent};
use crate::show::page::{self, Page, figure};
use maud::{Markup, html};

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
        (page::table("", &HEADS, html! { @for row in &table.rows { (line(row)) } }))
        (figure9(table))
        @for (k, f) in table.figures.iter().enumerate() { (pictures(k, f)) }
    };
    Page {
        title: "Radiosity: the paper's Table 4, repeated",
        bar: ("Parts", links),
        verdict: html! {},
        style: "",
        body,
    }
    .html()
}

const HEADS: [&str; 12] = [
    "Image",
    "#Texels",
    "#Item buffer",
    "#Shots",
    "#paper's",
    "#Map + object",
    "#Seconds",
    "#paper's, 2006",
    "#Error",
    "#against rays",
    "#Power missed",
    "#Texels < 0",
];

fn line(row: &Row) -> Markup {
    html! { tr {
        // In one line: no-break spaces.
        td { (row.image.name().replace(' ', "\u{a0}")) }
        td.n { (row.texels) "²" }
        td.n { (row.item_buffer) "²" }
        td.n { (count(row.shots as u64)) }
        td.n { @if let Some((_, shots)) = row.paper { (shots) } }
        td.n { (row.map_shots) " + " (row.object_shots) }
        td.n { (number(row.seconds)) }
        td.n { @if let Some((seconds, _)) = row.paper { (number(seconds)) } }
        td.n { (percent(row.error)) }
        td.n { (percent(row.error_rays)) }
        td.n { (percent(row.imbalance)) }
        td.n { (count(row.negative_texels as u64)) }
    } }
}

/// Item buffer size across, image down; on the coarser texels.
fn figure9(table: &Table) -> Markup {
    let least = table.rows.iter().map(|row| row.texels).min();
    html! {
        section #figure9 {
            h2 { "Figure 9: item buffer size" }
            p { "A coarse item buffer leaves the borders of faces dark: there its pixels show the neighbour." }
            @for image in Image::ALL {
                h3 { (image.name()) }
                div.grid {
                    @for shown in &table.shown {
                        @let row = &table.rows[shown.row];
                        @if row.image == image && Some(row.texels) == least {
                            (figure("", &shown.picture.data_uri(), "the room relit", html! {
                                (row.item_buffer) "², " (row.texels) "² texels: " (percent(row.error_rays)) " against rays"
                            }))
                        }
                    }
                }
            }
        }
    }
}

fn pictures(k: usize, f: &Figure) -> Markup {
    html! {
        section id=(format!("f{k}")) {
            h2 { (f.title) }
            div.grid {
                @for (what, picture) in &f.pictures { (figure("", &picture.data_uri(), what, html! { (what) })) }
            }
        }
    }
}
