//! What must not matter: where a scene lies, how large it is, its mirror image, the order of its
//! faces and corners, and whether a face is one or two.

use super::kit::{Way, all, every_engine, every_way};
use super::places::Pairing;
use super::same::same;
use super::scenes::{Cut, any_scene, convex, furnished, turned};
use common::mesh::Mesh;
use glam::{DMat3, DQuat, DVec3};
use proptest::prelude::*;

fn rotation() -> impl Strategy<Value = DMat3> {
    (-3.0f64..3.0, -3.0f64..3.0, -3.0f64..3.0)
        .prop_map(|(x, y, z)| DMat3::from_quat(DQuat::from_euler(glam::EulerRot::XYZ, x, y, z)))
}

/// A similarity: turned, made larger or smaller, and moved by a few times its size.
#[test]
fn a_scene_elsewhere_has_the_same_light() {
    let motion = (
        rotation(),
        prop::array::uniform3(-9.0f64..9.0),
        -2.0f64..2.0,
    );
    every_way(
        1,
        &(furnished(), motion),
        |way, (cut, (turn, shift, power))| {
            let scale = 10f64.powf(power);
            let to = |p: DVec3| (turn * p + DVec3::from(shift)) * scale;
            let [a, b] = [cut.clone(), cut.moved(to)].map(|cut| cut.mesh(way.samples));
            same(way, &a, &b, &Pairing::new(&a, &b, to), scale)
        },
    );
}

/// Powers of two are no rounding.
#[test]
fn a_scene_of_another_unit_has_the_same_bits() {
    every_engine(4, &(any_scene(), -40i32..40), |way, (cut, power)| {
        let scale = f64::from(power).exp2();
        let [a, b] = [cut.clone(), cut.moved(|p| p * scale)].map(|cut| cut.mesh(way.samples));
        let log: Vec<u32> = all(&a).into_iter().chain(all(&a)).collect();
        let [a, b] = [&a, &b].map(|mesh| way.replay(mesh, &log));
        prop_assert_eq!(a.shots, b.shots);
        prop_assert_eq!(a.field, b.field);
        Ok(())
    });
}

/// Other numbers of texels and cells move the sample points: with many of them only rooms with
/// nothing in between are the same but for rounding.
fn for_way(way: Way, convex: Cut, furnished: Cut) -> Cut {
    if way.samples > 1 { convex } else { furnished }
}

/// The mirror image, fronts still where they were.
fn mirrored(cut: &Cut, normal: DVec3) -> (Cut, impl Fn(DVec3) -> DVec3 + use<>) {
    let to = move |p: DVec3| p - 2.0 * normal * normal.dot(p);
    let mut image = cut.moved(to);
    for (face, resolution) in image.scene.faces.iter_mut().zip(&mut image.resolutions) {
        *face = face.reversed();
        resolution.reverse();
    }
    (image, to)
}

fn axis() -> impl Strategy<Value = DVec3> {
    rotation().prop_map(|turn| turn.x_axis)
}

#[test]
fn a_mirrored_scene_has_mirrored_light() {
    every_way(
        1,
        &(convex(), furnished(), axis()),
        |way, (empty, full, axis)| {
            let cut = for_way(way, empty, full);
            let (image, to) = mirrored(&cut, axis);
            let [a, b] = [&cut, &image].map(|cut| cut.mesh(way.samples));
            same(way, &a, &b, &Pairing::new(&a, &b, to), 1.0)
        },
    );
}

/// The faces in another order.
fn shuffled(cut: &Cut, order: &[usize]) -> Cut {
    let mut other = cut.clone();
    other.scene.faces = order.iter().map(|k| cut.scene.faces[*k].clone()).collect();
    other.resolutions = order.iter().map(|k| cut.resolutions[*k]).collect();
    other
}

/// An order of `count` things, from random keys.
fn order(count: usize, keys: &[u32]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|k| {
        (
            keys[k % keys.len()].rotate_left((k / keys.len()) as u32),
            *k,
        )
    });
    order
}

fn keys() -> impl Strategy<Value = Vec<u32>> {
    prop::collection::vec(any::<u32>(), 64)
}

/// With one sample a link knows no numbers, and the same shots add the same to each texel.
#[test]
fn the_order_of_faces_changes_no_bit() {
    every_engine(
        4,
        &(any_scene(), convex(), keys()),
        |way, (full, empty, keys)| {
            let cut = for_way(way, empty, full);
            let order = order(cut.scene.faces.len(), &keys);
            let [a, b] = [cut.clone(), shuffled(&cut, &order)].map(|cut| cut.mesh(way.samples));
            // A texel's number in its face stays: no search, which bodies that touch might deceive.
            let mut places = vec![0; order.len()];
            order
                .iter()
                .enumerate()
                .for_each(|(k, face)| places[*face] = k as u32);
            let number = |mesh: &Mesh, face: u32, index: u32| {
                mesh.texels
                    .iter()
                    .position(|t| t.face == face && t.index == index)
            };
            let texels: Vec<usize> = (a.texels.iter())
                .filter_map(|t| number(&b, places[t.face as usize], t.index))
                .collect();
            let cell_of = |texel: usize| b.cells.iter().position(|c| c.texels().contains(&texel));
            let log = all(&a);
            let other: Vec<u32> = (a.cells.iter())
                .filter_map(|cell| cell_of(texels[cell.first as usize]).map(|k| k as u32))
                .collect();
            let [a, b] = [(&a, log), (&b, other)].map(|(mesh, log)| way.replay(mesh, &log).field);
            for (k, j) in texels.iter().enumerate() {
                prop_assert_eq!(a.radiosity[k], b.radiosity[*j], "texel {}", k);
                prop_assert_eq!(a.irradiance[k].truncate(), b.irradiance[*j].truncate());
            }
            Ok(())
        },
    );
}

