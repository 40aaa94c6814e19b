//! Fronts that lie on each other: coplanar, facing the same way, overlapping. Which of them is
//! lit is a matter of rounding, so the user should know.

use crate::mesh::{Mesh, MeshFace};

/// Planes this close are one, and overlaps thinner than this are none (mesh units): a file's
/// coordinates carry about six digits.
const SAME: f32 = 1e-5;
/// Pairs that are looked at before the search gives up: a second's work.
const MOST: usize = 100_000_000;

/// Pairs of overlapping faces, lower index first, in order.
pub fn overlaps(mesh: &Mesh) -> Vec<[u32; 2]> {
    let mut order: Vec<u32> = (0..mesh.faces.len() as u32).collect();
    let face = |k: u32| &mesh.faces[k as usize];
    order.sort_by(|a, b| face(*a).plane.w.total_cmp(&face(*b).plane.w));
    let mut found = Vec::new();
    let mut looked = 0;
    for (n, a) in order.iter().enumerate() {
        for b in &order[n + 1..] {
            looked += 1;
            if face(*b).plane.w - face(*a).plane.w > SAME || looked > MOST {
                break;
            }
            if overlap(face(*a), face(*b)) {
                found.push([*a.min(b), *a.max(b)]);
            }
        }
    }
    found.sort_unstable();
    found
}

fn overlap(a: &MeshFace, b: &MeshFace) -> bool {
    let same_side = a.normal.dot(b.normal) > 1.0 - SAME;
    let apart = |p: &MeshFace, q: &MeshFace| {
        p.edges
            .iter()
            .filter(|edge| edge.truncate() != glam::Vec3::ZERO)
            .any(|edge| {
                q.corners
                    .iter()
                    .all(|corner| edge.truncate().dot(*corner) - edge.w <= SAME)
            })
    };
    same_side && !apart(a, b) && !apart(b, a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Face, Scene};
    use glam::{DVec3, Vec3};

    fn square(x: f64, z: f64, side: f64) -> Face {
        let p = |i: f64, j: f64| DVec3::new(x + i * side, j * side, z);
        let corners = [p(0.0, 0.0), p(1.0, 0.0), p(1.0, 1.0), p(0.0, 1.0)];
        Face::quad("", corners, Vec3::ZERO, Vec3::ZERO)
    }

    #[test]
    fn only_fronts_on_the_same_side_of_one_plane_overlap() {
        let faces = vec![
            square(0.0, 0.0, 1.0),
            square(1.0, 0.0, 1.0),             // shares an edge with 0
            square(0.25, 0.0, 0.5),            // inside 0
            square(0.25, 0.0, 0.5).reversed(), // touches from the other side
            square(0.25, 0.01, 0.5),           // above
        ];
        let scene = Scene {
            name: "squares".into(),
            faces,
            notes: Vec::new(),
        };
        let mesh = Mesh::uniform(&scene, 1, 1).unwrap();
        assert_eq!(overlaps(&mesh), [[0, 2]]);
    }
}
