//! `preview.png` and the viewer of `view.html`.

use super::browser::{browser_for, page_outcome, with_script};
use super::command::TestFolder;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use common::import::from_srgb;
use common::mesh::Mesh;
use common::solution::StoredSolution;
use glam::{DVec3, Vec3, Vec4};
use radiosity::report::view::interpolation::InterpolationSurface;
use serde_json::{Value, json};

/// A script that moves the pointer and presses keys, and hands the outcome over.
const HAND: &str = include_str!("hand.js");
/// Relative tolerance: the viewer prints five digits.
const TOLD: f32 = 1e-4;

/// Makes a folder with the Cornell box, solved, in `box`.
fn folder_with_box() -> TestFolder {
    let folder = TestFolder::new();
    folder.succeed("solve scenes/cornell_box.obj --solver cpu --error 5% --out box");
    folder
}

/// The data of a page's viewer.
struct ViewerData {
    head: Value,
    bytes: Vec<u8>,
    /// Place of the layers in the floats, behind the faces and their materials.
    layers: usize,
}

impl ViewerData {
    fn new(page: &str) -> Self {
        let element = |class: &str| {
            let start = page.find(&format!("<script class=\"{class}\"")).unwrap();
            let text = &page[start..];
            let text = &text[text.find('>').unwrap() + 1..];
            &text[..text.find("</script>").unwrap()]
        };
        let head: Value = serde_json::from_str(element("head")).unwrap();
        let bytes = STANDARD.decode(element("data").trim()).unwrap();
        let of = |name: &str| head[name].as_u64().unwrap() as usize;
        let each = if head["by_texel"] == true { "texels" } else { "faces" };
        let layers = of("faces") * (12 + 4) + of("surfaces") * 6 * of(each);
        Self { head, bytes, layers }
    }

    fn count(&self, name: &str) -> usize {
        self.head[name].as_u64().unwrap() as usize
    }

    /// Returns the vector at the `k`th float.
    fn vector(&self, k: usize) -> Vec3 {
        let at = |k: usize| f32::from_le_bytes(self.bytes[4 * k..4 * k + 4].try_into().unwrap());
        Vec3::new(at(k), at(k + 1), at(k + 2))
    }

    /// Returns the radiosity of texel `k` of the first layer.
    fn radiosity(&self, k: usize) -> Vec3 {
        self.vector(self.layers + 6 * k)
    }
}

#[test]
fn viewer_data_equal_result_files() {
    let folder = folder_with_box();
    let page = folder.read_text("box/view.html");
    let data = ViewerData::new(&page);
    let (faces, texels) = (data.count("faces"), data.count("texels"));
    let stored = StoredSolution::read(&folder.path("box")).unwrap();
    assert_eq!((faces, texels), (17, stored.radiosity.len()));
    assert_eq!(data.head["off"], true);
    let nodes = 8 * data.count("joins") + 12 * data.count("knots") + 6 * data.count("nodes");
    assert_eq!(data.bytes.len(), 4 * (faces * (12 + 4 + 6) + texels * (6 + 1)) + nodes);
    // A node has half the bytes of B and H of its texel at most.
    assert!(nodes < 4 * 6 * texels / 2, "{nodes}");
    let irradiance = &stored.others["irradiance"];
    for (k, (b, h)) in stored.radiosity.iter().zip(irradiance).enumerate() {
        assert_eq!(data.radiosity(k), *b, "texel {k}");
        assert_eq!(data.vector(data.layers + 6 * k + 3), *h, "texel {k}");
    }
    assert!(stored.radiosity.iter().any(|b| *b != stored.radiosity[0]));
    assert!(!page.contains("http:") && !page.contains("https:") && !page.contains("src="));

    let picture = image::open(folder.path("box/preview.png")).unwrap().into_rgba8();
    assert_eq!(picture.dimensions(), (512, 512));
    // The red wall is left, the green one right; only the lamp is clipped.
    let [left, right] = [40, 472].map(|x| picture.get_pixel(x, 230).0);
    assert!(left[0] > 2 * left[1] && right[1] > right[0], "{left:?} {right:?}");
    let white = picture.pixels().filter(|p| p.0[..3] == [255; 3]).count();
    assert!((500..5000).contains(&white), "{white}");
}

