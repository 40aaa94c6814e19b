//! A tree over the lamps, by which a point draws the lamps that may light it most (Conty & Kulla 2018): no point visits
//! all lamps. Nearby points choose among the same nodes of the tree, a cut (Walter and others 2005), weighted by the light
//! that each may send to the point and by how much of it rays have found to arrive.

use common::constants::CONTACT_DISTANCE;
use common::mesh::Mesh;
use glam::Vec3;

/// Largest number of nodes of a [`LampCut`].
pub const MAX_CUT_NODES: usize = 64;
/// Largest sine of a cone of normals that bounds where its lamps shine; wider cones shine everywhere.
const MAX_CONE_SINE: f32 = 0.5;

/// A group of lamps.
#[derive(Clone, Copy, Debug)]
struct LampNode {
    centre: Vec3,
    radius: f32,
    /// Largest distance of a point of the lamps from the plane through the centre, across the axis.
    thickness: f32,
    /// Σ E A over texels and channels.
    power: f32,
    /// Axis of the normals.
    axis: Vec3,
    /// Sine of the largest angle between the axis and a normal.
    cone_sine: f32,
    /// The two children; none of a lamp.
    children: Option<[u32; 2]>,
    parent: u32,
    /// The number of a lamp.
    number: u32,
}

/// A surface that shines: a face or a texel.
pub struct Lamp {
    /// Its number.
    pub number: u32,
    /// Its outline.
    pub corners: [Vec3; 4],
    /// Its front.
    pub normal: Vec3,
    /// Σ E A over channels.
    pub power: f32,
}

impl LampNode {
    /// Returns how far the lamps may rise above the plane of this normal through their centre: lamps of one plane not at all
    /// above that plane.
    fn rise_above(&self, normal: Vec3) -> f32 {
        match self.cone_sine <= MAX_CONE_SINE {
            true => self.thickness * normal.dot(self.axis).abs() + self.radius * normal.cross(self.axis).length(),
            false => self.radius,
        }
    }

    /// Returns an upper bound of the irradiance at the points of a surface, up to a constant factor; 0 only where no light
    /// arrives, and in a lamp's own plane.
    fn importance(&self, at: &Receiver) -> f32 {
        let to = self.centre - at.centre;
        let sine = at.normal.cross(self.axis).length();
        let received = at.normal.dot(to) + self.rise_above(at.normal);
        let sent = match self.cone_sine == 0.0 {
            true => -self.axis.dot(to) + at.radius * sine + self.thickness,
            false => f32::INFINITY,
        };
        if received.min(sent) <= CONTACT_DISTANCE {
            return 0.0;
        }
        let (square, radius) = (to.length_squared(), self.radius + at.radius);
        if square <= radius * radius {
            return self.power / (radius * radius).max(f32::MIN_POSITIVE);
        }
        let inverse = 1.0 / square.sqrt();
        let slack = radius * inverse;
        let received = (at.normal.dot(to) * inverse + slack).clamp(0.0, 1.0);
        let sent = match self.cone_sine <= MAX_CONE_SINE {
            true => (-self.axis.dot(to) * inverse + slack + self.cone_sine).clamp(0.0, 1.0),
            false => 1.0,
        };
        self.power * received * sent * inverse * inverse
    }
}

/// A flat surface within a sphere that receives light.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// Centre of the sphere.
    pub centre: Vec3,
    /// Radius of the sphere.
    pub radius: f32,
    /// Normal of the surface.
    pub normal: Vec3,
}

/// All lamps of a mesh.
pub struct LampTree {
    nodes: Vec<LampNode>,
    /// Node of each number that is a lamp's.
    node_of_lamp: Vec<Option<u32>>,
    /// The cut of the root alone.
    root: LampCut,
}

impl LampTree {
    /// Builds the tree over the faces that emit.
    pub fn new(mesh: &Mesh) -> Self {
        let mut power = vec![0.0; mesh.faces.len()];
        for texel in &mesh.texels {
            power[texel.face as usize] += texel.emission.element_sum() * texel.area;
        }
        let lamps = (0..mesh.faces.len()).filter(|f| !mesh.faces[*f].is_buried());
        let lamp = |f: usize| Lamp {
            number: f as u32,
            corners: mesh.faces[f].corners,
            normal: mesh.faces[f].normal,
            power: power[f],
        };
        Self::from_lamps(lamps.map(lamp), mesh.faces.len())
    }

