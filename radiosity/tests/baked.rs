//! Light in the pixels of baked charts.

use super::program::bake::FLOOR;
use super::program::command::TestFolder;
use common::import::{ImportOptions, SceneFile, load_scene_file};
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::shooting::RadiosityField;
use common::solution::pixels::ImagePlanes;
use cpu::hierarchy::solver::open_shares;
use glam::{DVec2, DVec3, Mat4, Vec2, Vec3};
use radiosity::report::gltf_export::uv_charts::{UvCharts, find_overlap};
use radiosity::report::gltf_export::{ExportCharts, GltfExport, export_lightmap};
use radiosity::report::picture::Exposure;
use radiosity_tests::named_scene;
use serde_json::Value;
use std::path::Path;

fn field_of_light(mesh: &Mesh, light: impl Fn(DVec3) -> f32) -> RadiosityField {
    // The mesh has another origin and unit.
    let at = |k: usize| mesh.texels[k].position.as_dvec3() * mesh.unit + mesh.origin;
    let light = (0..mesh.texels.len()).map(|k| Vec3::splat(light(at(k))).extend(0.0));
    let light: Vec<_> = light.collect();
    RadiosityField {
        origin: "made".into(),
        radiosity: light.clone(),
        residual: light.clone(),
        irradiance: light,
    }
}

/// The triangles of a baked scene: corners in the scene with their lightmap coordinates.
pub struct BakedScene {
    pub triangles: Vec<[(Vec3, Vec2); 3]>,
    /// The document's JSON.
    pub json: Value,
    /// The PNG file of the lightmap.
    pub picture: Vec<u8>,
}

impl BakedScene {
    pub fn new(glb: &[u8]) -> Self {
        let document = gltf::Gltf::from_slice_without_validation(glb).unwrap();
        let blob = document.blob.as_deref().unwrap();
        let mut triangles = Vec::new();
        let mut nodes: Vec<_> = document
            .default_scene()
            .unwrap()
            .nodes()
            .map(|n| (n, Mat4::IDENTITY))
            .collect();
        nodes.reverse();
        while let Some((node, parent)) = nodes.pop() {
            let world = parent * Mat4::from_cols_array_2d(&node.transform().matrix());
            for primitive in node.mesh().iter().flat_map(|mesh| mesh.primitives()) {
                let reader = primitive.reader(|_| Some(blob));
                let places = reader.read_positions().unwrap();
                let places: Vec<_> = places.map(|p| world.transform_point3(p.into())).collect();
                // Points have no light.
                let Some(uvs) = reader.read_tex_coords(1) else {
                    continue;
                };
                let uvs = uvs.into_f32();
                let corners: Vec<_> = places.iter().copied().zip(uvs.map(Vec2::from)).collect();
                assert_eq!(corners.len(), places.len());
                let index: Vec<u32> = match reader.read_indices() {
                    Some(indices) => indices.into_u32().collect(),
                    None => (0..corners.len() as u32).collect(),
                };
                let turned = world.determinant() < 0.0;
                triangles.extend(index.as_chunks::<3>().0.iter().map(|triangle| {
                    let [a, b, c] = triangle.map(|k| corners[k as usize]);
                    if turned { [a, c, b] } else { [a, b, c] }
                }));
            }
            nodes.extend(
                node.children()
                    .map(|child| (child, world))
                    .collect::<Vec<_>>()
                    .into_iter()
                    .rev(),
            );
        }
        let image = document
            .images()
            .find(|image| image.name() == Some("lightmap"))
            .unwrap();
        let gltf::image::Source::View { view, .. } = image.source() else {
            panic!("the picture is not in the file");
        };
        let picture = blob[view.offset()..view.offset() + view.length()].to_vec();
        let json = serde_json::from_slice(&gltf::Glb::from_slice(glb).unwrap().json).unwrap();
        Self {
            triangles,
            json,
            picture,
        }
    }

    /// Returns the lightmap coordinates of a point of triangle `k`.
    pub fn place_on_chart(&self, k: usize, point: Vec3) -> Vec2 {
        let [(_, at_a), (_, at_b), (_, at_c)] = self.triangles[k];
        let [a, b, c] = self.corner_weights(k, point);
        at_a * a + at_b * b + at_c * c
    }

    fn corner_weights(&self, k: usize, point: Vec3) -> [f32; 3] {
        let [(a, _), (b, _), (c, _)] = self.triangles[k];
        let normal = (b - a).cross(c - a);
        let share = |p: Vec3, q: Vec3| normal.dot((q - p).cross(point - p)) / normal.length_squared();
        [share(b, c), share(c, a), share(a, b)]
    }

