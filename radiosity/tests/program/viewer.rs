//! `preview.png` and the viewer of `view.html`.

use super::browser::{browser_for, page_outcome};
use super::command::{empty_folder, run_radiosity};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use common::solution::StoredSolution;
use glam::Vec3;
use serde_json::Value;
use std::fs;
use std::path::PathBuf;

const BOX: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/cornell_box.obj");
/// A script that moves the pointer and presses keys, and writes the outcome into the page.
const HAND: &str = include_str!("hand.js");
/// Relative tolerance: the viewer prints five digits.
const TOLD: f32 = 1e-4;

fn solve_box(name: &str) -> (PathBuf, String) {
    let out = empty_folder(name);
    let path = out.to_str().unwrap();
    let output = run_radiosity(&["solve", BOX, "--solver", "cpu", "--out", path]);
    assert_eq!(output.status.code(), Some(0));
    let page = fs::read_to_string(out.join("view.html")).unwrap();
    (out, page)
}

/// Returns the text of the element of a class in the page.
fn page_element<'a>(page: &'a str, class: &str) -> &'a str {
    let start = page.find(&format!("<script class=\"{class}\"")).unwrap();
    let text = &page[start..];
    let text = &text[text.find('>').unwrap() + 1..];
    &text[..text.find("</script>").unwrap()]
}

#[test]
fn viewer_data_equal_result_files() {
    let (out, page) = solve_box("viewer");
    let head: Value = serde_json::from_str(page_element(&page, "head")).unwrap();
    let bytes = STANDARD.decode(page_element(&page, "data").trim()).unwrap();
    let [faces, texels] = ["faces", "texels"].map(|of| head[of].as_u64().unwrap() as usize);
    let stored = StoredSolution::read(&out).unwrap();
    assert_eq!((faces, texels), (17, stored.radiosity.len()));
    assert_eq!(head["off"], true);
    assert_eq!(bytes.len(), 4 * (faces * (12 + 4 + 6) + texels * (6 + 1)));

    let at = |k: usize| f32::from_le_bytes(bytes[4 * k..4 * k + 4].try_into().unwrap());
    let three = |k: usize| Vec3::new(at(k), at(k + 1), at(k + 2));
    let first = faces * (12 + 4 + 6);
    let irradiance = &stored.others["irradiance"];
    for (k, (b, h)) in stored.radiosity.iter().zip(irradiance).enumerate() {
        assert_eq!(three(first + 6 * k), *b, "texel {k}");
        assert_eq!(three(first + 6 * k + 3), *h, "texel {k}");
    }
    assert!(stored.radiosity.iter().any(|b| *b != stored.radiosity[0]));
    assert!(!page.contains("http:") && !page.contains("https:") && !page.contains("src="));
    fs::remove_dir_all(out).unwrap();
}

/// Returns header and bytes of the viewer's data in `page`, and the offset of its layers.
fn viewer_data(page: &str) -> (Value, Vec<u8>, usize) {
    let head: Value = serde_json::from_str(page_element(page, "head")).unwrap();
    let bytes = STANDARD.decode(page_element(page, "data").trim()).unwrap();
    let [faces, texels, sets] = ["faces", "texels", "surfaces"].map(|of| head[of].as_u64().unwrap() as usize);
    let each = match head["by_texel"].as_bool().unwrap() {
        true => texels,
        false => faces,
    };
    (head, bytes, faces * (12 + 4) + sets * 6 * each)
}

fn read_vec3(bytes: &[u8], k: usize) -> Vec3 {
    let at = |k: usize| f32::from_le_bytes(bytes[4 * k..4 * k + 4].try_into().unwrap());
    Vec3::new(at(k), at(k + 1), at(k + 2))
}

/// A captured room has its own ρ and E in each texel, which the viewer must show.
#[test]
fn viewer_of_relit_room_has_materials_of_each_texel() {
    let (out, _) = solve_box("relit-room");
    let relit = empty_folder("relit");
    let [from, to] = [out.to_str().unwrap(), relit.to_str().unwrap()];
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/paper_objects.obj");
    let output = run_radiosity(&[
        "relight",
        "--room",
        from,
        "--object",
        scene,
        "--scale",
        "100",
        "--place",
        "200,0,200",
        "--solver",
        "cpu",
        "--patches",
        "1",
        "--samples",
        "1",
        "--json",
        "--out",
        to,
    ]);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{errors}");
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(told["method"], "signed");
    assert!(image::open(relit.join("preview.png")).is_ok());
    let stored = StoredSolution::read(&relit).unwrap();
    for file in ["view.html", "report.html"] {
        let page = fs::read_to_string(relit.join(file)).unwrap();
        let (head, bytes, first) = viewer_data(&page);
        assert_eq!(head["texels"], stored.radiosity.len(), "{file}");
        assert_eq!(head["by_texel"], true, "{file}");
        for (k, b) in stored.radiosity.iter().enumerate() {
            assert_eq!(read_vec3(&bytes, first + 6 * k), *b, "{file}: texel {k}");
            let own = 16 * head["faces"].as_u64().unwrap() as usize + 6 * k;
            assert_eq!(read_vec3(&bytes, own), stored.emission[k], "{file}: texel {k}");
            let rho = stored.others["reflectance"][k];
            assert_eq!(read_vec3(&bytes, own + 3), rho, "{file}: texel {k}");
        }
    }
    fs::remove_dir_all(out).unwrap();
    fs::remove_dir_all(relit).unwrap();
}

