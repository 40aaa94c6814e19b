//! `radiosity table4`.

use super::Outcome;
use super::bundled::bundled;
use super::progress::{Progress, interrupted, listen};
use super::solver::open_or_twin;
use super::tell::{result, say};
use crate::relight::files;
use crate::show::picture::Picture;
use crate::show::view::camera::Camera;
use crate::study::table4::grid::{Grid, SIZE, exposure, look};
use crate::study::table4::{Figure, Image, Row, Table, page};
use clap::Args;
use common::file::input;
use common::import::{ImportOptions, load};
use common::scene::Scene;
use common::solution::{prepare, write_file};
use common::{Error, Result};
use glam::DVec3;
use serde_json::json;
use std::path::PathBuf;

/// Texels of the table, and of Figure 8.
const TEXELS: [u32; 2] = [16, 32];
const SHADOW_TEXELS: [u32; 3] = [8, 16, 32];
/// Item buffers of the table.
const ITEM_BUFFERS: [u32; 3] = [256, 512, 1024];
/// Figure 8 looks at the floor between the blocks.
const SHADOW: ([f64; 3], [f64; 3], f64) = ([0.5, 0.75, 0.06], [0.6, 0.0, 0.62], 50.0);

/// Arguments of `table4`.
#[derive(Args)]
pub struct Arguments {
    /// Where table4.html and table4.json go
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

/// Measures, and writes after each cell of the grid.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let figure10 = arguments.composite.as_ref().map(real).transpose()?;
    let gpu = open_or_twin(arguments.adapter.as_deref())?;
    let part = |name| load(&bundled(name, &arguments.out)?, &ImportOptions::default());
    let (room, objects) = (part("paper_room.obj")?, part("paper_objects.obj")?);
    let scene = Scene::joined(&[room.clone(), objects.clone()]);
    prepare(&arguments.out)?;
    listen();
    let progress = Progress::new("table 4", arguments.quiet);
    let grid = Grid {
        scene: &scene,
        room: room.faces.len(),
        device: gpu.as_ref(),
        show: &|phase, done| progress.show(phase, done),
    };
    let mut table = Table {
        adapter: gpu
            .as_ref()
            .map_or("the CPU's twin".into(), |gpu| gpu.line.name.clone()),
        faces: [scene.faces.len(), objects.faces.len()],
        ..Table::default()
    };
    for texels in TEXELS {
        let rays = grid.by_rays(texels)?;
        for item_buffer in ITEM_BUFFERS {
            grid.cell(&mut table, texels, item_buffer, &rays)?;
            write(arguments, &table)?;
            if interrupted() {
                return Err(Error::Interrupted);
            }
        }
    }
    table.figures.push(shadows(&grid, &scene)?);
    table.figures.extend(figure10);
    write(arguments, &table)?;
    progress.clear();
    if !arguments.quiet {
        print(&table)?;
        say!(
            "wrote {0}/table4.html and {0}/table4.json",
            arguments.out.display()
        );
    }
    Ok(Outcome::Done)
}

/// Figure 8: shadow against texel resolution.
fn shadows(grid: &Grid, scene: &Scene) -> Result<Figure> {
    let mut pictures = Vec::new();
    for texels in SHADOW_TEXELS {
        let (stage, done) = grid.picture(texels, Image::Signed)?;
        let local = |p: [f64; 3]| done.mesh.local(DVec3::from(p)).as_vec3();
        let camera = Camera::new(local(SHADOW.0), local(SHADOW.1), SHADOW.2 as f32);
        let seen = look(&stage, &done, Some(camera))?;
        pictures.push((
            format!(
                "{texels}² texels per face, {} in all",
                done.mesh.texels.len()
            ),
            files::picture(SIZE, &seen.composite, &seen.coverage[1], exposure(&seen)),
        ));
    }
    Ok(Figure {
        title: format!("Figure 8: shadows and texels ({} faces)", scene.faces.len()),
        pictures,
    })
}

/// Figure 10, from a relight.
fn real(path: &PathBuf) -> Result<Figure> {
    let image = image::load_from_memory(&input(path, "a PNG is needed")?)
        .map_err(|e| Error::input(path, "", format!("cannot be read ({e}): a PNG is needed")))?
        .to_rgb8();
    let (width, height) = image.dimensions();
    // Its folders would stretch the page.
    let name = path
        .file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy();
    let colour = |x: u32, y: u32| Some(image.get_pixel(x, y).0);
    Ok(Figure {
        title: "Figure 10: a real map and an object".into(),
        pictures: vec![(
            name.into_owned(),
            Picture::from_pixels(width, height, colour),
        )],
    })
}

fn write(arguments: &Arguments, table: &Table) -> Result<()> {
    let json = json!({
        "adapter": table.adapter,
        "faces": table.faces[0],
        "object_faces": table.faces[1],
        "rows": table.rows,
    });
    write_file(
        &arguments.out.join("table4.json"),
        format!("{json:#}\n").as_bytes(),
    )?;
    write_file(
        &arguments.out.join("table4.html"),
        page::html(table).as_bytes(),
    )
}

fn print(table: &Table) -> Result<()> {
    result!(
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
        let (seconds, shots) = row.paper.map_or((String::new(), String::new()), |(s, n)| {
            (s.to_string(), n.to_string())
        });
        let of = |row: &Row| format!("{}+{}", row.map_shots, row.object_shots);
        result!(
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
