//! Adjacent faces: neighbours to be refined together, sheets that stand on a face, and narrow gaps.
//!
//! Light on a face may be wrong because the texels of a neighbour are too coarse, so refining one face also refines
//! its neighbours. A texel on both sides of a sheet's contact edge mixes light and shadow. In a gap much narrower
//! than a texel, a part of the texel lies in the dark under a face.

use common::polygon::clip_by_plane;
use common::scene::Face;
use glam::DVec3;
use std::collections::HashMap;
use std::ops::Range;

/// Faces count as facing each other if the cosine between their normals is at most this (154°).
const MAX_FACING_COSINE: f64 = -0.9;
/// Distance below which faces are in contact, as a share of a face's width.
const CONTACT_DISTANCE: f64 = 1e-6;
/// Planes count as aligned if the absolute cosine between their normals is above this.
const MIN_ALIGNED_COSINE: f64 = 0.9;
/// Unit normal of a face; 0 without an area.
fn normal_of(face: &Face) -> DVec3 {
    face.vector_area().normalize_or_zero()
}

/// Length of a face's longest side.
fn longest_side(face: &Face) -> f64 {
    let [u, v] = face.grid_lengths();
    u.max(v)
}

/// Largest width of each face's texels.
fn texel_widths(faces: &[Face], texels: &[[u32; 2]]) -> Vec<f64> {
    let width = |(face, texels): (&Face, &[u32; 2])| {
        let lengths = face.grid_lengths();
        (0..2).map(|k| lengths[k] / f64::from(texels[k])).fold(0.0, f64::max)
    };
    faces.iter().zip(texels).map(width).collect()
}

/// Halves the texels of faces adjacent to those whose texels `finer` halves, unless theirs are already
/// smaller: for example where a body's top meets a wall that goes down into a gap.
pub fn refine_neighbours(
    faces: &[Face],
    before: &[[u32; 2]],
    finer: &mut [[u32; 2]],
    may_refine: impl Fn(usize) -> bool,
) {
    let halved: Vec<bool> = (0..faces.len()).map(|f| finer[f] != before[f]).collect();
    let widths = texel_widths(faces, before);
    visit_near_pairs(faces, &widths, |f, g, distance| {
        let wants = halved[f] && !halved[g] && widths[g] >= widths[f] && may_refine(g);
        if wants && distance <= widths[g] && face_each_other(&faces[f], &faces[g]) {
            finer[g] = faces[g].halve_texels(before[g]);
        }
    });
}

/// Calls `report_width` with a face and the largest width of its texels, for each face to which another is closer
/// than one texel. If the other covers it in part, the width is the gap's height, or gives `texels_across` texels
/// across the smaller face. If the other is a sheet that stands on it, half as many texels reach along the
/// contact edge: a texel on both sides of the sheet would mix light and shadow. No width is below `min_width`.
pub fn limit_texel_widths(
    faces: &[Face],
    texels: &[[u32; 2]],
    (texels_across, min_width): (f64, f64),
    mut report_width: impl FnMut(usize, f64),
) {
    let widths = texel_widths(faces, texels);
    let across = |f: usize| faces[f].grid_lengths().into_iter().fold(f64::INFINITY, f64::min);
    let normals: Vec<DVec3> = faces.iter().map(normal_of).collect();
    let corners = CornerNormals::new(faces, &normals);
    visit_near_pairs(faces, &widths, |f, g, distance| {
        if distance > widths[f] {
            return;
        }
        let both = [normals[f], normals[g]];
        let smaller = min_width.max(across(f).min(across(g)) / texels_across);
        if smaller < widths[f]
            && let Some(gap) = gap_height(&faces[f], &faces[g], both, widths[f])
        {
            report_width(f, smaller.max(gap));
        }
        if let Some([a, b]) = contact_edge(&faces[f], &faces[g], both, widths[f])
            && corners.is_sheet([a, b], both)
        {
            report_width(f, min_width.max(2.0 * a.distance(b) / texels_across));
        }
    });
}

