//! Light in the pixels of baked charts.

use super::program::bake::FLOOR;
use common::mesh::Mesh;
use common::scene::Face;
use common::shooting::RadiosityField;
use common::solution::pixels::ImagePlanes;
use common::texel;
use glam::{DVec3, Vec2, Vec3};
use radiosity::report::gltf_export::export_lightmap;
use radiosity::report::gltf_export::uv_charts::UvCharts;
use radiosity::report::picture::Exposure;
use radiosity_tests::named_scene;
use radiosity_tests::painted::{paint_face, picture_coat};

fn field_of_light(mesh: &Mesh, light: impl Fn(usize) -> f32) -> RadiosityField {
    let light = (0..mesh.texels.len()).map(|k| Vec3::splat(light(k)).extend(0.0));
    let light: Vec<_> = light.collect();
    RadiosityField {
        origin: "made".into(),
        radiosity: light.clone(),
        residual: light.clone(),
        irradiance: light,
    }
}

/// The triangles of a baked scene: corners with their lightmap coordinates.
pub struct BakedScene {
    pub triangles: Vec<[(Vec3, Vec2); 3]>,
    /// The PNG file of the lightmap.
    pub picture: Vec<u8>,
}

impl BakedScene {
    pub fn new(glb: &[u8]) -> Self {
        let document = gltf::Gltf::from_slice(glb).unwrap();
        let blob = document.blob.as_deref().unwrap();
        let mut triangles = Vec::new();
        for primitive in document.meshes().flat_map(|mesh| mesh.primitives()) {
            let reader = primitive.reader(|_| Some(blob));
            let places = reader.read_positions().unwrap().map(Vec3::from);
            let uvs = reader.read_tex_coords(1).unwrap().into_f32();
            let corners: Vec<_> = places.zip(uvs.map(Vec2::from)).collect();
            let index: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
            let chunks = index.as_chunks::<3>().0.iter();
            triangles.extend(chunks.map(|triangle| triangle.map(|k| corners[k as usize])));
        }
        let gltf::image::Source::View { view, .. } = document.images().next().unwrap().source() else {
            panic!("the picture is not in the file");
        };
        let picture = blob[view.offset()..view.offset() + view.length()].to_vec();
        Self { triangles, picture }
    }