/// Returns the RMS difference of two pictures over the RMS of the second, linear, where the second is not clipped.
fn relative_difference(folder: &TestFolder, pictures: [&str; 2]) -> f64 {
    let [a, b] = pictures.map(|name| image::open(folder.path(name)).unwrap().into_rgba8());
    assert_eq!(a.dimensions(), b.dimensions());
    let (mut difference, mut light) = (0.0, 0.0);
    for (a, b) in a.pixels().zip(b.pixels()).filter(|(_, b)| b.0[..3] != [255; 3]) {
        for c in 0..3 {
            let [a, b] = [a, b].map(|pixel| from_srgb(f32::from(pixel.0[c]) / 255.0));
            difference += (a - b).powi(2);
            light += b * b;
        }
    }
    (difference / light).sqrt()
}

/// Texels are small enough that light between them, shadows' edges included, is as accurate as requested.
#[test]
fn picture_is_as_accurate_as_requested() {
    let folder = TestFolder::new();
    folder.succeed("solve scenes/cornell_box.obj --solver cpu --error 2% --out box");
    folder.succeed("solve scenes/cornell_box.obj --solver cpu --error 1% --texels 64 --out fine");
    let difference = relative_difference(&folder, ["box/preview.png", "fine/preview.png"]);
    assert!(difference > 0.001 && difference < 0.02, "{difference}");
}

/// A captured room has its own ρ and E in each texel, which the viewer must show.
#[test]
fn viewer_of_relit_room_has_materials_of_each_texel() {
    let folder = folder_with_box();
    let object = "--object scenes/paper_objects.obj --scale 100 --place 200,0,200";
    let relight = format!("relight --room box {object} --solver cpu --patches 1 --samples 1");
    folder.succeed(&relight);
    assert_eq!(folder.read_json("out/result.json")["method"], "signed");
    assert!(image::open(folder.path("out/preview.png")).is_ok());
    let stored = StoredSolution::read(&folder.path("out")).unwrap();
    for file in ["out/view.html", "out/report.html"] {
        let data = ViewerData::new(&folder.read_text(file));
        assert_eq!(data.head["texels"], stored.radiosity.len(), "{file}");
        assert_eq!(data.head["by_texel"], true, "{file}");
        for (k, b) in stored.radiosity.iter().enumerate() {
            assert_eq!(data.radiosity(k), *b, "{file}: texel {k}");
            let own = 16 * data.count("faces") + 6 * k;
            assert_eq!(data.vector(own), stored.emission[k], "{file}: texel {k}");
            let rho = stored.others["reflectance"][k];
            assert_eq!(data.vector(own + 3), rho, "{file}: texel {k}");
        }
    }
}

#[test]
fn diff_viewer_has_both_results_and_their_difference() {
    let folder = folder_with_box();
    let shoot = "shoot scenes/cornell_box.obj --solver cpu --texels 4 --patches 1 --samples 1 --out rough";
    folder.succeed(shoot);
    folder.succeed("diff box rough");
    let page = folder.read_text("out/diff.html");
    let data = ViewerData::new(&page);
    assert_eq!(data.head["layers"], json!(["A", "B"]));
    assert_eq!(data.head["difference"], json!([0, 1]));
    assert!(page.contains("data-what=\"difference\"") && page.contains("A − B"));
    let texels = data.count("texels");
    let different = (0..texels).filter(|k| data.radiosity(*k) != data.radiosity(texels + k));
    assert!(different.count() > texels / 2);
    // Without a difference there is no picture of it.
    folder.succeed("diff box box");
    let page = folder.read_text("out/diff.html");
    assert!(page.contains("No texel differs") && !page.contains("data-what=\"difference\""));
    let data = ViewerData::new(&page);
    let stored = StoredSolution::read(&folder.path("box")).unwrap();
    for (k, b) in stored.radiosity.iter().enumerate() {
        assert_eq!(data.radiosity(k), *b, "texel {k}");
    }
}