/// Calls `pair` with two faces and the distance of their boxes, for all ordered pairs whose distance is at
/// most `reach` of either face.
fn visit_near_pairs(faces: &[Face], reach: &[f64], mut pair: impl FnMut(usize, usize, f64)) {
    // Each face reaches as far as its own texels are wide, so a fine mesh in a coarse room has few pairs.
    let tree = BoxTree::new(faces, reach);
    let mut pending: Vec<[usize; 2]> = tree.nodes.first().map(|_| [0, 0]).into_iter().collect();
    while let Some([a, b]) = pending.pop() {
        let [one, other] = [a, b].map(|k| &tree.nodes[k]);
        if box_distance(&one.bounds, &other.bounds) > one.reach.max(other.reach) {
            continue;
        }
        match (one.children, other.children) {
            (Some([c, d]), _) if a == b => pending.extend([[c, c], [c, d], [d, d]]),
            (Some([c, d]), _) if one.faces.len() >= other.faces.len() => pending.extend([[c, b], [d, b]]),
            (_, Some([c, d])) => pending.extend([[a, c], [a, d]]),
            (Some([c, d]), None) => pending.extend([[c, b], [d, b]]),
            (None, None) => {
                for k in one.faces.clone() {
                    let first = if a == b { k + 1 } else { other.faces.start };
                    for n in first..other.faces.end {
                        let [f, g] = [tree.order[k], tree.order[n]];
                        let distance = box_distance(&tree.boxes[f], &tree.boxes[g]);
                        if distance <= reach[f].max(reach[g]) {
                            pair(f, g, distance);
                            pair(g, f, distance);
                        }
                    }
                }
            }
        }
    }
}

/// Most faces of a node without children.
const MAX_LEAF_FACES: usize = 4;

/// A binary tree over the boxes of faces.
struct BoxTree {
    boxes: Vec<[DVec3; 2]>,
    /// Faces, node by node.
    order: Vec<usize>,
    nodes: Vec<BoxNode>,
}

/// A node with the box and the largest reach of its faces.
struct BoxNode {
    bounds: [DVec3; 2],
    reach: f64,
    faces: Range<usize>,
    children: Option<[usize; 2]>,
}

impl BoxTree {
    fn new(faces: &[Face], reach: &[f64]) -> Self {
        let mut tree = Self {
            boxes: faces.iter().map(bounding_box).collect(),
            order: (0..faces.len()).collect(),
            nodes: Vec::with_capacity(faces.len()),
        };
        if !faces.is_empty() {
            tree.add_node(0..faces.len(), reach);
        }
        tree
    }

    /// Adds the node over `faces` of the order and all below it, and returns its number.
    fn add_node(&mut self, faces: Range<usize>, reach: &[f64]) -> usize {
        let own = self.order[faces.clone()].iter();
        let low = own.clone().fold(DVec3::INFINITY, |low, f| low.min(self.boxes[*f][0]));
        let high = own
            .clone()
            .fold(DVec3::NEG_INFINITY, |high, f| high.max(self.boxes[*f][1]));
        let number = self.nodes.len();
        self.nodes.push(BoxNode {
            bounds: [low, high],
            reach: own.map(|f| reach[*f]).fold(0.0, f64::max),
            faces: faces.clone(),
            children: None,
        });
        if faces.len() > MAX_LEAF_FACES {
            let axis = (high - low).max_position();
            let middle = faces.len() / 2;
            let place = |f: &usize| self.boxes[*f][0][axis] + self.boxes[*f][1][axis];
            let by_place = |a: &usize, b: &usize| place(a).total_cmp(&place(b));
            self.order[faces.clone()].select_nth_unstable_by(middle, by_place);
            let halves = [faces.start..faces.start + middle, faces.start + middle..faces.end];
            self.nodes[number].children = Some(halves.map(|half| self.add_node(half, reach)));
        }
        number
    }
}

