//! What one looks at: `preview.png`, and `view.html` to look around in.

use super::command::{folder, radiosity};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use common::solution::Stored;
use glam::Vec3;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const BOX: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/cornell_box.obj");
/// What a hand does, done by a script; what came of it stands in the page.
const HAND: &str = include_str!("hand.js");
/// Five digits are told.
const TOLD: f32 = 1e-4;

fn solved(name: &str) -> (PathBuf, String) {
    let out = folder(name);
    let path = out.to_str().unwrap();
    let output = radiosity(&["solve", BOX, "--solver", "cpu", "--out", path]);
    assert_eq!(output.status.code(), Some(0));
    let page = fs::read_to_string(out.join("view.html")).unwrap();
    (out, page)
}

/// The text of the element of a class in the page.
fn element<'a>(page: &'a str, class: &str) -> &'a str {
    let start = page.find(&format!("<script class=\"{class}\"")).unwrap();
    let text = &page[start..];
    let text = &text[text.find('>').unwrap() + 1..];
    &text[..text.find("</script>").unwrap()]
}

#[test]
fn the_viewer_holds_what_the_files_hold() {
    let (out, page) = solved("viewer");
    let head: Value = serde_json::from_str(element(&page, "head")).unwrap();
    let bytes = STANDARD.decode(element(&page, "data").trim()).unwrap();
    let [faces, texels] = ["faces", "texels"].map(|of| head[of].as_u64().unwrap() as usize);
    let stored = Stored::read(&out).unwrap();
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

#[test]
fn the_preview_shows_the_scene() {
    let (out, _) = solved("preview");
    let picture = image::open(out.join("preview.png")).unwrap().into_rgba8();
    assert_eq!(picture.dimensions(), (512, 512));
    // Left is the red wall, right the green one; the lamp burns out and nothing else.
    let [left, right] = [40, 472].map(|x| picture.get_pixel(x, 230).0);
    assert!(
        left[0] > 2 * left[1] && right[1] > right[0],
        "{left:?} {right:?}"
    );
    let white = picture.pixels().filter(|p| p.0[..3] == [255; 3]).count();
    assert!((500..5000).contains(&white), "{white}");
    fs::remove_dir_all(out).unwrap();
}

/// The page as `browser` has it once the hand has done its work.
fn looked_at(browser: &str, page: &Path) -> Value {
    let shown = Command::new(browser)
        .args(["--headless=new", "--no-sandbox", "--disable-gpu-sandbox"])
        .args([
            "--use-gl=angle",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
        ])
        .args(["--ignore-gpu-blocklist", "--window-size=1000,900"])
        .args([
            "--disable-background-networking",
            "--virtual-time-budget=20000",
            "--dump-dom",
        ])
        .arg(format!("file://{}", page.display()))
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&shown.stdout).into_owned();
    let Some(start) = text.find("<pre id=\"outcome\">") else {
        panic!("the hand did nothing: {text}");
    };
    let outcome = &text[start + 18..];
    serde_json::from_str(&outcome[..outcome.find("</pre>").unwrap()]).unwrap()
}

#[test]
fn a_hand_can_look_around() {
    let Some(browser) = std::env::var_os("RADIOSITY_BROWSER") else {
        eprintln!("SKIPPED a_hand_can_look_around: RADIOSITY_BROWSER names no browser");
        return;
    };
    let (out, page) = solved("hand");
    let file = out.join("hand.html");
    fs::write(
        &file,
        page.replace("</body>", &format!("<script>{HAND}</script></body>")),
    )
    .unwrap();
    let did = looked_at(browser.to_str().unwrap(), &file);
    assert_eq!(did["failed"], Value::Null, "{did}");

    let stored = Stored::read(&out).unwrap();
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
    // Whatever was done, the picture was another one.
    assert_eq!(pictures.len(), drawn.len(), "{did}");
    fs::remove_dir_all(out).unwrap();
}
