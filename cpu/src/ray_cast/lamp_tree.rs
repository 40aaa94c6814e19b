//! A tree over the lamps, by which a point draws the lamps that may light it most (Conty & Kulla 2018): no point visits
//! all lamps.

use common::mesh::Mesh;
use glam::Vec3;

/// Largest sine of a cone of normals that bounds where its lamps shine; wider cones shine everywhere.
const MAX_CONE_SINE: f32 = 0.5;

/// A group of lamps.
#[derive(Clone, Copy, Debug)]
struct LampNode {
    centre: Vec3,
    radius: f32,
    /// Σ E A over texels and channels.
    power: f32,
    /// Axis of the normals.
    axis: Vec3,
    /// Sine of the largest angle between the axis and a normal.
    cone_sine: f32,
    /// The two children; none of a lamp.
    children: Option<[u32; 2]>,
    parent: u32,
    /// The face of a lamp.
    face: u32,
}

impl LampNode {
    /// Returns an upper bound of the irradiance at `point` of a surface of this `normal`, up to a constant factor; 0 only
    /// where no light arrives.
    fn importance(&self, point: Vec3, normal: Vec3) -> f32 {
        let to = self.centre - point;
        let square = to.length_squared();
        let distance = square.sqrt();
        if distance <= self.radius {
            return self.power / self.radius.powi(2).max(f32::MIN_POSITIVE);
        }
        let slack = self.radius / distance;
        let received = (normal.dot(to) / distance + slack).clamp(0.0, 1.0);
        let sent = match self.cone_sine <= MAX_CONE_SINE {
            true => (-self.axis.dot(to) / distance + slack + self.cone_sine).clamp(0.0, 1.0),
            false => 1.0,
        };
        self.power * received * sent / square
    }
}

/// All lamps of a mesh.
pub struct LampTree {
    nodes: Vec<LampNode>,
    /// Node of each face that is a lamp.
    node_of_face: Vec<Option<u32>>,
}

impl LampTree {
    /// Builds the tree over the faces that emit.
    pub fn new(mesh: &Mesh) -> Self {
        let mut power = vec![0.0; mesh.faces.len()];
        for texel in &mesh.texels {
            power[texel.face as usize] += texel.emission.element_sum() * texel.area;
        }
        let lamps = (0..mesh.faces.len()).filter(|f| power[*f] > 0.0 && !mesh.faces[*f].is_buried());
        let mut leaves: Vec<LampNode> = lamps
            .map(|f| {
                let corners = mesh.faces[f].corners;
                let centre = corners.iter().sum::<Vec3>() / 4.0;
                let radius = corners.iter().map(|c| c.distance(centre)).fold(0.0, f32::max);
                LampNode {
                    centre,
                    radius,
                    power: power[f],
                    axis: mesh.faces[f].normal,
                    cone_sine: 0.0,
                    children: None,
                    parent: 0,
                    face: f as u32,
                }
            })
            .collect();
        let mut tree = Self {
            nodes: Vec::with_capacity(2 * leaves.len()),
            node_of_face: vec![None; mesh.faces.len()],
        };
        if !leaves.is_empty() {
            tree.add_nodes(&mut leaves, 0);
        }
        tree
    }

    /// Adds the node over `leaves` and all below it, and returns its number.
    fn add_nodes(&mut self, leaves: &mut [LampNode], parent: u32) -> u32 {
        let own = self.nodes.len() as u32;
        if let [leaf] = leaves {
            self.node_of_face[leaf.face as usize] = Some(own);
            self.nodes.push(LampNode { parent, ..*leaf });
            return own;
        }
        let low = leaves.iter().map(|l| l.centre).fold(Vec3::INFINITY, Vec3::min);
        let high = leaves.iter().map(|l| l.centre).fold(Vec3::NEG_INFINITY, Vec3::max);
        let extent = high - low;
        let axis = (0..3).max_by(|a, b| extent[*a].total_cmp(&extent[*b])).unwrap_or(0);
        leaves.sort_by(|a, b| a.centre[axis].total_cmp(&b.centre[axis]));
        let centre = 0.5 * (low + high);
        let mean = leaves.iter().map(|l| l.axis).sum::<Vec3>().normalize_or_zero();
        let cosine = leaves.iter().map(|l| l.axis.dot(mean)).fold(1.0, f32::min);
        self.nodes.push(LampNode {
            centre,
            radius: leaves
                .iter()
                .map(|l| l.centre.distance(centre) + l.radius)
                .fold(0.0, f32::max),
            power: leaves.iter().map(|l| l.power).sum(),
            axis: mean,
            cone_sine: if cosine > 0.0 {
                (1.0 - cosine * cosine).max(0.0).sqrt()
            } else {
                1.0
            },
            children: None,
            parent,
            face: 0,
        });
        let (first, second) = leaves.split_at_mut(leaves.len() / 2);
        let children = [self.add_nodes(first, own), self.add_nodes(second, own)];
        self.nodes[own as usize].children = Some(children);
        own
    }

