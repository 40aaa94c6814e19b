//! `radiosity table4`.

use super::Outcome;
use super::bundled::bundled_scene;
use super::console::{message, output};
use super::progress::{Progress, handle_interrupts, is_interrupted};
use super::solver::open_gpu_or_twin;
use crate::relight::files;
use crate::report::picture::RgbaPicture;
use crate::report::view::camera::Camera;
use crate::studies::table4::grid::{PICTURE_SIZE, Table4Grid, background_exposure, render_view};
use crate::studies::table4::{PaperFigure, Table4, Table4Row, TableImage, page};
use clap::Args;
use common::file::read_input;
use common::import::{ImportOptions, load_scene};
use common::scene::Scene;
use common::solution::{prepare_directory, write_file};
use common::{Error, Result};
use glam::DVec3;
use serde_json::json;
use std::path::PathBuf;

/// Texels per side of the table's faces.
const TABLE_TEXELS: [u32; 2] = [16, 32];
/// Texels per side of Figure 8's faces.
const SHADOW_TEXELS: [u32; 3] = [8, 16, 32];
/// Pixels per side of the table's item buffers.
const ITEM_BUFFER_SIZES: [u32; 3] = [256, 512, 1024];
/// Eye, target and vertical field of view in degrees of Figure 8: the floor between the blocks.
const SHADOW_CAMERA: ([f64; 3], [f64; 3], f64) = ([0.5, 0.75, 0.06], [0.6, 0.0, 0.62], 50.0);

/// Arguments of `table4`.
#[derive(Args)]
pub struct Table4Arguments {
    /// Folder for table4.html and table4.json
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// The GPU adapter whose name contains NAME
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// A composite.png of relight, shown as Figure 10 (a real map and an object)
    #[arg(long, value_name = "FILE")]
    composite: Option<PathBuf>,
    /// No progress, no table
    #[arg(long)]
    quiet: bool,
}

/// Measures the grid of texels and item buffers and writes after each of its entries.
pub fn run(arguments: &Table4Arguments) -> Result<Outcome> {
    let figure10 = arguments.composite.as_ref().map(read_composite_figure).transpose()?;
    let gpu = open_gpu_or_twin(arguments.adapter.as_deref())?;
    let part = |name| load_scene(&bundled_scene(name, &arguments.out)?, &ImportOptions::default());
    let (room, objects) = (part("paper_room.obj")?, part("paper_objects.obj")?);
    let scene = Scene::join_scenes(&[room.clone(), objects.clone()]);
    prepare_directory(&arguments.out)?;
    handle_interrupts();
    let progress = Progress::new("table 4", arguments.quiet);
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
        faces: [scene.faces.len(), objects.faces.len()],
        ..Table4::default()
    };
    for texels in TABLE_TEXELS {
        let rays = grid.solve_by_rays(texels)?;
        for item_buffer in ITEM_BUFFER_SIZES {
            grid.measure_images(&mut table, texels, item_buffer, &rays)?;
            write_table(arguments, &table)?;
            if is_interrupted() {
                return Err(Error::Interrupted);
            }
        }
    }
    table.figures.push(draw_shadow_figure(&grid, &scene)?);
    table.figures.extend(figure10);
    write_table(arguments, &table)?;
    progress.clear();
    if !arguments.quiet {
        print_table(&table)?;
        message!("wrote {0}/table4.html and {0}/table4.json", arguments.out.display());
    }
    Ok(Outcome::Done)
}

/// Draws Figure 8: shadows against texel resolution.
fn draw_shadow_figure(grid: &Table4Grid, scene: &Scene) -> Result<PaperFigure> {
    let mut pictures = Vec::new();
    for texels in SHADOW_TEXELS {
        let (stage, done) = grid.relight_for_picture(texels, TableImage::Signed)?;
        let local = |p: [f64; 3]| done.mesh.local_point(DVec3::from(p)).as_vec3();
        let camera = Camera::new(local(SHADOW_CAMERA.0), local(SHADOW_CAMERA.1), SHADOW_CAMERA.2 as f32);
        let seen = render_view(&stage, &done, Some(camera))?;
        pictures.push((
            format!("{texels}² texels per face, {} in all", done.mesh.texels.len()),
            files::tone_map_picture(
                PICTURE_SIZE,
                &seen.composite,
                &seen.coverage[1],
                background_exposure(&seen),
            ),
        ));
    }
    Ok(PaperFigure {
        title: format!("Figure 8: shadows and texels ({} faces)", scene.faces.len()),
        pictures,
    })
}

/// Reads Figure 10, the composite of a relight.
fn read_composite_figure(path: &PathBuf) -> Result<PaperFigure> {
    let image = image::load_from_memory(&read_input(path, "a PNG is needed")?)
        .map_err(|e| Error::bad_input(path, "", format!("cannot be read ({e}): a PNG is needed")))?
        .to_rgb8();
    let (width, height) = image.dimensions();
    // Without its folders, which would stretch the page.
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let colour = |x: u32, y: u32| Some(image.get_pixel(x, y).0);
    Ok(PaperFigure {
        title: "Figure 10: a real map and an object".into(),
        pictures: vec![(name.into_owned(), RgbaPicture::from_pixels(width, height, colour))],
    })
}

fn write_table(arguments: &Table4Arguments, table: &Table4) -> Result<()> {
    let json = json!({
        "adapter": table.adapter,
        "faces": table.faces[0],
        "object_faces": table.faces[1],
        "rows": table.rows,
    });
    write_file(&arguments.out.join("table4.json"), format!("{json:#}\n").as_bytes())?;
    write_file(&arguments.out.join("table4.html"), page::render_page(table).as_bytes())
}

fn print_table(table: &Table4) -> Result<()> {
    output!(
        "{:<16} {:>6} {:>6} {:>6} {:>6} {:>11} {:>8} {:>7} {:>8} {:>8} {:>8}",
        "image",
        "texels",
        "buffer",
        "shots",
        "paper",
        "map+object",
        "seconds",
        "paper",
        "error",
        "to rays",
        "power"
    )?;
    for row in &table.rows {
        let (seconds, shots) = row
            .paper
            .map_or((String::new(), String::new()), |(s, n)| (s.to_string(), n.to_string()));
        let of = |row: &Table4Row| format!("{}+{}", row.map_shots, row.object_shots);
        output!(
            "{:<16} {:>6} {:>6} {:>6} {:>6} {:>11} {:>8.2} {:>7} {:>7.2}% {:>7.2}% {:>7.2}%",
            row.image.name(),
            row.texels,
            row.item_buffer,
            row.shots,
            shots,
            of(row),
            row.seconds,
            seconds,
            100.0 * row.error,
            100.0 * row.error_rays,
            100.0 * row.imbalance
        )?;
    }
    Ok(())
}
