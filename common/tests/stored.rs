//! Stored solutions: read back bit for bit, and errors of damaged files.

use crate::import::files::Folder;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::Settings;
use common::shooting::{RadiosityField, SolveRun, initial_field};
use common::solution::{PhaseSeconds, Solution, StoredSolution};
use glam::{DVec3, Vec3, Vec4};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

fn scene() -> Scene {
    let p = |x: f64, y: f64| DVec3::new(x, y, 1.0 / 3.0);
    let quad = [p(0.0, 0.0), p(4.1, 0.0), p(3.0, 2.0), p(0.5, 1.0)];
    let triangle = [p(7.0, 0.0), p(9.0, 0.1), p(7.0, 3.0)];
    let faces = vec![
        Face::quad("floor", quad, Vec3::new(0.1, 0.2, 0.3), Vec3::splat(0.7)),
        Face::triangle("“ü”", triangle, Vec3::ZERO, Vec3::new(0.1, 0.5, 0.9)),
    ];
    let scene = Scene {
        name: "two.obj".into(),
        faces,
        ..Scene::default()
    };
    scene.two_sided()
}

/// Makes a field of distinct values in all texels and channels: large, small and negative ones.
fn field(mesh: &Mesh) -> RadiosityField {
    let value = |salt: f32| {
        let value = move |k: usize| {
            let x = (k as f32 + 1.0) * salt;
            Vec4::new(x.sin() * 1e-30, x * 1e14, -x / 3.0, 0.0)
        };
        (0..mesh.texels.len()).map(value).collect()
    };
    RadiosityField {
        radiosity: value(1.0),
        residual: value(7.0),
        irradiance: value(13.0),
        ..initial_field(mesh, "by hand")
    }
}

/// Writes the scene with 6×6 texels per face; with `captured` it is a captured room, and face 1 has this E.
fn write(dir: &Path, captured: Option<Vec3>) -> (Mesh, RadiosityField) {
    let scene = scene();
    // Patches change the order of the mesh's texels, and must not change the file's.
    let mut mesh = Mesh::uniform(&scene, 6, 3).unwrap();
    for texel in mesh.texels.iter_mut().filter(|texel| texel.face == 1) {
        texel.emission = captured.unwrap_or(texel.emission);
    }
    let field = field(&mesh);
    let solution = Solution {
        matrix: None,
        relit: captured.map(|_| json!({})),
        scene: &scene,
        mesh: &mesh,
        solver: "cpu",
        adapter: None,
        settings: &Settings::default(),
        run: &SolveRun {
            emitted: 1.0,
            converged: true,
            field: field.clone(),
            ..SolveRun::default()
        },
        open: None,
        texel_error: None,
        certificate: None,
        error: None,
        warnings: &[],
        notes: &[],
        seconds: PhaseSeconds::default(),
    };
    solution.write(dir).unwrap();
    (mesh, field)
}

#[test]
fn written_solution_is_read_back_bit_for_bit() {
    let folder = Folder::new();
    let dir = folder.path("");
    let (mesh, field) = write(&dir, None);
    let stored = StoredSolution::read(&dir).unwrap();
    let scene = scene();
    assert_eq!(stored.scene.name, scene.name);
    assert_eq!(stored.scene.faces.len(), 4);
    for (read, face) in stored.scene.faces.iter().zip(&scene.faces) {
        assert_eq!((&read.name, read.shape), (&face.name, face.shape));
        assert_eq!(read.corners, face.corners);
        assert_eq!(read.emission, face.emission);
        assert_eq!(read.reflectance, face.reflectance);
        assert_eq!((read.input_face, read.partner), (face.input_face, face.partner));
    }
    assert_eq!(stored.resolutions, vec![[6, 6]; 4]);
    let bits = |v: Vec3| v.to_array().map(f32::to_bits);
    for (k, texel) in mesh.texels.iter().enumerate() {
        let at = stored.texel_range(texel.face as usize).start + texel.index as usize;
        assert_eq!(bits(stored.radiosity[at]), bits(field.radiosity[k].truncate()));
        let others = [("residual", &field.residual), ("irradiance", &field.irradiance)];
        for (name, values) in others {
            assert_eq!(bits(stored.others[name][at]), bits(values[k].truncate()));
        }
        assert_eq!(stored.emission[at], texel.emission);
    }
    assert!(!stored.others.contains_key("error"));
}

/// Returns the error of reading a solution.
fn error(dir: &Path) -> String {
    StoredSolution::read(dir).map(drop).unwrap_err().to_string()
}