    /// Returns the probability of the first of two `children` at `point`; none if neither lights it.
    fn first_share(&self, children: [u32; 2], point: Vec3, normal: Vec3) -> Option<f32> {
        let [a, b] = children.map(|k| self.nodes[k as usize].importance(point, normal));
        (a + b > 0.0).then(|| a / (a + b))
    }

    /// Draws a lamp by `number` in [0, 1), and returns its face and its probability; none if no lamp lights
    /// the point.
    pub fn draw_lamp(&self, point: Vec3, normal: Vec3, mut number: f32) -> Option<(u32, f32)> {
        let mut node = self.nodes.first()?;
        let mut probability = 1.0;
        while let Some(children) = node.children {
            let share = self.first_share(children, point, normal)?;
            let child;
            if number < share {
                number /= share;
                probability *= share;
                child = children[0];
            } else {
                number = (number - share) / (1.0 - share);
                probability *= 1.0 - share;
                child = children[1];
            }
            node = &self.nodes[child as usize];
        }
        Some((node.face, probability))
    }

    /// Returns the probability with which [`Self::draw_lamp`] draws `face` at `point`.
    pub fn probability(&self, face: u32, point: Vec3, normal: Vec3) -> f32 {
        let Some(mut node) = self.node_of_face[face as usize] else {
            return 0.0;
        };
        let mut probability = 1.0;
        while node != 0 {
            let parent = self.nodes[node as usize].parent;
            if let Some(children) = self.nodes[parent as usize].children {
                let Some(share) = self.first_share(children, point, normal) else {
                    return 0.0;
                };
                probability *= if children[0] == node { share } else { 1.0 - share };
            }
            node = parent;
        }
        probability
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::{Face, Scene};
    use glam::DVec3;

    /// Number of draws at a point.
    const DRAW_COUNT: u32 = 4096;

    /// A mesh of 23 lamps of all orientations on a spiral.
    fn lamps_on_spiral() -> Mesh {
        let lamp = |k: i32| {
            let turn = 0.7 * f64::from(k);
            let centre = DVec3::new(turn.cos(), 0.1 * f64::from(k), turn.sin()) * (1.0 + 0.05 * f64::from(k));
            let across = DVec3::new(turn.sin(), 1.0, -turn.cos()) * (0.05 + 0.01 * f64::from(k % 4));
            let along = DVec3::new(0.1, turn.sin() * 0.1, 0.07);
            let corners = [centre, centre + along, centre + along + across, centre + across];
            Face::quad("lamp", corners, Vec3::splat(1.0 + k as f32), Vec3::ZERO)
        };
        let scene = Scene {
            faces: (0..23).map(lamp).collect(),
            ..Scene::default()
        };
        Mesh::uniform(&scene, 1, 1).unwrap()
    }

    #[test]
    fn lamps_are_drawn_with_their_probability_and_none_that_lights_is_left_out() {
        let mesh = lamps_on_spiral();
        let tree = LampTree::new(&mesh);
        let mut lit = 0;
        for texel in &mesh.texels {
            let (point, normal) = (texel.position + Vec3::splat(0.1), Vec3::new(0.6, 0.8, 0.0));
            let all = 0..mesh.faces.len() as u32;
            let probability: Vec<f32> = all.map(|f| tree.probability(f, point, normal)).collect();
            // Where a group's bound is above that of its lamps none may be drawn.
            assert!(probability.iter().sum::<f32>() < 1.0 + 1e-5);
            let mut drawn = vec![0; mesh.faces.len()];
            for n in 0..DRAW_COUNT {
                let number = (n as f32 + 0.5) / DRAW_COUNT as f32;
                let Some((face, told)) = tree.draw_lamp(point, normal, number) else {
                    continue;
                };
                assert!((told - probability[face as usize]).abs() <= 1e-5 * told);
                drawn[face as usize] += 1;
            }
            for (f, face) in mesh.faces.iter().enumerate() {
                // Each lamp is drawn by the numbers of one interval.
                let off = drawn[f] as f32 - probability[f] * DRAW_COUNT as f32;
                assert!(off.abs() <= 1.1, "{off} of {}", drawn[f]);
                let lights = |corner: &Vec3| {
                    let to = *corner - point;
                    normal.dot(to) > 0.0 && face.normal.dot(to) < 0.0
                };
                if face.corners.iter().any(lights) {
                    assert!(probability[f] > 0.0, "face {f} at {point}");
                    lit += 1;
                }
            }
        }
        assert!(lit > 50, "{lit}");
    }

    #[test]
    fn no_lamp_is_drawn_where_none_shines() {
        let mesh = lamps_on_spiral();
        let tree = LampTree::new(&mesh);
        assert!(tree.draw_lamp(Vec3::Y * 9.0, Vec3::Y, 0.5).is_none());
        let dark = Scene {
            faces: vec![Face::quad(
                "",
                [DVec3::ZERO, DVec3::X, DVec3::ONE, DVec3::Y],
                Vec3::ZERO,
                Vec3::ONE,
            )],
            ..Scene::default()
        };
        let tree = LampTree::new(&Mesh::uniform(&dark, 1, 1).unwrap());
        assert!(tree.draw_lamp(Vec3::ZERO, Vec3::Y, 0.5).is_none());
    }
}
