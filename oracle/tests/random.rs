//! Scenes drawn at random: the same from the same seed, closed where they say so, nothing within
//! anything else, and all that they promise does occur.

use approx::abs_diff_eq;
use common::mesh::Mesh;
use common::scene::{Face, Scene, Shape};
use glam::DVec3;
use oracle::judge::exact::polygon_to_polygon;
use oracle::study::random::{Drawn, Faces, Kind, Lamp, Options, Pose, Sheet, scene};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;

const SEEDS: u64 = 300;

fn drawn(kind: Kind, faces: Faces) -> impl Iterator<Item = Drawn> {
    (0..SEEDS).map(move |seed| scene(seed, Options { kind, faces }))
}

fn quads() -> impl Iterator<Item = Drawn> {
    let kinds = [Kind::Any, Kind::Room].into_iter();
    kinds.flat_map(|kind| drawn(kind, Faces::Quads))
}

fn extent(scene: &Scene) -> f64 {
    let corners = || scene.faces.iter().flat_map(Face::outline);
    let low = corners().fold(DVec3::INFINITY, |a, b| a.min(*b));
    let high = corners().fold(DVec3::NEG_INFINITY, |a, b| a.max(*b));
    (high - low).length()
}

/// What bounds a volume: the room, each body and each lamp that is a box.
fn hulls(drawn: &Drawn) -> (Vec<&Face>, Vec<Vec<&Face>>) {
    let (mut room, mut bodies) = (Vec::new(), BTreeMap::<&str, Vec<&Face>>::new());
    for face in &drawn.scene.faces {
        match face.name.split(' ').next() {
            Some("body" | "lamp") => bodies.entry(&face.name).or_default().push(face),
            Some("sheet") => {}
            _ => room.push(face),
        }
    }
    (room, bodies.into_values().filter(|b| b.len() > 1).collect())
}

/// Of a triangle whose front is seen (van Oosterom & Strackee 1983), negative from behind.
fn angle(point: DVec3, corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|corner| (corner - point).normalize());
    let above = a.dot(b.cross(c));
    let below = 1.0 + a.dot(b) + b.dot(c) + c.dot(a);
    -2.0 * above.atan2(below)
}

/// Of a whole surface: 4π within fronts that face inwards, −4π within fronts that face outwards.
fn solid_angle(point: DVec3, faces: &[&Face]) -> f64 {
    let of = |face: &&Face| {
        let [a, b, c, d] = face.corners;
        let second = match face.shape {
            Shape::Quad => angle(point, [a, c, d]),
            Shape::Triangle => 0.0,
        };
        angle(point, [a, b, c]) + second
    };
    faces.iter().map(of).sum()
}

/// Points within a convex body: near each corner, and in its middle.
fn within(body: &[&Face]) -> Vec<DVec3> {
    let corners: Vec<DVec3> = body.iter().flat_map(|f| f.outline()).copied().collect();
    let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let inner = |share: f64| corners.iter().map(move |c| middle.lerp(*c, share));
    inner(0.5).chain(inner(0.999)).collect()
}

#[test]
fn a_seed_is_a_scene() {
    for faces in [Faces::Quads, Faces::Triangles, Faces::Mixed] {
        let all: BTreeSet<String> = drawn(Kind::Any, faces)
            .map(|drawn| {
                let again = scene(drawn.seed, drawn.options);
                let [text, same] = [&drawn, &again].map(|d| format!("{:?}", d.scene));
                assert_eq!(text, same);
                assert_eq!(drawn.to_string(), again.to_string());
                text
            })
            .collect();
        assert_eq!(all.len() as u64, SEEDS);
    }
}

/// Bits of one seed: a scene that somebody reports must be drawn again by everybody.
#[test]
fn the_draw_is_the_same_everywhere() {
    let drawn = scene(7, Options::default());
    let sum: DVec3 = drawn.scene.faces.iter().flat_map(|f| f.corners).sum();
    println!("{drawn}: {sum}, {}", drawn.scene.faces.len());
    // Sines differ by a rounding from library to library.
    assert!((sum - KNOWN).length() < 1e-9 * KNOWN.length());
}

const KNOWN: DVec3 = DVec3::new(86917.02916163101, -100149.47209861127, -243005.9283171319);

