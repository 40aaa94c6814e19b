//! `radiosity table4`: repeats the paper's Table 4.

use super::Outcome;
use super::bundled::bundled_scene;
use super::console::message;
use super::progress::{Progress, handle_interrupts};
use super::solver::open_adapter;
use crate::studies::table4::{Table4, Table4Grid, page};
use clap::Args;
use common::Result;
use common::import::{ImportOptions, load_scene};
use common::scene::Scene;
use common::solution::{prepare_folder, write_files};
use serde_json::json;
use std::path::PathBuf;

/// Texels per side of the table's faces.
const TABLE_TEXELS: [u32; 2] = [16, 32];
/// Pixels per side of the table's item buffers.
const ITEM_BUFFER_SIZES: [u32; 3] = [256, 512, 1024];

/// Arguments of `table4`.
#[derive(Args)]
pub struct Table4Arguments {
    /// Folder for table4.html and table4.json
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// The GPU adapter whose name contains NAME
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

/// Measures the grid of texels and item buffers and writes after each of its entries.
pub fn run(arguments: &Table4Arguments) -> Result<Outcome> {
    let out = &arguments.out;
    let name = arguments.adapter.as_deref();
    let (gpu, missing) = open_adapter(name, "the CPU's twin draws the item buffers")?;
    // An adapter given by name is to be used.
    if let Some(error) = missing.filter(|_| name.is_some()) {
        return Err(error);
    }
    let part = |name| load_scene(&bundled_scene(name, out)?, &ImportOptions::default());
    let (room, objects) = (part("paper_room.obj")?, part("paper_objects.obj")?);
    let scene = Scene::join_scenes(&[room.clone(), objects.clone()]);
    prepare_folder(out, &["table4.json", "table4.html"])?;
    handle_interrupts();
    let progress = Progress::new("table 4");
    let grid = Table4Grid {
        scene: &scene,
        room: room.faces.len(),
        gpu: gpu.as_ref(),
        show: &|phase, done| progress.show_phase(phase, done),
    };
    let mut table = Table4 {
        adapter: gpu
            .as_ref()
            .map_or("the CPU's twin".into(), |gpu| gpu.line.name.clone()),
        faces: scene.faces.len(),
        object_faces: objects.faces.len(),
        ..Table4::default()
    };
    let write = |table: &Table4| {
        let json = format!("{:#}\n", json!(table));
        write_files(out, [("table4.json", json), ("table4.html", page::render_page(table))])
    };
    for texels in TABLE_TEXELS {
        let rays = grid.solve_by_rays(texels)?;
        for item_buffer in ITEM_BUFFER_SIZES {
            table.rows.extend(grid.measure_images(texels, item_buffer, &rays)?);
            write(&table)?;
        }
    }
    table.shadows = grid.draw_shadows()?;
    write(&table)?;
    progress.remove_bar();
    message!("wrote {0}/table4.html and {0}/table4.json", out.display());
    Ok(Outcome::Done)
}