/// Changes the description; returns the bytes of the file before.
fn change(dir: &Path, change: impl Fn(&mut Value)) -> Vec<u8> {
    let path = dir.join("result.json");
    let before = fs::read(&path).unwrap();
    let mut description: Value = serde_json::from_slice(&before).unwrap();
    change(&mut description);
    fs::write(&path, description.to_string()).unwrap();
    before
}

/// Returns the error of reading the solution after one change of the description, which is undone.
fn changed(dir: &Path, by: impl Fn(&mut Value)) -> String {
    let before = change(dir, by);
    let message = error(dir);
    fs::write(dir.join("result.json"), before).unwrap();
    message
}

#[test]
fn bad_description_error_names_file_and_face() {
    let folder = Folder::new();
    let dir = folder.path("");
    write(&dir, None);
    for (pointer, part, value) in [
        ("/faces/1/reflectance/1", "result.json: face 1", json!(1)),
        ("/faces/1/reflectance/1", "result.json: face 1", json!(-0.1)),
        ("/faces/1/reflectance", "result.json", json!([0.5, null, 0.5])),
        ("/faces/0/emission/2", "result.json: face 0", json!(-1e-9)),
        ("/lightmap_crc32", "are not of one solve", json!("00000000")),
        ("/faces/1/texels", "result.json: face 1", json!([6, 5])),
        ("/faces/1/texels", "result.json: face 1", json!([7, 7])),
        ("/faces/0/rect", "lightmap.exr: face 0", json!([900, 0, 6, 6])),
        ("/faces/0/rect", "lightmap.exr: face 0", json!([u32::MAX, 0, 6, 6])),
        ("/faces/0/corners/3", "result.json", json!([0, 0])),
        ("/faces/0/kind", "result.json: face 0", json!("triangle")),
        ("/faces/0/emission", "result.json", json!([0, 1e99, 0])),
        ("/faces", "faces", json!([])),
    ] {
        let message = changed(&dir, |d| *d.pointer_mut(pointer).unwrap() = value.clone());
        assert!(message.contains(part), "{pointer}: {message}");
    }
    let many = json!([4_000_000_000u32, 4_000_000_000u32]);
    let message = changed(&dir, |d| {
        d["faces"][0]["texels"] = many.clone();
        d["faces"][0]["rect"] = json!([0, 0, many[0], many[1]]);
    });
    assert!(message.contains("too many texels"), "{message}");
    let message = changed(&dir, |d| *d = json!([1]));
    assert!(message.contains("result.json"), "{message}");
    StoredSolution::read(&dir).unwrap();
}

#[test]
fn captured_emission_by_texel_may_be_negative() {
    let folder = Folder::new();
    let dir = folder.path("");
    let left = Vec3::new(-0.25, 0.5, 0.0);
    write(&dir, Some(left));
    let stored = StoredSolution::read(&dir).unwrap();
    assert!(stored.emission[stored.texel_range(1)].iter().all(|e| *e == left));
    assert!(stored.scene.faces[1].emission.x < 0.0);
    // Without emission by texel the face's emission is read, which must not be negative.
    let message = changed(&dir, |d| d["faces"][1]["reflectance"] = json!([0.5, 0.5, 1.0]));
    assert!(message.contains("face 1"), "{message}");
}

#[test]
fn solution_without_checksum_is_read_with_a_note() {
    let folder = Folder::new();
    let dir = folder.path("");
    write(&dir, None);
    assert!(StoredSolution::read(&dir).unwrap().scene.notes.is_empty());
    change(&dir, |d| drop(d.as_object_mut().unwrap().remove("lightmap_crc32")));
    let notes = StoredSolution::read(&dir).unwrap().scene.notes;
    assert!(notes[0].contains("has no lightmap_crc32"), "{notes:?}");
}

#[test]
fn truncated_or_changed_lightmap_is_an_error() {
    let folder = Folder::new();
    let dir = folder.path("");
    write(&dir, None);
    let path = dir.join("lightmap.exr");
    let bytes = fs::read(&path).unwrap();
    for length in (0..bytes.len()).step_by(11).chain([bytes.len() - 1]) {
        fs::write(&path, &bytes[..length]).unwrap();
        let message = error(&dir);
        assert!(message.contains("lightmap.exr"), "{length}: {message}");
    }
    // The checksum detects a changed byte that the decoder ignores.
    for at in (0..bytes.len()).step_by(7) {
        let mut bytes = bytes.clone();
        bytes[at] ^= 0x55;
        fs::write(&path, &bytes).unwrap();
        assert!(StoredSolution::read(&dir).is_err(), "byte {at}");
    }
    fs::remove_file(&path).unwrap();
    let message = error(&dir);
    assert!(message.contains("cannot be read"), "{message}");
}