/// Height of `g` above `f` if it faces `f`, lies above a part of it and is no farther than `reach`.
fn gap_height(f: &Face, g: &Face, [n, m]: [DVec3; 2], reach: f64) -> Option<f64> {
    if n.dot(m) > MAX_FACING_COSINE {
        return None;
    }
    let heights = g.corners.iter().map(|c| n.dot(*c - f.corners[0]));
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| {
        (low.min(h), high.max(h))
    });
    let middle = |face: &Face| face.corners.iter().sum::<DVec3>() / face.corners.len() as f64;
    let aside = middle(g) - middle(f);
    let aside = (aside - n * n.dot(aside)).length();
    let far = 0.5 * (longest_diagonal(f) + longest_diagonal(g));
    (low <= reach && high > CONTACT_DISTANCE * longest_side(g) && aside <= far).then_some(low.max(0.0))
}

fn longest_diagonal(face: &Face) -> f64 {
    let c = &face.corners;
    c[0].distance(c[2]).max(c[1].distance(c[c.len() - 1]))
}

fn bounding_box(face: &Face) -> [DVec3; 2] {
    let corners = face.corners.iter();
    let low = corners.clone().fold(DVec3::INFINITY, |low, c| low.min(*c));
    [low, corners.fold(DVec3::NEG_INFINITY, |high, c| high.max(*c))]
}

/// Smallest distance between two boxes.
fn box_distance(a: &[DVec3; 2], b: &[DVec3; 2]) -> f64 {
    let gap = (a[0] - b[1]).max(b[0] - a[1]).max(DVec3::ZERO);
    gap.length()
}

/// Tests if a part of each face lies in front of the other.
fn face_each_other(f: &Face, g: &Face) -> bool {
    let before = |f: &Face, g: &Face| {
        let normal = normal_of(f);
        let reach = CONTACT_DISTANCE * longest_side(g);
        g.corners.iter().any(|c| normal.dot(*c - f.corners[0]) > reach)
    };
    before(f, g) && before(g, f)
}

/// The faces at each corner position: their distinct normals, each with the number of its faces.
struct CornerNormals(HashMap<[u64; 3], Vec<(DVec3, usize)>>);

impl CornerNormals {
    /// Collects the corners of `faces` with the given normals.
    pub fn new(faces: &[Face], normals: &[DVec3]) -> Self {
        let mut found: HashMap<_, Vec<(DVec3, usize)>> = HashMap::new();
        for (face, own) in faces.iter().zip(normals) {
            for corner in face.outline() {
                let normals_here = found.entry(position_key(*corner)).or_default();
                // Counted, not listed: many faces may coincide.
                let alike = |(other, _): &&mut (DVec3, usize)| is_parallel(*own, *other) && own.dot(*other) > 0.0;
                match normals_here.iter_mut().find(alike) {
                    Some((_, count)) => *count += 1,
                    None => normals_here.push((*own, 1)),
                }
            }
        }
        Self(found)
    }

    /// Tests if the face with contact edge `edge` is a sheet; the normals are those of the face under it and its
    /// own. At the ends of a body's contact edge a face in another plane begins. If the body's side is cut into
    /// pieces, both ends have another piece with the same normal and none with the opposite one.
    pub fn is_sheet(&self, edge: [DVec3; 2], [under, own]: [DVec3; 2]) -> bool {
        let at = edge.map(|end| self.0.get(&position_key(end)).map_or(&[][..], Vec::as_slice));
        let mut all = at.iter().copied().flatten();
        if all.any(|(other, _)| !is_aligned(under, *other) && !is_parallel(own, *other)) {
            return false;
        }
        let sides = |end: &[(DVec3, usize)], sign: f64| -> usize {
            let own = end
                .iter()
                .filter(|(other, _)| is_parallel(own, *other) && sign * own.dot(*other) > 0.0);
            own.map(|(_, count)| count).sum()
        };
        at.iter().all(|end| sides(end, -1.0) > 0) || at.iter().any(|end| sides(end, 1.0) == 1)
    }
}

