//! The rays that plain progressive radiosity asks, for another ray tracer: every shot's centre to
//! every texel's centre.
//!
//! Little-endian: u32 counts of triangles, shooters, texels, shots; f32 corners of the triangles,
//! centres of the shooters, centres of the texels; u32 shooter of each shot; one byte for each
//! (shooter, texel): what our rays say, 0 hidden, 1 seen, 2 one faces away from the other.

use common::form_factor::{FormFactor, form_factor};
use common::mesh::Mesh;
use common::rays::Rays;
use glam::Vec3;
use rayon::prelude::*;
use serde_json::Value;
use std::fs::File;
use std::io::{BufWriter, Result, Write};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Writes the rays of the `shots` of a solve.
pub fn dump(path: &Path, mesh: &Mesh, shots: &[u32]) -> Result<()> {
    let triangles = triangles(mesh);
    let mut file = BufWriter::new(File::create(path)?);
    for count in [
        triangles.len(),
        mesh.cells.len(),
        mesh.texels.len(),
        shots.len(),
    ] {
        file.write_all(&(count as u32).to_le_bytes())?;
    }
    let centres = mesh.cells.iter().map(|cell| cell.shooter.centre);
    let texels = mesh.texels.iter().map(|texel| texel.position);
    for point in triangles.into_iter().flatten().chain(centres).chain(texels) {
        for x in point.to_array() {
            file.write_all(&x.to_le_bytes())?;
        }
    }
    for shooter in shots {
        file.write_all(&shooter.to_le_bytes())?;
    }
    let rays = Rays::new(mesh);
    for shooter in 0..mesh.cells.len() {
        file.write_all(&answers(mesh, &rays, shooter))?;
    }
    file.flush()
}

fn triangles(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    let mut triangles = Vec::new();
    for face in mesh.faces.iter().filter(|face| face.normal != Vec3::ZERO) {
        let [a, b, c, d] = face.corners;
        triangles.push([a, b, c]);
        if c != d {
            triangles.push([a, c, d]);
        }
    }
    triangles
}

fn answers(mesh: &Mesh, rays: &Rays, shooter: usize) -> Vec<u8> {
    let cell = &mesh.cells[shooter];
    let answer = |k: usize| {
        let texel = &mesh.texels[k];
        let normal = mesh.faces[texel.face as usize].normal;
        let factor = form_factor(
            FormFactor::Disc,
            &cell.shooter,
            texel.position,
            normal,
            texel.area,
        );
        if factor == 0.0 {
            return 2;
        }
        u8::from(rays.visible(cell.shooter.centre, texel.position, [cell.face, texel.face]))
    };
    (0..mesh.texels.len()).into_par_iter().map(answer).collect()
}

/// Embree's program, where `make peers` has built it.
pub fn embree() -> Option<PathBuf> {
    let program = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/peers/embree_rays");
    program.exists().then_some(program)
}

/// What Embree's program says of the rays in `dump`.
pub fn trace(program: &Path, dump: &Path, threads: usize) -> Value {
    let output = Command::new(program)
        .arg(dump)
        .arg(threads.to_string())
        .output()
        .expect("Embree's program starts");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    serde_json::from_slice(&output.stdout).expect("Embree's program writes JSON")
}