/// Faces of so many corners begin at another one of these.
fn rotated(cut: &Cut, by: &[u32], corners: &[usize]) -> Cut {
    let mut other = cut.clone();
    let faces = other.scene.faces.iter_mut().zip(&mut other.resolutions);
    for ((face, resolution), by) in faces.zip(by.iter().cycle()) {
        if corners.contains(&face.outline().len()) {
            (*face, *resolution) = turned(face, *resolution, *by as usize % 12);
        }
    }
    other
}

/// The cells of a triangle depend on its first corner: there only links are compared.
#[test]
fn the_order_of_faces_and_corners_changes_rounding_only() {
    every_way(
        1,
        &(convex(), furnished(), keys()),
        |way, (empty, full, keys)| {
            let cut = for_way(way, empty, full);
            let other = shuffled(
                &rotated(&cut, &keys, &[3, 4]),
                &order(cut.scene.faces.len(), &keys),
            );
            let [a, b] = [&cut, &other].map(|cut| cut.mesh(way.samples));
            same(way, &a, &b, &Pairing::new(&a, &b, |p| p), 1.0)
        },
    );
}

/// A face of 2×N texels and as two of 1×N; a triangle of 2² texels as four of one.
fn split(cut: &Cut, at: usize) -> [Cut; 2] {
    let mut one = cut.clone();
    let at = at % cut.scene.faces.len();
    let face = &cut.scene.faces[at];
    let [a, b, c, d] = face.corners;
    let middle = |p: DVec3, q: DVec3| 0.5 * (p + q);
    let quad = face.outline().len() == 4;
    one.resolutions[at][0] = 2;
    if !quad {
        one.resolutions[at] = [2, 2];
    }
    let height = one.resolutions[at][1];
    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
    let (parts, resolution) = if quad {
        let cd = middle(c, d);
        (vec![[a, ab, cd, d], [ab, b, c, cd]], [1, height])
    } else {
        let parts = [[a, ab, ca], [ab, b, bc], [ab, bc, ca], [ca, bc, c]];
        (parts.map(|[a, b, c]| [a, b, c, c]).to_vec(), [1, 1])
    };
    let mut parts = parts.into_iter().map(|corners| common::scene::Face {
        corners,
        ..face.clone()
    });
    let mut many = one.clone();
    many.scene.faces[at] = parts.next().unwrap();
    many.resolutions[at] = resolution;
    for part in parts {
        many.scene.faces.push(part);
        many.resolutions.push(resolution);
    }
    [one, many]
}

/// Texels that are the same take the same; where the cells are the same, too, as those of quads are,
/// so is the answer.
#[test]
fn a_face_and_its_parts_have_the_same_light() {
    every_way(
        2,
        &(convex(), furnished(), any::<usize>()),
        |way, (empty, full, at)| {
            let cut = for_way(way, empty, full);
            let [a, b] = split(&cut, at).map(|cut| cut.mesh(way.samples));
            same(way, &a, &b, &Pairing::new(&a, &b, |p| p), 1.0)
        },
    );
}

/// Σ A|Δw| over all links, over ΣA·w.
fn difference(
    way: Way,
    a: &Mesh,
    links: &[Vec<f32>],
    other: &Cut,
    to: impl Fn(DVec3) -> DVec3,
) -> f64 {
    let b = other.mesh(way.samples);
    let (pairs, others) = (Pairing::new(a, &b, to), way.links(&b));
    let (mut apart, mut all) = (0.0, 0.0);
    for (row, other) in links.iter().zip(&pairs.cells) {
        let other = &others[other.expect("each cell has its own")];
        for ((texel, w), k) in a.texels.iter().zip(row).zip(&pairs.texels) {
            apart += f64::from(texel.area) * f64::from((w - other[*k]).abs());
            all += f64::from(texel.area) * f64::from(*w);
        }
    }
    apart / all
}

/// With many samples and something in between, other numbers are other points: what that changes is
/// told by three other orders of the faces, and a mirror image and other corners of quads may change
/// about as much. Each is a sum over some hundred links that are half seen, of as many draws, so that
/// the largest of three is exceeded twice only if something else is wrong. More points, less change.
#[test]
fn other_numbers_change_what_the_samples_leave_open() {
    let scene = furnished().prop_filter("something is between", |cut| cut.scene.faces.len() > 12);
    every_engine(2, &(scene, keys(), axis()), |way, (cut, keys, axis)| {
        let way = Way {
            samples: 4 * way.samples,
            ..way
        };
        let a = cut.mesh(way.samples);
        let links = way.links(&a);
        let order = |by: u32| {
            let keys: Vec<u32> = keys.iter().map(|key| key.rotate_left(by)).collect();
            shuffled(&cut, &order(cut.scene.faces.len(), &keys))
        };
        let chance = [1, 9, 17].map(|by| difference(way, &a, &links, &order(by), |p| p));
        let most = chance.into_iter().fold(0.0, f64::max);
        let (image, to) = mirrored(&cut, axis);
        let found = [
            difference(way, &a, &links, &image, to),
            difference(way, &a, &links, &rotated(&cut, &keys, &[4]), |p| p),
        ];
        for found in found {
            prop_assert!(found <= 2.0 * most, "{found:e}, by chance {chance:?}");
        }
        if way.samples == 4 {
            let more = Way { samples: 16, ..way };
            let finer = cut.mesh(16);
            let less = difference(more, &finer, &more.links(&finer), &order(1), |p| p);
            prop_assert!(less < most, "{less:e} of 16 points, {most:e} of 4");
        }
        Ok(())
    });
}