fn position_key(corner: DVec3) -> [u64; 3] {
    // Maps −0 to 0.
    (corner + 0.0).to_array().map(f64::to_bits)
}

fn is_aligned(a: DVec3, b: DVec3) -> bool {
    a.dot(b).abs() > MIN_ALIGNED_COSINE
}

/// Tests if two normals are parallel to rounding: adjacent faces of a body may differ by little more.
fn is_parallel(a: DVec3, b: DVec3) -> bool {
    a.cross(b).length() <= CONTACT_DISTANCE
}

/// Returns the edge by which `g` stands on `f`: it lies at most `reach` above the plane of `f`, and a part of it
/// within the outline of `f`.
fn contact_edge(f: &Face, g: &Face, [normal, own]: [DVec3; 2], reach: f64) -> Option<[DVec3; 2]> {
    if is_aligned(normal, own) {
        return None;
    }
    let (c, d) = (f.outline(), g.outline());
    let low = |at: &DVec3| (-CONTACT_DISTANCE * reach..=reach).contains(&normal.dot(*at - c[0]));
    let within = |edge: &[DVec3; 2]| {
        let clipped = (0..c.len()).fold(edge.to_vec(), |clipped, k| {
            let inward = normal.cross(c[(k + 1) % c.len()] - c[k]);
            clip_by_plane(&clipped, c[k] + CONTACT_DISTANCE * inward, inward)
        });
        let longest = clipped.iter().map(|p| p.distance(clipped[0])).fold(0.0, f64::max);
        longest > CONTACT_DISTANCE * edge[0].distance(edge[1])
    };
    let edges = (0..d.len()).map(|k| [d[k], d[(k + 1) % d.len()]]);
    let mut standing = edges.filter(|edge| edge.iter().all(low));
    standing.find(within)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// A floor of side 8 with a grid of plates above it, and one plate beside it at either end.
    fn plates(across: u32) -> Vec<Face> {
        let square = |at: [f64; 3], side: f64| {
            let [x, y, z] = at;
            let corner = |i: f64, j: f64| DVec3::new(x + i * side, y, z + j * side);
            let corners = [corner(0.0, 0.0), corner(0.0, 1.0), corner(1.0, 1.0), corner(1.0, 0.0)];
            Face::quad("plate", corners, Vec3::ZERO, Vec3::ONE)
        };
        let side = 8.0 / f64::from(across);
        let places = (0..across).flat_map(|i| (0..across).map(move |j| [i, j].map(f64::from)));
        let plates = places.map(|[i, j]| square([i * side, 1.0, j * side], 0.5 * side));
        let beside = [square([-3.5, 1.0, 0.0], 2.5), square([9.0, 1.0, 0.0], 0.5)];
        std::iter::once(square([0.0; 3], 8.0))
            .chain(plates)
            .chain(beside)
            .collect()
    }

    #[test]
    fn pairs_within_a_texel_are_exactly_those_of_a_brute_force_search() {
        let faces = plates(20);
        let widths = texel_widths(&faces, &vec![[4; 2]; faces.len()]);
        let mut found = Vec::new();
        visit_near_pairs(&faces, &widths, |f, g, distance| found.push((f, g, distance)));
        let boxes: Vec<[DVec3; 2]> = faces.iter().map(bounding_box).collect();
        let all = (0..faces.len()).flat_map(|f| (0..faces.len()).map(move |g| (f, g)));
        let mut wanted: Vec<(usize, usize, f64)> = all
            .filter(|(f, g)| f != g)
            .map(|(f, g)| (f, g, box_distance(&boxes[f], &boxes[g])))
            .filter(|(f, g, distance)| *distance <= widths[*f].max(widths[*g]))
            .collect();
        // The floor's texels are 2 wide and reach every plate; those of plates reach no other.
        assert_eq!(wanted.len(), 2 * 402);
        let key = |a: &(usize, usize, f64)| (a.0, a.1);
        found.sort_by_key(key);
        wanted.sort_by_key(key);
        assert_eq!(found, wanted);
    }

    #[test]
    fn sheet_refines_the_face_under_it_and_a_body_does_not() {
        let upright = |a: [f64; 2], b: [f64; 2], low: f64| {
            let at = |[x, z]: [f64; 2], y: f64| DVec3::new(x, y, z);
            let top = low + 1.0;
            let corners = [at(a, low), at(b, low), at(b, top), at(a, top)];
            Face::quad("sheet", corners, Vec3::ZERO, Vec3::ONE)
        };
        let corner = |x, z| DVec3::new(x, 0.0, z);
        let corners = [corner(0.0, 0.0), corner(0.0, 8.0), corner(8.0, 8.0), corner(8.0, 0.0)];
        let floor = &Face::quad("floor", corners, Vec3::ZERO, Vec3::ONE);
        let widths_for = |things: &[Face]| {
            let faces: Vec<Face> = [floor].into_iter().chain(things).cloned().collect();
            let mut widths = Vec::new();
            let texels = vec![[4; 2]; faces.len()];
            limit_texel_widths(&faces, &texels, (8.0, 0.0), |f, width| widths.push((f, width)));
            widths
        };
        let [a, b, c] = [[3.0, 2.0], [5.0, 2.0], [5.0, 4.0]];
        // One-sided or two-sided, on the floor or less than a texel above it; one end may lie beyond the floor.
        assert_eq!(widths_for(&[upright(a, b, 0.0)]), [(0, 0.5)]);
        let both = [upright(a, b, 0.5), upright(b, a, 0.5)];
        assert_eq!(widths_for(&both), [(0, 0.5); 2]);
        assert_eq!(widths_for(&[upright([5.0, 2.0], [9.0, 2.0], 0.0)]), [(0, 1.0)]);
        // Not high above the floor, nor below it, nor along its edge, nor as a side of a body.
        assert!(widths_for(&[upright(a, b, 2.5)]).is_empty());
        assert!(widths_for(&[upright(a, b, -3.0)]).is_empty());
        assert!(widths_for(&[upright([3.0, 0.0], [5.0, 0.0], 0.0)]).is_empty());
        assert!(widths_for(&[upright(a, b, 0.0), upright(b, c, 0.0)]).is_empty());
        assert!(widths_for(&[upright(a, b, 0.0), upright(b, [7.0, 2.01], 0.0)]).is_empty());
        // A triangle that touches the floor with one corner has no contact edge.
        let at = |x: f64, y: f64| DVec3::new(x, y, 2.0);
        let triangle = |corners| Face::triangle("sheet", corners, Vec3::ZERO, Vec3::ONE);
        let standing = triangle([at(3.0, 3.0), at(3.0, 0.0), at(5.0, 0.0)]);
        assert_eq!(widths_for(&[standing]), [(0, 0.5)]);
        let on_its_tip = triangle([at(5.0, 3.0), at(3.0, 3.0), at(4.0, 0.0)]);
        assert!(widths_for(&[on_its_tip]).is_empty());
        // A two-sided sheet may be cut into pieces. A one-sided piece may be the side of a body, except at the
        // sheet's ends.
        let d = [6.0, 2.0];
        let cut = [upright([1.0, 2.0], a, 0.0), upright(a, b, 0.0), upright(b, d, 0.0)];
        assert_eq!(widths_for(&cut), [(0, 0.5), (0, 0.25)]);
        let behind = [upright(a, [1.0, 2.0], 0.0), upright(b, a, 0.0), upright(d, b, 0.0)];
        assert_eq!(widths_for(&[cut, behind].concat()).len(), 6);
    }
}