    /// Returns the lightmap coordinates of a point of a face with this normal.
    fn find_point(&self, point: Vec3, normal: Vec3) -> Vec2 {
        let off = |k: &usize| {
            let [(a, _), (b, _), (c, _)] = self.triangles[*k];
            let own = (b - a).cross(c - a).normalize_or_zero();
            let beyond = self
                .corner_weights(*k, point)
                .into_iter()
                .fold(0.0f32, |off, share| off.max(-share));
            beyond + (point - a).dot(own).abs() + 10.0 * (1.0 - own.dot(normal))
        };
        let nearest = (0..self.triangles.len())
            .min_by(|a, b| off(a).total_cmp(&off(b)))
            .unwrap();
        assert!(off(&nearest) < 1e-3, "{point} {normal}: {}", off(&nearest));
        self.place_on_chart(nearest, point)
    }

    /// Returns the width in the scene of a pixel of a lightmap of `side` pixels, the widest of all charts.
    fn pixel_width(&self, side: f32) -> f32 {
        let stretch = |[(a, at_a), (b, at_b), _]: &[(Vec3, Vec2); 3]| a.distance(*b) / at_a.distance(*at_b);
        self.triangles.iter().map(stretch).fold(0.0, f32::max) / side
    }

    /// Returns the share of the lightmap on charts.
    fn covered_share(&self) -> f32 {
        let area = |[(_, a), (_, b), (_, c)]: &[(Vec3, Vec2); 3]| (*b - *a).perp_dot(*c - *a).abs() / 2.0;
        self.triangles.iter().map(area).sum()
    }

    fn assert_no_overlap(&self) {
        let place = |uv: Vec2| uv.as_dvec2();
        let outline = |[a, b, c]: &[(Vec3, Vec2); 3]| [a.1, b.1, c.1, c.1].map(place);
        let charts: Vec<(usize, [DVec2; 4])> = self.triangles.iter().map(outline).enumerate().collect();
        assert_eq!(find_overlap(&charts), None);
    }
}

/// A lightmap's colours, sampled as by other programs.
pub struct LightPicture {
    /// Pixels in x and y.
    pub size: Vec2,
    pixels: Vec<Vec3>,
}

impl LightPicture {
    /// Reads the channels `prefix`R, G and B of an OpenEXR file.
    pub fn new(exr: &[u8], prefix: &str) -> Self {
        let planes = ImagePlanes::decode("light.exr".as_ref(), exr, 1 << 26).unwrap();
        let [r, g, b] = planes.colour_planes(prefix).unwrap();
        Self {
            size: Vec2::new(planes.width as f32, planes.height as f32),
            pixels: (0..r.len()).map(|k| Vec3::new(r[k], g[k], b[k])).collect(),
        }
    }

    /// Returns the colour of a pixel, clamped to the picture.
    pub fn pixel(&self, at: Vec2) -> Vec3 {
        let at = at.clamp(Vec2::ZERO, self.size - 1.0);
        self.pixels[(at.y * self.size.x + at.x) as usize]
    }

    /// Interpolates between pixels.
    pub fn at(&self, uv: Vec2) -> Vec3 {
        let p = uv * self.size - 0.5;
        let (corner, share) = (p.floor(), p - p.floor());
        let row = |y: f32| {
            let [left, right] = [0., 1.].map(|x| self.pixel(corner + Vec2::new(x, y)));
            left.lerp(right, share.x)
        };
        row(0.).lerp(row(1.), share.y)
    }
}

/// Light that differs everywhere, and changes by at most [`LIGHT_SLOPE`] per unit of the mesh.
fn light_of_place(mesh: &Mesh, p: DVec3) -> f32 {
    let p = (p - mesh.origin) / mesh.unit;
    (20.0 + p.x + 2.0 * p.y - 3.0 * p.z) as f32
}

/// √(1 + 4 + 9).
const LIGHT_SLOPE: f32 = 3.741_657_4;

fn load(path: &Path, options: &ImportOptions) -> (Scene, SceneFile) {
    load_scene_file(path, options).unwrap_or_else(|error| panic!("{error}"))
}

