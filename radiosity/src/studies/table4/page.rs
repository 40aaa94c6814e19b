//! Content of `table4.html`: the table, and the paper's Figures 8, 9 and 10 repeated.

use super::{Table4, TableImage};
use crate::report::document::{Blocks, Figure, Row, Section, Table, bold_text, plain_text, render_document};
use crate::report::format::{format_count, format_duration, format_percent};

/// Returns the page.
pub fn render_page(table: &Table4) -> String {
    let mut opening = Blocks::default();
    opening
        .add_remark(format!(
            "{} faces, {} of them the objects · {}",
            format_count(table.faces as u64),
            format_count(table.object_faces as u64),
            table.adapter
        ))
        .add_paragraph(
            "Settings as in the paper: whole faces shoot, an orthographic item buffer is looked up in one pixel \
             per texel, and shooting ends when 5 % is unshot. The room was captured by solving it empty. \
             Error is relative RMS of B − E: against everything solved again on the same item buffers, and \
             against the same by rays.",
        )
        .add_paragraph(
            "The paper prints neither its room nor where it stops, so both were chosen: unit walls of 5×5 \
             faces, one red and one green; sizes and places of the lamp box and of the two blocks; the \
             reflectances, 0.7 where white, and 5 % unshot, such that the reference takes about the \
             paper's 322 shots (reflectances of 0.5, 0.6 and 0.9 would take 180, 244 and 726; 1 % \
             unshot with 0.5 fits as well). That these shot counts agree therefore confirms nothing; \
             how errors and shots of the methods compare does not depend on it.",
        );
    let mut images = Blocks::default();
    images.add_table(image_table(table));
    let shadows = table
        .shadows
        .iter()
        .map(|(text, picture)| Figure::from_picture(&picture.data_uri(), text, text));
    let mut figure8 = Blocks::default();
    figure8.add_figure_row(&shadows.collect::<Vec<_>>());
    let sections = [
        images.into_section("table4", "Table 4"),
        figure8.into_section("figure8", "Figure 8: shadows and texels"),
        figure9_section(table),
    ];
    let style = "main{max-width:84rem}tr.front td{font-weight:600}";
    render_document("Radiosity: the paper's Table 4, repeated", &opening, &sections, style)
}

/// Makes the table of all images, the paper's figures beside ours where it prints them.
fn image_table(table: &Table4) -> Table {
    let heads = "Image;#Texels;#Item buffer;#Shots;#the paper's;#Map + object;#Time;#the paper's, 2006;#Error;\
                 #against rays;#Power missed;#Texels < 0";
    let rows = table.rows.iter().map(|row| {
        let (seconds, shots) = row.paper.unzip();
        Row::new([
            row.image.name().replace(' ', "\u{a0}"),
            format!("{}²", row.texels),
            format!("{}²", row.item_buffer),
            format_count(row.shots as u64),
            shots.map_or("–".into(), |shots| shots.to_string()),
            format!("{} + {}", row.map_shots, row.object_shots),
            format_duration(row.seconds),
            seconds.map_or("–".into(), format_duration),
            format_percent(row.error),
            format_percent(row.error_rays),
            format_percent(row.imbalance),
            format_count(row.negative_texels as u64),
        ])
        .with_class_if(row.paper.is_some(), "front")
    });
    Table::new(heads, rows)
}

/// Makes Figure 9: item-buffer sizes across, images down, on the coarser texels.
fn figure9_section(table: &Table4) -> Section {
    let least = table.rows.iter().map(|row| row.texels).min();
    let mut body = Blocks::default();
    body.add_paragraph("A coarse item buffer leaves the borders of faces dark: there its pixels show the neighbour.");
    for image in TableImage::ALL {
        let shown = table
            .rows
            .iter()
            .filter(|row| row.image == image && Some(row.texels) == least);
        let figures: Vec<Figure> = shown
            .map(|row| {
                let error = plain_text(" pixels: ") + format_percent(row.error_rays) + " against rays";
                let caption = bold_text(format!("{}²", row.item_buffer)) + error;
                Figure::from_picture(&row.picture.data_uri(), "the room relit", caption)
            })
            .collect();
        body.add_heading(image.name()).add_figure_row(&figures);
    }
    body.into_section("figure9", "Figure 9: item buffer size")
}
