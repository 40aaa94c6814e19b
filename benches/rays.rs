//! Exports the rays of plain progressive radiosity to another ray tracer: from the centre of every
//! shooter to the centre of every texel.
//!
//! Format, little-endian: u32 counts of triangles, shooters, texels, shots; f32 corners of the
//! triangles, centres of the shooters, centres of the texels; u32 shooter of each shot; one byte for
//! each (shooter, texel), the result of our rays: 0 hidden, 1 visible, 2 not facing each other.

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

/// Writes the rays of a solve's `shots`. Errors: the file cannot be written.
pub fn dump_rays(path: &Path, mesh: &Mesh, shots: &[u32]) -> Result<()> {
    let triangles = mesh_triangles(mesh);
    let mut file = BufWriter::new(File::create(path)?);
    for count in [triangles.len(), mesh.patches.len(), mesh.texels.len(), shots.len()] {
        file.write_all(&(count as u32).to_le_bytes())?;
    }
    let centres = mesh.patches.iter().map(|patch| patch.shooter.centre);
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
    for shooter in 0..mesh.patches.len() {
        file.write_all(&trace_answers(mesh, &rays, shooter))?;
    }
    file.flush()
}

fn mesh_triangles(mesh: &Mesh) -> Vec<[Vec3; 3]> {
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

fn trace_answers(mesh: &Mesh, rays: &Rays, shooter: usize) -> Vec<u8> {
    let patch = &mesh.patches[shooter];
    let answer = |k: usize| {
        let texel = &mesh.texels[k];
        let normal = mesh.faces[texel.face as usize].normal;
        let factor = form_factor(FormFactor::Disc, &patch.shooter, texel.position, normal, texel.area);
        if factor == 0.0 {
            return 2;
        }
        u8::from(rays.is_visible(patch.shooter.centre, texel.position, [patch.face, texel.face]))
    };
    (0..mesh.texels.len()).into_par_iter().map(answer).collect()
}

/// Returns the path of Embree's program, if `make peers` has built it.
pub fn embree_program() -> Option<PathBuf> {
    let program = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/peers/embree_rays");
    program.exists().then_some(program)
}

/// Runs Embree's program on the rays in `dump` and returns its JSON. Panics if it fails.
pub fn run_embree(program: &Path, dump: &Path, threads: usize) -> Value {
    let output = Command::new(program)
        .arg(dump)
        .arg(threads.to_string())
        .output()
        .expect("Embree's program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("Embree's program writes JSON")
}