/// Bakes [`light_of_place`], this share of it on parts that a body covers, on charts of `density`; returns the result with the mesh of the light.
fn bake_light(
    (scene, file): (&Scene, SceneFile),
    sides: u32,
    density: Option<f64>,
    on_covered: f32,
) -> (GltfExport, Mesh) {
    let mesh = Mesh::uniform(scene, sides, 1).unwrap();
    let mut field = field_of_light(&mesh, |p| light_of_place(&mesh, p));
    // H is the mean over the whole area.
    for (h, open) in field.irradiance.iter_mut().zip(open_shares(scene, &mesh)) {
        *h *= open + on_covered * (1.0 - open);
    }
    let charts = ExportCharts::Packed(density);
    let baked = export_lightmap((scene, file), charts, (&mesh, &field), Exposure::with_white(1.0)).unwrap();
    (baked, mesh)
}

/// Asserts that the place of each open texel on the lightmap has its light.
fn assert_texels_baked(scene: &Scene, baked: &GltfExport, mesh: &Mesh) {
    let light = LightPicture::new(&baked.exr, "irradiance.");
    let written = BakedScene::new(&baked.glb);
    let pixel = written.pixel_width(light.size.x);
    let open = open_shares(scene, mesh);
    for (texel, _) in mesh.texels.iter().zip(open).filter(|(_, open)| *open == 1.0) {
        let point = texel.position.as_dvec3() * mesh.unit + mesh.origin;
        let uv = written.find_point(point.as_vec3(), mesh.faces[texel.face as usize].normal);
        let [found, expected] = [light.at(uv).x, light_of_place(mesh, point)];
        // Light bends at texels on the outline of a surface; between pixels it is bilinear.
        let tolerance = LIGHT_SLOPE * pixel / mesh.unit as f32;
        assert!(
            (found - expected).abs() < tolerance,
            "{point}: {found} {expected} ± {tolerance}"
        );
    }
}

fn bundled(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(name)
}

/// Returns an OBJ of a room with tables, shelves and a lamp, of boxes.
fn furnished_room() -> String {
    let mut text = String::from("mtllib room.mtl\n");
    let mut count = 0;
    let mut add = |name: &str, low: [f64; 3], high: [f64; 3], inside: bool| {
        text += &format!("o {name}\nusemtl {name}\n");
        for k in 0..8 {
            let [x, y, z] = [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { low[axis] } else { high[axis] });
            text += &format!("v {x} {y} {z}\n");
        }
        for side in [
            [1, 3, 4, 2],
            [5, 6, 8, 7],
            [1, 2, 6, 5],
            [3, 7, 8, 4],
            [1, 5, 7, 3],
            [2, 4, 8, 6],
        ] {
            let mut side = side.map(|k: u32| (k + count).to_string());
            if inside {
                side.reverse();
            }
            text += &format!("f {}\n", side.join(" "));
        }
        count += 8;
    };
    add("walls", [0., 0., 0.], [6., 3., 5.], true);
    add("lamp", [2.5, 2.8, 2.], [3.5, 2.9, 3.], false);
    for (k, at) in [[0.5, 0.5], [2.5, 0.7], [4.2, 3.], [1., 3.2]].into_iter().enumerate() {
        let [x, z] = at;
        add("table", [x, 0.7, z], [x + 1.4, 0.75, z + 0.8], false);
        for [dx, dz] in [[0., 0.], [1.33, 0.], [0., 0.73], [1.33, 0.73]] {
            add("leg", [x + dx, 0., z + dz], [x + dx + 0.07, 0.7, z + dz + 0.07], false);
        }
        let at = 0.2 + 1.3 * k as f64;
        for height in 0..4 {
            let y = 0.4 + 0.5 * f64::from(height);
            add("shelf", [at, y, 4.6], [at + 1.1, y + 0.03, 4.95], false);
        }
    }
    text
}

fn furnished_folder() -> TestFolder {
    let folder = TestFolder::new();
    folder.write("room.obj", furnished_room());
    let names = ["walls", "lamp", "table", "leg", "shelf"];
    folder.write(
        "room.mtl",
        names.map(|name| format!("newmtl {name}\nKd .5 .5 .5\n")).concat(),
    );
    folder
}

#[test]
fn texels_are_on_their_place_of_the_chart_and_no_pixel_is_black() {
    let folder = furnished_folder();
    for (path, sides, two_sided) in [
        (bundled("cornell_box.obj"), 8, false),
        (bundled("cornell_box.obj"), 8, true),
        (bundled("paper_room_objects.obj"), 6, false),
        (folder.path("room.obj"), 3, false),
    ] {
        let options = ImportOptions {
            two_sided,
            ..ImportOptions::default()
        };
        let (scene, file) = load(&path, &options);
        let (baked, mesh) = bake_light((&scene, file), sides, None, 0.0);
        assert_texels_baked(&scene, &baked, &mesh);
        let (scene, file) = load(&path, &options);
        let (baked, _) = bake_light((&scene, file), sides, None, 1.0);
        let light = LightPicture::new(&baked.exr, "irradiance.");
        let black = light.pixels.iter().filter(|pixel| pixel.x < 1.0).count();
        assert_eq!(black, 0, "light is at least 14");
    }
}