#[test]
fn quads_and_triangles_are_one_room() {
    let mut turns = BTreeSet::new();
    for kind in [Kind::Any, Kind::Room] {
        for whole in drawn(kind, Faces::Quads) {
            let [halves, mixed] = [Faces::Triangles, Faces::Mixed].map(|faces| {
                let options = Options { kind, faces };
                scene(whole.seed, options)
            });
            assert_eq!(2 * whole.scene.faces.len(), halves.scene.faces.len());
            let mut mixed = mixed.scene.faces.iter().filter(|f| f.from.is_none());
            let fronts = whole.scene.faces.iter().filter(|f| f.from.is_none());
            let pairs: Vec<&[Face]> = halves.scene.faces.chunks(2).collect();
            for (quad, pair) in fronts.zip(pairs) {
                let [a, b] = [&pair[0], &pair[1]];
                assert!([a, b].iter().all(|t| t.shape == Shape::Triangle));
                assert!([a, b].iter().all(|t| t.name == quad.name
                    && t.reflectance == quad.reflectance
                    && t.emission == quad.emission));
                // Rounding of corners up to ten extents from the origin.
                let off = (a.vector_area() + b.vector_area() - quad.vector_area()).length();
                assert!(off < 1e-12 * extent(&whole.scene).powi(2), "{off}");
                let normals = [a, b, quad].map(|f| f.vector_area().normalize());
                assert!(
                    normals[0].dot(normals[2]) > 1.0 - 1e-9
                        && normals[1].dot(normals[2]) > 1.0 - 1e-9
                );
                for t in [a, b] {
                    let at = t
                        .outline()
                        .iter()
                        .map(|p| quad.corners.iter().position(|c| c == p).unwrap());
                    turns.insert(at.collect::<Vec<_>>());
                }
                let own = mixed.next().unwrap();
                let next = |f: &Face| f.area();
                let area = match own.shape {
                    Shape::Quad => next(own),
                    Shape::Triangle => next(own) + next(mixed.next().unwrap()),
                };
                assert!(abs_diff_eq!(area / quad.area(), 1.0, epsilon = 1e-9));
            }
        }
    }
    // Two diagonals, two triangles of each, three beginnings.
    assert_eq!(turns.len(), 12);
}

#[test]
fn sheets_have_two_sides() {
    for faces in [Faces::Quads, Faces::Triangles, Faces::Mixed] {
        for drawn in drawn(Kind::Any, faces) {
            let all = &drawn.scene.faces;
            let sheet: Vec<&Face> = all.iter().filter(|f| f.name == "sheet").collect();
            let area: DVec3 = sheet.iter().map(|f| f.vector_area()).sum();
            let total: f64 = sheet.iter().map(|f| f.area()).sum();
            assert!(area.length() <= 1e-9 * total);
            for (k, face) in all.iter().enumerate() {
                let Some(partner) = face.partner else {
                    continue;
                };
                let back = &all[partner as usize];
                assert_eq!(back.partner, Some(k as u32));
                assert!((back.vector_area() + face.vector_area()).length() < 1e-9 * face.area());
            }
            let paired = drawn.sheets.contains(&Sheet::Partners);
            assert_eq!(all.iter().any(|f| f.partner.is_some()), paired);
        }
    }
}

#[test]
fn what_is_closed_is_closed() {
    // Sums of f64 angles over some tens of faces, from corners that rounding has moved by 1e-15 of
    // their distance from the origin; points are no nearer to a face than 1e-4 of a body.
    let tolerance = 1e-6;
    for drawn in quads() {
        let (room, bodies) = hulls(&drawn);
        let mut inside = Vec::new();
        for (k, body) in bodies.iter().enumerate() {
            let points = within(body);
            for (j, other) in bodies.iter().enumerate() {
                let expected = if j == k { -4.0 * PI } else { 0.0 };
                for point in &points {
                    let angle = solid_angle(*point, other);
                    assert!(
                        abs_diff_eq!(angle, expected, epsilon = tolerance),
                        "{drawn}: {k} in {j}: {angle}"
                    );
                }
            }
            inside.extend(points);
        }
        for point in inside {
            let lost = (solid_angle(point, &room) - 4.0 * PI).abs();
            // Through the smallest opening: a hundredth of the sphere from the farthest corner.
            let right = if drawn.closed {
                lost < tolerance
            } else {
                lost > 1e-3
            };
            assert!(right, "{}: {drawn}: {lost}", drawn.seed);
        }
        let area: DVec3 = room.iter().map(|f| f.vector_area()).sum();
        assert!(!drawn.closed || area.length() < 1e-9 * extent(&drawn.scene).powi(2));
    }
}

#[test]
fn of_what_leaves_a_wall_of_a_closed_convex_room_nothing_is_lost() {
    let all = quads().filter(|d| d.closed && d.convex).take(12);
    for drawn in all {
        let (room, _) = hulls(&drawn);
        for a in &room {
            let from = |b: &&Face| polygon_to_polygon(&a.corners, &b.corners);
            let sum: f64 = room
                .iter()
                .filter(|b| !std::ptr::eq(**b, *a))
                .map(from)
                .sum();
            // The quadrature's last halving, and corners rounded at ten extents from the origin.
            assert!(
                abs_diff_eq!(sum, 1.0, epsilon = 1e-7),
                "{}: {drawn}: {sum}",
                a.name
            );
        }
    }
}