    /// Builds the tree over those of the `lamps` that have power; their numbers are below `count`.
    pub fn from_lamps(lamps: impl Iterator<Item = Lamp>, count: usize) -> Self {
        let leaf = |lamp: Lamp| {
            let centre = lamp.corners.iter().sum::<Vec3>() / 4.0;
            LampNode {
                centre,
                radius: lamp.corners.iter().map(|c| c.distance(centre)).fold(0.0, f32::max),
                thickness: (lamp.corners.iter())
                    .map(|c| lamp.normal.dot(*c - centre).abs())
                    .fold(0.0, f32::max),
                power: lamp.power,
                axis: lamp.normal,
                cone_sine: 0.0,
                children: None,
                parent: 0,
                number: lamp.number,
            }
        };
        let mut leaves: Vec<LampNode> = lamps.filter(|lamp| lamp.power > 0.0).map(leaf).collect();
        let mut tree = Self {
            nodes: Vec::with_capacity(2 * leaves.len()),
            node_of_lamp: vec![None; count],
            root: LampCut::default(),
        };
        if !leaves.is_empty() {
            tree.add_nodes(&mut leaves, 0);
        }
        tree.root = tree.choose_cut([Vec3::ZERO; 2], 1);
        tree
    }

    /// Returns whether there are no lamps.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Adds the node over `leaves` and all below it, and returns its number.
    fn add_nodes(&mut self, leaves: &mut [LampNode], parent: u32) -> u32 {
        let own = self.nodes.len() as u32;
        if let [leaf] = leaves {
            self.node_of_lamp[leaf.number as usize] = Some(own);
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
            thickness: leaves
                .iter()
                .map(|l| mean.dot(l.centre - centre).abs() + l.rise_above(mean))
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
            number: 0,
        });
        let (first, second) = leaves.split_at_mut(leaves.len() / 2);
        let children = [self.add_nodes(first, own), self.add_nodes(second, own)];
        self.nodes[own as usize].children = Some(children);
        own
    }

    /// Returns the nodes, `most` of them, among which points within the box `low` to `high` choose: those that may light it
    /// most are split first.
    pub fn choose_cut(&self, [low, high]: [Vec3; 2], most: usize) -> LampCut {
        let bound = |node: u32| {
            let LampNode {
                centre, radius, power, ..
            } = self.nodes[node as usize];
            let square = centre.distance_squared(centre.clamp(low, high)).max(radius * radius);
            power / square.max(f32::MIN_POSITIVE)
        };
        let mut nodes: Vec<u32> = (0..self.nodes.len().min(1) as u32).collect();
        let mut bounds: Vec<f32> = nodes.iter().map(|k| bound(*k)).collect();
        while nodes.len() < most.min(MAX_CUT_NODES) {
            let split = (0..nodes.len()).filter(|k| self.nodes[nodes[*k] as usize].children.is_some());
            let Some(largest) = split.max_by(|a, b| bounds[*a].total_cmp(&bounds[*b])) else {
                break;
            };
            let Some([a, b]) = self.nodes[nodes[largest] as usize].children else {
                break;
            };
            (nodes[largest], bounds[largest]) = (a, bound(a));
            nodes.push(b);
            bounds.push(bound(b));
        }
        LampCut {
            visible: vec![1.0; nodes.len()],
            rays: vec![[0; 2]; nodes.len()],
            nodes,
        }
    }

    /// Lets a receiver choose among all lamps from the root on.
    pub fn weigh_all(&self, at: Receiver) -> LampChoice<'_> {
        self.weigh_lamps(&self.root, at)
    }

    /// Weighs the nodes of `cut` for a receiver.
    pub fn weigh_lamps<'a>(&'a self, cut: &'a LampCut, at: Receiver) -> LampChoice<'a> {
        let mut weights = [0.0; MAX_CUT_NODES];
        for ((weight, node), visible) in weights.iter_mut().zip(&cut.nodes).zip(&cut.visible) {
            *weight = self.nodes[*node as usize].importance(&at) * visible;
        }
        LampChoice {
            tree: self,
            cut,
            at,
            total: weights.iter().sum(),
            weights,
        }
    }
}