#[test]
fn charts_cover_60_per_cent_of_rooms_and_do_not_overlap() {
    let folder = furnished_folder();
    for path in [
        bundled("cornell_box.obj"),
        bundled("paper_room.obj"),
        bundled("room.glb"),
        folder.path("room.obj"),
    ] {
        let (scene, file) = load(&path, &ImportOptions::default());
        let (baked, _) = bake_light((&scene, file), 8, None, 0.0);
        let baked = BakedScene::new(&baked.glb);
        let share = baked.covered_share();
        assert!((0.6..1.0).contains(&share), "{}: {share}", path.display());
        baked.assert_no_overlap();
    }
}

#[test]
fn lightmap_has_the_texels_per_metre_that_are_asked_for() {
    let (scene, file) = load(&bundled("paper_room.obj"), &ImportOptions::default());
    let (baked, _) = bake_light((&scene, file), 4, Some(25.0), 0.0);
    let width = LightPicture::new(&baked.exr, "").size.x;
    let scene = BakedScene::new(&baked.glb);
    let [(a, at_a), (b, at_b), _] = scene.triangles[0];
    let density = at_a.distance(at_b) * width / a.distance(b);
    // A chart has a whole number of pixels.
    assert!((density - 25.0).abs() <= 1.0 / a.distance(b), "{density}");
    assert!(baked.notes.is_empty(), "{:?}", baked.notes);
    let (scene, file) = load(&bundled("paper_room.obj"), &ImportOptions::default());
    let (baked, _) = bake_light((&scene, file), 4, Some(1e6), 0.0);
    assert!(baked.notes[0].contains("and not 1000000"), "{:?}", baked.notes);
}

/// Light that is linear across a floor stays linear within charts and along the edge of two charts, one rotated against
/// the other.
#[test]
fn charts_are_continued_beyond_their_edges() {
    let face = |triangle: [[f32; 4]; 3]| {
        let corners = triangle.map(|[x, z, ..]| DVec3::new(x.into(), 0., z.into()));
        Face {
            lightmap_corners: Some(triangle.map(|[.., u, v]| Vec2::new(u, v))),
            ..Face::triangle("floor", corners, Vec3::ZERO, Vec3::splat(0.5))
        }
    };
    let scene = named_scene("floor", FLOOR.map(face).to_vec());
    let charts = UvCharts::new(&scene).unwrap();
    assert_eq!(charts.islands, [0, 0, 2, 2]);
    let mesh = Mesh::uniform(&scene, 8, 1).unwrap();
    let field = field_of_light(&mesh, |p| 5.0 + p.x as f32);
    let folder = TestFolder::new();
    super::program::bake::write_gltf(&folder, "floor.gltf", &FLOOR, true);
    for charts in [ExportCharts::Own(&charts), ExportCharts::Packed(None)] {
        let (_, file) = load(&folder.path("floor.gltf"), &ImportOptions::default());
        let file = SceneFile {
            primitives: file.primitives.into_iter().take(1).collect(),
            ..file
        };
        let baked = export_lightmap((&scene, file), charts, (&mesh, &field), Exposure::with_white(1.0)).unwrap();
        assert!(baked.notes.is_empty(), "{:?}", baked.notes);
        let light = LightPicture::new(&baked.exr, "irradiance.");
        let triangles = BakedScene::new(&baked.glb).triangles;
        // The lamp comes last and has no light here.
        for (k, triangle) in triangles.iter().take(4).enumerate() {
            for (i, j) in (0..=64).flat_map(|j| (0..=64 - j).map(move |i| (i, j))) {
                let shares = [i, j, 64 - i - j].map(|n| n as f32 / 64.0);
                let point: Vec3 = triangle.iter().zip(shares).map(|((p, _), s)| *p * s).sum();
                // At least two texels from the outline.
                if !(0.25..=1.75).contains(&point.x) || !(0.5..=1.5).contains(&point.z) {
                    continue;
                }
                let uv: Vec2 = triangle.iter().zip(shares).map(|((_, uv), s)| *uv * s).sum();
                let off = light.at(uv).x - 5.0 - point.x;
                // Light of about 6 in f32, positions in f32 on a few hundred pixels; from texel to texel the light
                // changes by 1/8.
                assert!(off.abs() < 2e-5, "{k} {point}: {off}");
            }
        }
    }
}