    /// Returns the lightmap coordinates of a point of triangle `k`.
    pub fn place_on_chart(&self, k: usize, point: Vec3) -> Vec2 {
        let [(a, at_a), (b, at_b), (c, at_c)] = self.triangles[k];
        let normal = (b - a).cross(c - a);
        let share = |p: Vec3, q: Vec3| normal.dot((q - p).cross(point - p)) / normal.length_squared();
        at_a * share(b, c) + at_b * share(c, a) + at_c * share(a, b)
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

/// Under uniform irradiance a node has the mean ρ and E of the texels of which it is a corner.
#[test]
fn baked_node_has_mean_material_of_adjacent_texels() {
    let [a, b, c, d] = [[0., 0.], [2., 0.], [2., 1.], [0., 1.]].map(|[x, z]| DVec3::new(x, 0., z));
    let white = || Some(picture_coat([2, 1], &[Vec3::splat(0.5), Vec3::splat(0.25)]));
    let faces = vec![
        paint_face(
            Face::quad("quad", [a, b, c, d], Vec3::ZERO, Vec3::ZERO),
            [white(), white()],
        ),
        paint_face(
            Face::triangle("triangle", [a, d, c], Vec3::ZERO, Vec3::ZERO),
            [white(), None],
        ),
    ];
    let scene = named_scene("nodes", faces);
    let sides = 3;
    let mut mesh = Mesh::uniform(&scene, sides, 1).unwrap();
    // Each texel has another ρ and E, so that no texel can be mistaken for another.
    for (k, texel) in mesh.texels.iter_mut().enumerate() {
        texel.reflectance = Vec3::splat(((7 * k + 3) % 19) as f32 / 20.0);
        texel.emission = Vec3::new(((5 * k + 2) % 17) as f32, 0.0, 1.0);
    }
    let light = 2.0;
    let field = field_of_light(&mesh, |_| light);
    let baked = export_lightmap(&scene, None, (&mesh, &field), Exposure::with_white(1.0)).unwrap();
    let picture = LightPicture::new(&baked.exr, "");

    let charts = Mesh::new(&scene, &[[sides + 1; 2]; 2], 1).unwrap();
    let (mut inner, mut outer) = (0, 0);
    for (f, face) in scene.faces.iter().enumerate() {
        let [x, y, w, _] = charts.faces[f].rect;
        for (j, i) in (0..=sides).flat_map(|j| (0..=sides).map(move |i| (j, i))) {
            if face.outline().len() == 3 && i + j > sides {
                continue;
            }
            assert_eq!(w, sides + 1);
            let [u, v] = [i, j].map(|n| f64::from(n) / f64::from(sides));
            let node = face.point_at(u, v);
            let (mut rho, mut emission, mut count) = (0.0, 0.0, 0.0f32);
            for texel in mesh.texels.iter().filter(|texel| texel.face == f as u32) {
                let outline = texel::texel_outline(face, [sides; 2], texel.index);
                if outline.corners().iter().any(|p| p.distance(node) < 1e-9) {
                    rho += texel.reflectance.x;
                    emission += texel.emission.x;
                    count += 1.0;
                }
            }
            *if count > 2.0 { &mut inner } else { &mut outer } += 1;
            let found = picture.pixel(Vec2::new((x + i) as f32, (y + j) as f32));
            let expected = Vec3::new(emission + rho * light, rho * light, count + rho * light) / count;
            let off = (found - expected).abs();
            assert!(off.cmple(1e-5 * expected).all(), "{f} {i} {j}: {found} {expected}");
        }
    }
    // 12 nodes of the quad lie on its outline and have one or two texels. All nodes of the triangle but three have
    // three texels or more.
    assert_eq!((inner, outer), (4 + 7, 12 + 3));
}

/// Irradiance varies from texel to texel, on faces with texels of different size. Along shared edges both charts have
/// the same values.
#[test]
fn charts_agree_along_shared_edges() {
    let p = |x: f64, z: f64| DVec3::new(x, 0., z);
    let corners = [
        vec![p(0., 0.), p(0., 1.), p(1., 1.)],
        vec![p(0., 0.), p(1., 1.), p(1., 0.)],
        vec![p(1., 0.), p(1., 1.), p(2., 1.), p(2., 0.)],
        vec![p(2., 1.), p(3., 0.), p(2., 0.)],
    ];
    let face = |corners: &Vec<DVec3>| match *corners.as_slice() {
        [a, b, c] => Face::triangle("", [a, b, c], Vec3::ZERO, Vec3::splat(0.5)),
        _ => Face::quad(
            "",
            [corners[0], corners[1], corners[2], corners[3]],
            Vec3::ZERO,
            Vec3::splat(0.5),
        ),
    };
    let scene = named_scene("edges", corners.iter().map(face).collect());
    for sides in [[2, 8, 4, 16], [16, 2, 8, 1], [4, 4, 4, 4], [1, 16, 2, 2]] {
        let mesh = Mesh::new(&scene, &sides.map(|n| [n; 2]), 1).unwrap();
        let field = field_of_light(&mesh, |k| ((7 * k + 3) % 19) as f32);
        let baked = export_lightmap(&scene, None, (&mesh, &field), Exposure::with_white(1.0)).unwrap();
        let light = LightPicture::new(&baked.exr, "irradiance.");
        let triangles = BakedScene::new(&baked.glb).triangles;
        let edges = triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
        let edges: Vec<_> = edges.collect();
        let mut shared = 0;
        for (n, [a, b]) in edges.iter().enumerate() {
            for [c, d] in edges[n + 1..].iter().filter(|[c, d]| (a.0, b.0) == (d.0, c.0)) {
                shared += 1;
                for t in (0..=100).map(|k| k as f32 / 100.0) {
                    let [one, other] = [a.1.lerp(b.1, t), d.1.lerp(c.1, t)].map(|uv| light.at(uv).x);
                    // Positions are f32 on a picture of many pixels, and the light changes by up to 19 from pixel to pixel.
                    let step = (one - other).abs();
                    assert!(step < 19.0 * 1e-4, "{sides:?} {} {} {t}: {one} {other}", a.0, b.0);
                }
            }
        }
        // The diagonal of the quad is a shared edge within its chart.
        assert_eq!(shared, 4, "{sides:?}");
    }
}

/// Light that is linear across a floor stays linear within charts and along the edge of two charts, one rotated against
/// the other. Only at the outline of the floor, where no texel follows, it is constant.
#[test]
fn kept_charts_are_continued_beyond_their_edges() {
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
    // Coordinate in the scene: the mesh has another origin.
    let x = |k: usize| 5.0 + mesh.texels[k].position.x * mesh.unit as f32 + mesh.origin.x as f32;
    let field = field_of_light(&mesh, x);
    let baked = export_lightmap(&scene, Some(&charts), (&mesh, &field), Exposure::with_white(1.0)).unwrap();
    assert_eq!(baked.note, None);
    let light = LightPicture::new(&baked.exr, "irradiance.");
    let triangles = BakedScene::new(&baked.glb).triangles;
    for (k, triangle) in triangles.iter().enumerate() {
        for (i, j) in (0..=64).flat_map(|j| (0..=64 - j).map(move |i| (i, j))) {
            let shares = [i, j, 64 - i - j].map(|n| n as f32 / 64.0);
            let point: Vec3 = triangle.iter().zip(shares).map(|((p, _), s)| *p * s).sum();
            // At least two texels from the outline.
            if !(0.25..=1.75).contains(&point.x) || !(0.5..=1.5).contains(&point.z) {
                continue;
            }
            let uv: Vec2 = triangle.iter().zip(shares).map(|((_, uv), s)| *uv * s).sum();
            let off = light.at(uv).x - 5.0 - point.x;
            // Light of about 6 in f32, positions in f32 on 128 pixels; from texel to texel the light changes by 1/8.
            assert!(off.abs() < 1e-5, "{k} {point}: {off}");
        }
    }
}