#[test]
fn no_fronts_overlap_and_all_are_planar_and_convex() {
    for faces in [Faces::Quads, Faces::Triangles] {
        for drawn in drawn(Kind::Any, faces) {
            let mesh = Mesh::uniform(&drawn.scene, 1, 1).unwrap();
            assert!(mesh.overlaps.is_empty(), "{drawn}");
            for face in &drawn.scene.faces {
                let [a, _, _, d] = face.corners;
                let normal = face.vector_area().normalize();
                let size = extent(&drawn.scene);
                assert!(normal.dot(d - a).abs() < 1e-12 * size, "{}", face.name);
                let outline = face.outline();
                let n = outline.len();
                for k in 0..n {
                    let [p, q, r] = [0, 1, 2].map(|j| outline[(k + j) % n]);
                    let turn = (q - p).normalize().cross((r - q).normalize());
                    assert!(turn.dot(normal) > 1e-3, "{drawn}: {}", face.name);
                }
            }
        }
    }
}

#[test]
fn all_that_is_promised_occurs() {
    let all: Vec<Drawn> = drawn(Kind::Any, Faces::Quads).collect();
    let count = |what: &dyn Fn(&Drawn) -> bool| all.iter().filter(|d| what(d)).count();
    let share = |what: &str, n: usize| {
        println!("{what}: {n} of {}", all.len());
        // Of 300 draws: one in thirty is drawn in less than three by chance once in 2000.
        assert!(n >= 3, "{what}");
    };
    share("closed", count(&|d| d.closed));
    share("open", count(&|d| !d.closed));
    share("not convex", count(&|d| !d.convex));
    for walls in 4..=8 {
        share(
            &format!("{walls} walls, convex"),
            count(&|d| d.convex && d.walls == walls),
        );
    }
    for pose in [
        Pose::Standing,
        Pose::Hanging,
        Pose::Floating,
        Pose::Leaning,
        Pose::Against,
        Pose::Stacked,
        Pose::Beside,
    ] {
        share(&pose.to_string(), count(&|d| d.poses.contains(&pose)));
    }
    for sheet in [Sheet::Partners, Sheet::Coinciding] {
        share(&sheet.to_string(), count(&|d| d.sheets.contains(&sheet)));
    }
    for lamp in [Lamp::Panel, Lamp::Box, Lamp::Wall] {
        share(&lamp.to_string(), count(&|d| d.lamps.contains(&lamp)));
    }
    share("several lamps", count(&|d| d.lamps.len() > 1));
    share("small units", count(&|d| d.unit < 1e-2));
    share("large units", count(&|d| d.unit > 1e2));
    let gaps: Vec<f64> = all.iter().flat_map(|d| &d.gaps).copied().collect();
    assert!(gaps.iter().all(|gap| (1e-4..1e-2).contains(gap)));
    share("gaps", gaps.len());
    share(
        "gaps below a thousandth",
        gaps.iter().filter(|g| **g < 1e-3).count(),
    );
    let faces = || all.iter().flat_map(|d| &d.scene.faces);
    let channels = || faces().flat_map(|f| f.reflectance.to_array());
    assert!(channels().all(|rho| (0.05..=0.95).contains(&rho)));
    assert!(channels().any(|rho| rho < 0.06) && channels().any(|rho| rho > 0.94));
    assert!(
        all.iter()
            .all(|d| d.scene.faces.iter().any(|f| f.emission.min_element() > 0.0))
    );
    let most = all.iter().map(|d| d.scene.faces.len()).max().unwrap();
    println!("at most {most} quads");
    assert!(most <= 40);
}

#[test]
fn rooms_are_boxes_with_two_or_three_boxes_and_a_lamp() {
    for drawn in drawn(Kind::Room, Faces::Quads) {
        assert!(drawn.convex && drawn.walls == 4 && drawn.unit == 1.0 && drawn.gaps.is_empty());
        assert_eq!(drawn.closed, drawn.seed % 3 != 0);
        assert!(drawn.lamps.len() == 1 && drawn.sheets.is_empty());
        assert!(
            drawn
                .poses
                .iter()
                .all(|p| [Pose::Standing, Pose::Hanging].contains(p))
        );
        assert!(!drawn.poses.is_empty(), "{}", drawn.seed);
    }
}