#[test]
fn viewer_reacts_to_pointer_and_keys() {
    let Some(browser) = browser_for("viewer_reacts_to_pointer_and_keys") else {
        return;
    };
    let folder = folder_with_box();
    let page = folder.read_text("box/view.html");
    folder.write("hand.html", with_script(&page, HAND));
    let did = page_outcome(&browser, &folder.path("hand.html"));
    assert_eq!(did["failed"], Value::Null, "{did}");

    let stored = StoredSolution::read(&folder.path("box")).unwrap();
    let hovered = did["hovered"].as_array().unwrap();
    let mut seen = 0;
    for own in hovered.iter().filter(|own| own["texel"].is_u64()) {
        let told = own["told"].as_str().unwrap().split_whitespace();
        let told: Vec<f32> = told.map(|x| x.parse().unwrap()).collect();
        let known = stored.radiosity[own["texel"].as_u64().unwrap() as usize];
        let off = (Vec3::from_slice(&told) - known).abs();
        assert!(off.cmple(known.abs() * TOLD).all(), "{own} {known}");
        seen += 1;
    }
    assert!(seen >= 20, "{seen} of {} points met a texel", hovered.len());
    // The light at the viewer's vertices is that of the preview, to the 11 bits of the data.
    let mesh = Mesh::new(&stored.scene, &stored.resolutions, 1).unwrap();
    let surface = InterpolationSurface::new(&stored.scene, &mesh);
    let order = mesh.texels_in_face_order();
    let mut irradiance = vec![Vec4::ZERO; order.len()];
    for (k, h) in order.iter().zip(&stored.others["irradiance"]) {
        irradiance[*k] = h.extend(0.0);
    }
    let field = surface.interpolate_irradiance(&irradiance);
    let vertices = did["vertices"].as_array().unwrap();
    assert!(vertices.len() > 300);
    for vertex in vertices {
        let vertex: Vec<f64> = vertex.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        let texel = order[vertex[0] as usize] as u32;
        let stencil = surface.stencil_at(texel, DVec3::from_slice(&vertex[1..4]));
        let (drawn, light) = (
            DVec3::from_slice(&vertex[4..7]),
            field.radiosity_at(&stencil).as_dvec3(),
        );
        assert!(
            (drawn - light).abs().max_element() <= 1e-3 * light.max_element() + 1e-6,
            "{vertex:?} {light}"
        );
    }
    let drawn = did["drawn"].as_object().unwrap();
    let mut pictures: Vec<&str> = drawn.values().map(|sum| sum.as_str().unwrap()).collect();
    pictures.sort_unstable();
    pictures.dedup();
    // Every action changed the picture.
    assert_eq!(pictures.len(), drawn.len(), "{did}");
}

/// Points at a canvas in rows and columns, and hands over the texels.
const POINT_EVERYWHERE: &str = "
  const viewer = document.querySelector('.viewer').open();
  const { clientWidth, clientHeight } = viewer.canvas;
  const texels = [];
  for (let j = 0; j < 24; j++) for (let i = 0; i < 24; i++) {
    texels.push(viewer.pick((i + 0.5) / 24 * clientWidth, (j + 0.5) / 24 * clientHeight));
  }
  hand_over(texels);
";

/// A lamp in the plane of a ceiling, after it in the file, hides what lies under it.
#[test]
fn lamp_in_the_plane_of_a_ceiling_is_drawn_before_it() {
    let Some(browser) = browser_for("lamp_in_the_plane_of_a_ceiling_is_drawn_before_it") else {
        return;
    };
    let folder = TestFolder::new();
    let quads = [
        "0 0 0  0 0 2  2 0 2  2 0 0",
        "0 2 0  2 2 0  2 2 2  0 2 2",
        "0 0 0  2 0 0  2 2 0  0 2 0",
        "0.3 2 0.2  1.8 2 0.2  1.8 2 1.9  0.3 2 1.9",
    ];
    let mut text = String::from("mtllib flush.mtl\n");
    for (k, quad) in quads.iter().enumerate() {
        let numbers: Vec<&str> = quad.split_whitespace().collect();
        numbers
            .chunks(3)
            .for_each(|corner| text += &format!("v {}\n", corner.join(" ")));
        let material = if k == 3 { "lamp" } else { "wall" };
        text += &format!("usemtl {material}\nf -4 -3 -2 -1\n");
    }
    folder.write("flush.obj", text);
    folder.write("flush.mtl", "newmtl wall\nKd 0.5 0.5 0.5\nnewmtl lamp\nKe 1 1 1\n");
    folder.succeed("solve flush.obj --solver cpu --error 5% --out flush");
    let page = folder.read_text("flush/view.html");
    folder.write("pointed.html", with_script(&page, POINT_EVERYWHERE));
    let texels = page_outcome(&browser, &folder.path("pointed.html"));
    let stored = StoredSolution::read(&folder.path("flush")).unwrap();
    let mesh = Mesh::new(&stored.scene, &stored.resolutions, 1).unwrap();
    let order = mesh.texels_in_face_order();
    let (mut lamp, mut covered) = (0, 0);
    for k in texels.as_array().unwrap().iter().filter_map(Value::as_u64) {
        let texel = &mesh.texels[order[k as usize]];
        if texel.emission != Vec3::ZERO {
            lamp += 1;
        } else if texel.face == 1 && stored.others["irradiance"][k as usize] == Vec3::ZERO {
            covered += 1;
        }
    }
    assert!(lamp > 20, "{lamp} points of the lamp");
    assert_eq!(covered, 0, "beside {lamp} points of the lamp");
}
