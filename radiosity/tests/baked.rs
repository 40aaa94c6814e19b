//! Light in the pixels of baked charts.

use super::painted::{made_scene, paint_face, picture_coat};
use common::mesh::Mesh;
use common::scene::Face;
use common::shooting::RadiosityField;
use common::texel;
use exr::prelude::{ReadChannels, ReadLayers, read};
use glam::{DVec2, DVec3, Vec2, Vec3};
use radiosity::report::gltf_export::export_lightmap;
use radiosity::report::gltf_export::uv_charts::UvCharts;
use radiosity::report::picture::Exposure;
use std::io::Cursor;

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

/// Reads a channel of an OpenEXR file, and its size.
fn exr_channel(bytes: &[u8], name: &str) -> (Vec<f32>, [usize; 2]) {
    let read = read().no_deep_data().largest_resolution_level().all_channels();
    let image = read
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes));
    let layer = image.unwrap().layer_data;
    let found = layer.channel_data.list.iter().find(|channel| channel.name.eq(name));
    let values = found.unwrap().sample_data.values_as_f32().collect();
    (values, [layer.size.0, layer.size.1])
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
    let scene = made_scene("nodes", faces);
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
    let [red, blue] = ["R", "B"].map(|name| exr_channel(&baked.exr, name).0);

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
            let at = ((y + j) * charts.atlas[0] + x + i) as usize;
            let expected = (emission + rho * light) / count;
            assert!(
                (red[at] - expected).abs() < 1e-5 * expected,
                "{f} {i} {j}: {} {expected}",
                red[at]
            );
            let expected = 1.0 + rho * light / count;
            assert!(
                (blue[at] - expected).abs() < 1e-5 * expected,
                "{f} {i} {j}: {} {expected}",
                blue[at]
            );
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
    let scene = made_scene("edges", corners.iter().map(face).collect());
    for sides in [[2, 8, 4, 16], [16, 2, 8, 1], [4, 4, 4, 4], [1, 16, 2, 2]] {
        let mesh = Mesh::new(&scene, &sides.map(|n| [n; 2]), 1).unwrap();
        let field = field_of_light(&mesh, |k| ((7 * k + 3) % 19) as f32);
        let baked = export_lightmap(&scene, None, (&mesh, &field), Exposure::with_white(1.0)).unwrap();
        let (light, [width, height]) = exr_channel(&baked.exr, "irradiance.R");
        let glb = gltf::Gltf::from_slice(&baked.glb).unwrap();
        let blob = glb.blob.as_deref().unwrap();
        let primitive = glb.meshes().next().unwrap().primitives().next().unwrap();
        let reader = primitive.reader(|_| Some(blob));
        let places: Vec<DVec3> = reader
            .read_positions()
            .unwrap()
            .map(|p| Vec3::from(p).as_dvec3())
            .collect();
        let uvs = reader.read_tex_coords(1).unwrap().into_f32();
        let uvs: Vec<DVec2> = uvs.map(|uv| DVec2::new(uv[0].into(), uv[1].into())).collect();
        let at = |uv: DVec2| {
            let p = (uv * DVec2::new(width as f64, height as f64) - 0.5).max(DVec2::ZERO);
            let share = p - p.floor();
            let pixel = |x: usize, y: usize| {
                let (x, y) = ((p.x as usize + x).min(width - 1), (p.y as usize + y).min(height - 1));
                f64::from(light[y * width + x])
            };
            let row = |y: usize| pixel(0, y) * (1.0 - share.x) + pixel(1, y) * share.x;
            row(0) * (1.0 - share.y) + row(1) * share.y
        };
        let index: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        let triangles: Vec<[u32; 3]> = index.as_chunks().0.to_vec();
        let edges = triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
        let edges: Vec<[usize; 2]> = edges.map(|edge| edge.map(|k| k as usize)).collect();
        let mut shared = 0;
        for (n, [a, b]) in edges.iter().enumerate() {
            for [c, d] in &edges[n + 1..] {
                if places[*a] != places[*d] || places[*b] != places[*c] {
                    continue;
                }
                shared += 1;
                for k in 0..=100 {
                    let t = f64::from(k) / 100.0;
                    let [one, other] = [uvs[*a].lerp(uvs[*b], t), uvs[*d].lerp(uvs[*c], t)].map(at);
                    // Positions are f32 on a picture of many pixels, and the light changes by up to 19 from pixel to pixel.
                    assert!(
                        (one - other).abs() < 19.0 * 1e-4,
                        "{sides:?} {:?} {:?} {t}: {one} {other}",
                        places[*a],
                        places[*b]
                    );
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
    let p = |x: f64, z: f64| DVec3::new(x, 0., z);
    let floor = [
        ([p(0., 0.), p(0., 2.), p(1., 2.)], [[0.1, 0.1], [0.1, 0.5], [0.3, 0.5]]),
        ([p(0., 0.), p(1., 2.), p(1., 0.)], [[0.1, 0.1], [0.3, 0.5], [0.3, 0.1]]),
        ([p(1., 0.), p(1., 2.), p(2., 2.)], [[0.4, 0.3], [0.8, 0.3], [0.8, 0.1]]),
        ([p(1., 0.), p(2., 2.), p(2., 0.)], [[0.4, 0.3], [0.8, 0.1], [0.4, 0.1]]),
    ];
    let face = |(corners, chart): ([DVec3; 3], [[f32; 2]; 3])| Face {
        lightmap_corners: Some(chart.map(Vec2::from)),
        ..Face::triangle("floor", corners, Vec3::ZERO, Vec3::splat(0.5))
    };
    let scene = made_scene("floor", floor.map(face).to_vec());
    let charts = UvCharts::new(&scene).unwrap();
    assert_eq!(charts.islands, [0, 0, 2, 2]);
    let mesh = Mesh::uniform(&scene, 8, 1).unwrap();
    // Coordinate in the scene: the mesh has another origin.
    let x = |k: usize| 5.0 + mesh.texels[k].position.x * mesh.unit as f32 + mesh.origin.x as f32;
    let field = field_of_light(&mesh, x);
    let baked = export_lightmap(&scene, Some(&charts), (&mesh, &field), Exposure::with_white(1.0)).unwrap();
    assert_eq!(baked.note, None);
    let (light, [width, height]) = exr_channel(&baked.exr, "irradiance.R");
    let at = |uv: DVec2| {
        let p = uv * DVec2::new(width as f64, height as f64) - 0.5;
        let share = p - p.floor();
        let pixel = |x: usize, y: usize| f64::from(light[(p.y as usize + y) * width + p.x as usize + x]);
        let row = |y: usize| pixel(0, y) * (1.0 - share.x) + pixel(1, y) * share.x;
        row(0) * (1.0 - share.y) + row(1) * share.y
    };
    for (k, (corners, chart)) in floor.iter().enumerate() {
        let chart = chart.map(|uv| Vec2::from(uv).as_dvec2());
        for (i, j) in (0..=64).flat_map(|j| (0..=64 - j).map(move |i| (i, j))) {
            let shares = [i, j, 64 - i - j].map(|n| f64::from(n) / 64.0);
            let point: DVec3 = corners.iter().zip(shares).map(|(p, s)| *p * s).sum();
            // At least two texels from the outline.
            if !(0.25..=1.75).contains(&point.x) || !(0.5..=1.5).contains(&point.z) {
                continue;
            }
            let uv: DVec2 = chart.iter().zip(shares).map(|(uv, s)| *uv * s).sum();
            let off = at(uv) - 5.0 - point.x;
            // Light of about 6 in f32, positions in f32 on 128 pixels; from texel to texel the light changes by 1/8.
            assert!(off.abs() < 1e-5, "{k} {point}: {off}");
        }
    }
}