/// Nodes among which nearby points choose a lamp.
#[derive(Default)]
pub struct LampCut {
    nodes: Vec<u32>,
    /// Factor of each node's weight.
    visible: Vec<f32>,
    /// Rays to the lamps of each node, and how many of them met no wall.
    rays: Vec<[u32; 2]>,
}

impl LampCut {
    /// Counts rays to the lamps of each node, and how many of them met no wall.
    pub fn count_rays(&mut self, rays: &[[u32; 2]; MAX_CUT_NODES]) {
        for (own, more) in self.rays.iter_mut().zip(rays) {
            *own = [own[0] + more[0], own[1] + more[1]];
        }
    }

    /// Weighs the lamps by the root of the share of the rays so far that met no wall: the variance of what a lamp
    /// brings is least if it is drawn by the root of the mean square.
    pub fn learn_visibility(&mut self) {
        for (visible, [all, free]) in self.visible.iter_mut().zip(&self.rays) {
            // One free ray more: a lamp that no ray has reached may still light a corner of a texel.
            *visible = ((free + 1) as f32 / (all + 1) as f32).sqrt();
        }
    }
}

/// A lamp that was drawn.
#[derive(Clone, Copy, Debug)]
pub struct DrawnLamp {
    /// Its number.
    pub lamp: u32,
    /// Its entry in the cut.
    pub entry: usize,
    /// The probability of drawing it.
    pub probability: f32,
}

/// The choice of a receiver's points among all lamps.
pub struct LampChoice<'a> {
    tree: &'a LampTree,
    cut: &'a LampCut,
    at: Receiver,
    weights: [f32; MAX_CUT_NODES],
    total: f32,
}