#[test]
fn diff_viewer_has_both_results_and_their_difference() {
    let (a, _) = solve_box("diff-a");
    let b = empty_folder("diff-b");
    let out = empty_folder("diff-out");
    let [from, truth, to] = [&a, &b, &out].map(|dir| dir.to_str().unwrap());
    let grid = ["--texels", "4", "--patches", "1", "--samples", "1"];
    run_radiosity(&[&["shoot", BOX, "--solver", "cpu", "--out", truth], &grid[..]].concat());
    run_radiosity(&["diff", from, truth, "--out", to]);
    let page = fs::read_to_string(out.join("diff.html")).unwrap();
    let (head, bytes, first) = viewer_data(&page);
    assert_eq!(head["layers"], serde_json::json!(["A", "B"]));
    assert_eq!(head["difference"], serde_json::json!([0, 1]));
    assert!(page.contains("data-what=\"difference\"") && page.contains("A − B"));
    let texels = head["texels"].as_u64().unwrap() as usize;
    let different =
        (0..texels).filter(|k| read_vec3(&bytes, first + 6 * k) != read_vec3(&bytes, first + 6 * (texels + k)));
    assert!(different.count() > texels / 2);
    // Without a difference there is no picture of it.
    run_radiosity(&["diff", from, from, "--out", to]);
    let page = fs::read_to_string(out.join("diff.html")).unwrap();
    assert!(page.contains("No texel differs") && !page.contains("data-what=\"difference\""));
    let (_, bytes, first) = viewer_data(&page);
    let stored = StoredSolution::read(&a).unwrap();
    for (k, b) in stored.radiosity.iter().enumerate() {
        assert_eq!(read_vec3(&bytes, first + 6 * k), *b, "texel {k}");
    }
    for dir in [a, b, out] {
        fs::remove_dir_all(dir).unwrap();
    }
}

#[test]
fn preview_shows_walls_and_lamp() {
    let (out, _) = solve_box("preview");
    let picture = image::open(out.join("preview.png")).unwrap().into_rgba8();
    assert_eq!(picture.dimensions(), (512, 512));
    // The red wall is left, the green one right; only the lamp is clipped.
    let [left, right] = [40, 472].map(|x| picture.get_pixel(x, 230).0);
    assert!(left[0] > 2 * left[1] && right[1] > right[0], "{left:?} {right:?}");
    let white = picture.pixels().filter(|p| p.0[..3] == [255; 3]).count();
    assert!((500..5000).contains(&white), "{white}");
    fs::remove_dir_all(out).unwrap();
}

#[test]
fn viewer_reacts_to_pointer_and_keys() {
    let Some(browser) = browser_for("viewer_reacts_to_pointer_and_keys") else {
        return;
    };
    let (out, page) = solve_box("hand");
    let file = out.join("hand.html");
    fs::write(
        &file,
        page.replace("</body>", &format!("<script>{HAND}</script></body>")),
    )
    .unwrap();
    let did = page_outcome(&browser, &file);
    assert_eq!(did["failed"], Value::Null, "{did}");

    let stored = StoredSolution::read(&out).unwrap();
    let hovered = did["hovered"].as_array().unwrap();
    let mut seen = 0;
    for own in hovered.iter().filter(|own| own["texel"].is_u64()) {
        let told: Vec<f32> = own["told"]
            .as_str()
            .unwrap()
            .split_whitespace()
            .map(|x| x.parse().unwrap())
            .collect();
        let known = stored.radiosity[own["texel"].as_u64().unwrap() as usize];
        let off = (Vec3::from_slice(&told) - known).abs();
        assert!(off.cmple(known.abs() * TOLD).all(), "{own} {known}");
        seen += 1;
    }
    assert!(seen >= 20, "{seen} of {} points met a texel", hovered.len());
    let drawn = did["drawn"].as_object().unwrap();
    let mut pictures: Vec<&str> = drawn.values().map(|sum| sum.as_str().unwrap()).collect();
    pictures.sort_unstable();
    pictures.dedup();
    // Every action changed the picture.
    assert_eq!(pictures.len(), drawn.len(), "{did}");
    fs::remove_dir_all(out).unwrap();
}