impl LampChoice<'_> {
    /// Returns the probability of the first of two `children`; none if neither lights the receiver.
    fn first_share(&self, children: [u32; 2]) -> Option<f32> {
        let importance = |k: u32| self.tree.nodes[k as usize].importance(&self.at);
        let [a, b] = children.map(importance);
        (a + b > 0.0).then(|| a / (a + b))
    }

    /// Draws a lamp by `number` in [0, 1); none if none was found that lights the receiver.
    pub fn draw_lamp(&self, number: f32) -> Option<DrawnLamp> {
        let mut left = number * self.total;
        let mut entry = self.weights.iter().position(|weight| *weight > 0.0)?;
        // Rounding may leave a rest at the end: the last of them gets it.
        for k in entry + 1..self.cut.nodes.len() {
            if left < self.weights[entry] {
                break;
            }
            if self.weights[k] > 0.0 {
                left -= self.weights[entry];
                entry = k;
            }
        }
        let weight = self.weights[entry];
        let mut number = (left / weight).clamp(0.0, 1.0 - f32::EPSILON);
        let mut probability = weight / self.total;
        let mut node = &self.tree.nodes[self.cut.nodes[entry] as usize];
        while let Some(children) = node.children {
            let share = self.first_share(children)?;
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
            node = &self.tree.nodes[child as usize];
        }
        Some(DrawnLamp {
            lamp: node.number,
            entry,
            probability,
        })
    }

    /// Returns the probability with which [`Self::draw_lamp`] draws `lamp`.
    pub fn lamp_probability(&self, lamp: u32) -> f32 {
        let Some(mut node) = self.tree.node_of_lamp[lamp as usize] else {
            return 0.0;
        };
        let mut probability = 1.0;
        loop {
            if let Some(entry) = self.cut.nodes.iter().position(|k| *k == node) {
                let share = self.weights[entry] / self.total;
                return if share > 0.0 { probability * share } else { 0.0 };
            }
            let parent = self.tree.nodes[node as usize].parent;
            let Some(children) = self.tree.nodes[parent as usize].children else {
                return 0.0;
            };
            let Some(share) = self.first_share(children) else {
                return 0.0;
            };
            probability *= if children[0] == node { share } else { 1.0 - share };
            node = parent;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::{Face, Scene};
    use glam::{DMat3, DVec3, EulerRot};

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
        for (k, texel) in mesh.texels.iter().enumerate() {
            let (point, normal) = (texel.position + Vec3::splat(0.1), Vec3::new(0.6, 0.8, 0.0));
            let at = receive_at(point, normal);
            let mut cut = tree.choose_cut([point, point], [1, 5, MAX_CUT_NODES][k % 3]);
            cut.count_rays(&[[3, 1]; MAX_CUT_NODES]);
            cut.learn_visibility();
            let choice = tree.weigh_lamps(&cut, at);
            let all = 0..mesh.faces.len() as u32;
            let probability: Vec<f32> = all.map(|f| choice.lamp_probability(f)).collect();
            // Where a group's bound is above that of its lamps none may be drawn.
            assert!(probability.iter().sum::<f32>() < 1.0 + 1e-5);
            let mut drawn = vec![0; mesh.faces.len()];
            for n in 0..DRAW_COUNT {
                let number = (n as f32 + 0.5) / DRAW_COUNT as f32;
                let Some(DrawnLamp {
                    lamp,
                    probability: told,
                    ..
                }) = choice.draw_lamp(number)
                else {
                    continue;
                };
                assert!((told - probability[lamp as usize]).abs() <= 1e-5 * told);
                drawn[lamp as usize] += 1;
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
    fn lamp_is_not_drawn_in_its_own_plane() {
        let mesh = lamps_on_spiral();
        let tree = LampTree::new(&mesh);
        for texel in &mesh.texels {
            let at = Receiver {
                radius: 0.1,
                ..receive_at(texel.position, mesh.faces[texel.face as usize].normal)
            };
            assert_eq!(tree.weigh_all(at).lamp_probability(texel.face), 0.0);
        }
    }

    /// Of two lamps each has two halves, which are one node of the cut.
    #[test]
    fn group_of_lamps_is_not_drawn_in_its_own_plane() {
        let turn = DMat3::from_euler(EulerRot::XYZ, 0.4, 0.9, -0.7);
        let lamp = |[x, y, z]: [f64; 3], towards: f64| {
            let corners = [[0.0, 0.0], [0.1, 0.0], [0.1, 0.1], [0.0, 0.1]];
            let corner = |[u, v]: [f64; 2]| turn * DVec3::new(x + u, y, z - towards * v);
            Face::quad("lamp", corners.map(corner), Vec3::ONE, Vec3::ONE)
        };
        let scene = Scene {
            faces: vec![
                lamp([0.0, 0.0, 0.0], 1.0),
                lamp([0.1, 0.0, 0.0], 1.0),
                lamp([-2.0, 1.0, 0.0], -1.0),
                lamp([-1.9, 1.0, 0.0], -1.0),
            ],
            ..Scene::default()
        };
        let mesh = Mesh::uniform(&scene, 1, 1).unwrap();
        let tree = LampTree::new(&mesh);
        let texel = &mesh.texels[0];
        let cut = tree.choose_cut([texel.position; 2], 2);
        let at = Receiver {
            radius: 0.05,
            ..receive_at(texel.position, mesh.faces[0].normal)
        };
        let choice = tree.weigh_lamps(&cut, at);
        let [a, b, c, d] = [0, 1, 2, 3].map(|lamp| choice.lamp_probability(lamp));
        assert_eq!([a, b], [0.0; 2]);
        assert!((c + d - 1.0).abs() < 1e-6, "{c} + {d}");
    }

    /// A point of a surface.
    fn receive_at(centre: Vec3, normal: Vec3) -> Receiver {
        Receiver {
            centre,
            radius: 0.0,
            normal,
        }
    }

    /// Draws a lamp at a point of a surface that faces up.
    fn draw_at(tree: &LampTree, point: Vec3) -> Option<DrawnLamp> {
        let cut = tree.choose_cut([point; 2], MAX_CUT_NODES);
        tree.weigh_lamps(&cut, receive_at(point, Vec3::Y)).draw_lamp(0.5)
    }

    #[test]
    fn no_lamp_is_drawn_where_none_shines() {
        let mesh = lamps_on_spiral();
        let tree = LampTree::new(&mesh);
        assert!(draw_at(&tree, Vec3::Y * 9.0).is_none());
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
        assert!(draw_at(&tree, Vec3::ZERO).is_none());
    }
}
