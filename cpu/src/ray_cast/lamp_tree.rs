//! A tree over the lamps, by which a point draws the lamps that may light it most (Conty & Kulla 2018): no point visits
//! all lamps. Nearby points choose among the same nodes of the tree, a cut (Walter and others 2005), weighted by the light
//! that each may send to the point and by how much of it rays have found to arrive. Lamps that a point sees at nearly the
//! same distance and angles are chosen by power alone.

use common::constants::CONTACT_DISTANCE;
use common::mesh::Mesh;
use common::texel_point::SampledOutline;
use glam::Vec3;

/// Largest number of nodes of a [`LampCut`].
pub const MAX_CUT_NODES: usize = 64;
/// Number of equal strata of [0, 1) among which the nodes of a cut are divided. Of 2ⁿ numbers of a Sobol sequence, or of a
/// multiple of them, each node with whole strata of 2⁻ⁿ has the same share whatever the numbers are, so that its light causes
/// noise only where it is partly hidden.
const STRATUM_COUNT: f32 = 128.0;
/// Largest sine of a cone of normals that bounds where its lamps shine; wider cones shine everywhere.
const MAX_CONE_SINE: f32 = 0.5;
/// Least light of a lamp over the most, for equal power, from which on lamps of a node are drawn by power. Where they differ
/// by this ratio r the variance is at most (1 + r)²/4r = 1.6 times that of lamps drawn by their light.
const EVEN_LIGHT_RATIO: f32 = 0.25;

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
    /// The places of its first lamp and of the next node's in the order of lamps.
    lamps: [u32; 2],
}

/// The light of a node's lamps at a receiver.
struct NodeLight {
    /// Upper bound of the irradiance, up to a constant factor; 0 only where no light arrives, and in a lamp's own plane.
    importance: f32,
    /// Whether the irradiance for equal power varies by less than [`EVEN_LIGHT_RATIO`] from lamp to lamp.
    even: bool,
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

    /// Bounds the irradiance at the points of a surface.
    fn light_at(&self, at: &Receiver) -> NodeLight {
        let to = self.centre - at.centre;
        let sine = at.normal.cross(self.axis).length();
        let received = at.normal.dot(to) + self.rise_above(at.normal);
        let sent = match self.cone_sine == 0.0 {
            true => -self.axis.dot(to) + at.radius * sine + self.thickness,
            false => f32::INFINITY,
        };
        let uneven = |importance| NodeLight {
            importance,
            even: false,
        };
        if received.min(sent) <= CONTACT_DISTANCE {
            return uneven(0.0);
        }
        let (square, radius) = (to.length_squared(), self.radius + at.radius);
        if square <= radius * radius {
            return uneven(self.power / (radius * radius).max(f32::MIN_POSITIVE));
        }
        let inverse = 1.0 / square.sqrt();
        let slack = radius * inverse;
        let received = at.normal.dot(to) * inverse;
        let most_received = (received + slack).clamp(0.0, 1.0);
        if self.cone_sine > MAX_CONE_SINE {
            return uneven(self.power * most_received * inverse * inverse);
        }
        let sent = -self.axis.dot(to) * inverse;
        let turned = slack + self.cone_sine;
        let most_sent = (sent + turned).clamp(0.0, 1.0);
        let nearest_over_farthest = (1.0 - slack) / (1.0 + slack);
        let least = (received - slack).max(0.0) * (sent - turned).max(0.0) * nearest_over_farthest.powi(2);
        NodeLight {
            importance: self.power * most_received * most_sent * inverse * inverse,
            even: least > EVEN_LIGHT_RATIO * most_received * most_sent,
        }
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

impl Receiver {
    /// Makes the receiver around `centre` that contains `outlines`.
    pub fn around_outlines(centre: Vec3, outlines: &[SampledOutline], normal: Vec3) -> Self {
        let corners = outlines.iter().flat_map(|part| part.corners);
        Self {
            centre,
            radius: corners.map(|c| c.distance(centre)).fold(0.0, f32::max),
            normal,
        }
    }
}

/// All lamps of a mesh.
pub struct LampTree {
    nodes: Vec<LampNode>,
    /// The numbers of the lamps in order: those of a node follow each other.
    lamps: Vec<u32>,
    /// Place in the order of each number that is a lamp's.
    places: Vec<Option<u32>>,
    /// The power of all lamps before each in the order, and of all.
    powers_before: Vec<f64>,
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
            let number = lamp.number;
            let centre = lamp.corners.iter().sum::<Vec3>() / 4.0;
            let node = LampNode {
                centre,
                radius: lamp.corners.iter().map(|c| c.distance(centre)).fold(0.0, f32::max),
                thickness: (lamp.corners.iter())
                    .map(|c| lamp.normal.dot(*c - centre).abs())
                    .fold(0.0, f32::max),
                power: lamp.power,
                axis: lamp.normal,
                cone_sine: 0.0,
                children: None,
                lamps: [0; 2],
            };
            (number, node)
        };
        let mut leaves: Vec<(u32, LampNode)> = lamps.filter(|lamp| lamp.power > 0.0).map(leaf).collect();
        let mut tree = Self {
            nodes: Vec::with_capacity(2 * leaves.len()),
            lamps: Vec::with_capacity(leaves.len()),
            places: vec![None; count],
            powers_before: vec![0.0],
        };
        if !leaves.is_empty() {
            tree.add_nodes(&mut leaves);
        }
        tree
    }

    /// Returns whether there are no lamps.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Adds the node over `leaves`, lamps with their numbers, and all below it, and returns its number.
    fn add_nodes(&mut self, leaves: &mut [(u32, LampNode)]) -> u32 {
        let own = self.nodes.len() as u32;
        let first_lamp = self.lamps.len() as u32;
        let lamps = [first_lamp, first_lamp + leaves.len() as u32];
        if let [(number, leaf)] = leaves {
            self.places[*number as usize] = Some(first_lamp);
            self.lamps.push(*number);
            let before = self.powers_before[first_lamp as usize];
            self.powers_before.push(before + f64::from(leaf.power));
            self.nodes.push(LampNode { lamps, ..*leaf });
            return own;
        }
        let low = leaves.iter().map(|(_, l)| l.centre).fold(Vec3::INFINITY, Vec3::min);
        let high = leaves.iter().map(|(_, l)| l.centre).fold(Vec3::NEG_INFINITY, Vec3::max);
        let extent = high - low;
        let axis = (0..3).max_by(|a, b| extent[*a].total_cmp(&extent[*b])).unwrap_or(0);
        leaves.sort_by(|(_, a), (_, b)| a.centre[axis].total_cmp(&b.centre[axis]));
        let centre = 0.5 * (low + high);
        let mean = leaves.iter().map(|(_, l)| l.axis).sum::<Vec3>().normalize_or_zero();
        let cosine = leaves.iter().map(|(_, l)| l.axis.dot(mean)).fold(1.0, f32::min);
        self.nodes.push(LampNode {
            centre,
            radius: leaves
                .iter()
                .map(|(_, l)| l.centre.distance(centre) + l.radius)
                .fold(0.0, f32::max),
            thickness: leaves
                .iter()
                .map(|(_, l)| mean.dot(l.centre - centre).abs() + l.rise_above(mean))
                .fold(0.0, f32::max),
            power: leaves.iter().map(|(_, l)| l.power).sum(),
            axis: mean,
            cone_sine: if cosine > 0.0 {
                (1.0 - cosine * cosine).max(0.0).sqrt()
            } else {
                1.0
            },
            children: None,
            lamps,
        });
        let (first, second) = leaves.split_at_mut(leaves.len() / 2);
        let children = [self.add_nodes(first), self.add_nodes(second)];
        self.nodes[own as usize].children = Some(children);
        own
    }

    /// Returns the place of the lamp of a node that a `number` in [0, 1) draws by power.
    fn place_by_power(&self, node: &LampNode, number: f32) -> u32 {
        let [first, end] = node.lamps.map(|place| place as usize);
        let before = &self.powers_before;
        let drawn = before[first] + f64::from(number) * (before[end] - before[first]);
        (first + before[first + 1..end].partition_point(|sum| *sum <= drawn)) as u32
    }

    /// Returns the share that the lamp at `place` has in the power of a node.
    fn power_share(&self, node: &LampNode, place: u32) -> f32 {
        let power = |first: u32, end: u32| self.powers_before[end as usize] - self.powers_before[first as usize];
        (power(place, place + 1) / power(node.lamps[0], node.lamps[1])) as f32
    }

    /// Returns the nodes, `most` of them, among which points within the box around `places` choose: those that may light it
    /// most are split first.
    pub fn choose_cut(&self, places: impl Iterator<Item = Vec3>, most: usize) -> LampCut {
        let empty = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let [low, high] = places.fold(empty, |[low, high], place| [low.min(place), high.max(place)]);
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
        nodes.sort_unstable_by_key(|k| self.nodes[*k as usize].lamps[0]);
        LampCut {
            visible: vec![1.0; nodes.len()],
            rays: vec![[0; 2]; nodes.len()],
            nodes,
        }
    }

    /// Weighs the nodes of `cut` for a receiver.
    pub fn weigh_lamps<'a>(&'a self, cut: &'a LampCut, at: Receiver) -> LampChoice<'a> {
        let mut weights = [0.0; MAX_CUT_NODES];
        for ((weight, node), visible) in weights.iter_mut().zip(&cut.nodes).zip(&cut.visible) {
            *weight = self.nodes[*node as usize].light_at(&at).importance * visible;
        }
        round_to_strata(&mut weights);
        let is_whole = |entry: &u8| weights[*entry as usize] >= 1.0;
        let (whole, parts) = (0..cut.nodes.len() as u8).partition::<Vec<u8>, _>(is_whole);
        let mut order = [0; MAX_CUT_NODES];
        let mut ends = [0.0; MAX_CUT_NODES];
        let mut end = 0.0;
        for (k, entry) in whole.into_iter().chain(parts).enumerate() {
            end += weights[entry as usize];
            (order[k], ends[k]) = (entry, end);
        }
        LampChoice {
            tree: self,
            cut,
            at,
            strata: weights,
            order,
            ends,
        }
    }
}

/// Scales weights to a sum of [`STRATUM_COUNT`], those of at least 1 to whole numbers. Weights of 0 stay so.
fn round_to_strata(weights: &mut [f32; MAX_CUT_NODES]) {
    let all: f32 = weights.iter().sum();
    if all <= 0.0 {
        return;
    }
    weights
        .iter_mut()
        .for_each(|weight| *weight = *weight / all * STRATUM_COUNT);
    let (mut whole, mut parts) = (0.0, 0.0);
    for weight in *weights {
        match weight >= 1.0 {
            true => whole += 1.0,
            false => parts += weight,
        }
    }
    // Each whole weight has a stratum; the rest is divided as what it has beyond that.
    let of_parts = parts.ceil();
    let rest = (STRATUM_COUNT - of_parts - whole).max(0.0);
    let excess = (STRATUM_COUNT - parts - whole).max(f32::MIN_POSITIVE);
    let (mut before, mut given) = (0.0, 0.0);
    for weight in weights.iter_mut() {
        match *weight >= 1.0 {
            true => {
                before += (*weight - 1.0) / excess * rest;
                let more = (before + 0.5).floor().min(rest) - given;
                given += more;
                *weight = 1.0 + more;
            }
            false => *weight *= of_parts / parts.max(f32::MIN_POSITIVE),
        }
    }
}

/// Nodes among which nearby points choose a lamp.
pub struct LampCut {
    /// The nodes in the order of their lamps.
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
    /// Strata of each entry of the cut.
    strata: [f32; MAX_CUT_NODES],
    /// The entries in the order in which they divide the strata: those of whole strata first.
    order: [u8; MAX_CUT_NODES],
    /// The strata up to the end of each of them.
    ends: [f32; MAX_CUT_NODES],
}

impl LampChoice<'_> {
    /// Returns the strata of all entries.
    fn all_strata(&self) -> f32 {
        self.cut.nodes.len().checked_sub(1).map_or(0.0, |last| self.ends[last])
    }

    /// Returns the probability of an entry; 0 if no lamp lights the receiver.
    fn entry_probability(&self, entry: usize) -> f32 {
        match self.all_strata() {
            all if all > 0.0 => self.strata[entry] / all,
            _ => 0.0,
        }
    }

    /// Follows children from an entry of the cut down to a lamp, or to a node whose lamps are drawn by power. `takes_first`
    /// chooses, given the probability of the first child and the first place of the second. Returns the node and the
    /// probability of getting there; none if no lamp lights the receiver.
    fn descend(&self, entry: usize, mut takes_first: impl FnMut(f32, u32) -> bool) -> Option<(&LampNode, f32)> {
        let tree = self.tree;
        let mut node = &tree.nodes[self.cut.nodes[entry] as usize];
        let mut even = node.light_at(&self.at).even;
        let mut probability = self.entry_probability(entry);
        while !even && let Some(children) = node.children {
            let children = children.map(|k| &tree.nodes[k as usize]);
            let lights = children.map(|child| child.light_at(&self.at));
            let [a, b] = [0, 1].map(|k| lights[k].importance);
            if a + b <= 0.0 {
                return None;
            }
            let share = a / (a + b);
            let first = takes_first(share, children[1].lamps[0]);
            let taken = usize::from(!first);
            probability *= if first { share } else { 1.0 - share };
            (node, even) = (children[taken], lights[taken].even);
        }
        Some((node, probability))
    }

    /// Draws a lamp by `number` in [0, 1); none if none was found that lights the receiver.
    pub fn draw_lamp(&self, number: f32) -> Option<DrawnLamp> {
        let all = self.all_strata();
        if all <= 0.0 {
            return None;
        }
        // Of the entries whose ends are the same only the first has strata; a product that rounds to all draws the last.
        let drawn = (number * all).min(all.next_down());
        let k = self.ends[..self.cut.nodes.len()].partition_point(|end| *end <= drawn);
        let entry = self.order[k] as usize;
        let own = self.strata[entry];
        let mut number = ((drawn - (self.ends[k] - own)) / own).clamp(0.0, 1.0 - f32::EPSILON);
        let (node, probability) = self.descend(entry, |share, _| {
            let first = number < share;
            number = match first {
                true => number / share,
                false => (number - share) / (1.0 - share),
            };
            first
        })?;
        let place = self.tree.place_by_power(node, number);
        Some(DrawnLamp {
            lamp: self.tree.lamps[place as usize],
            entry,
            probability: probability * self.tree.power_share(node, place),
        })
    }

    /// Returns the probability with which [`Self::draw_lamp`] draws `lamp`.
    pub fn lamp_probability(&self, lamp: u32) -> f32 {
        let tree = self.tree;
        let Some(place) = tree.places[lamp as usize] else {
            return 0.0;
        };
        let not_after = |node: &u32| tree.nodes[*node as usize].lamps[0] <= place;
        let entry = self.cut.nodes.partition_point(not_after) - 1;
        if self.entry_probability(entry) <= 0.0 {
            return 0.0;
        }
        match self.descend(entry, |_, second| place < second) {
            Some((node, probability)) => probability * tree.power_share(node, place),
            None => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::{Face, Scene};
    use glam::{DMat3, DVec3, EulerRot};
    use sobol_burley::sample_4d;

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
            let mut cut = tree.choose_cut([point].into_iter(), [1, 5, MAX_CUT_NODES][k % 3]);
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

    /// Of 128 numbers of any sequence each node with whole strata has as many as it has strata.
    #[test]
    fn nodes_have_their_share_of_any_sequence() {
        let mesh = lamps_on_spiral();
        let tree = LampTree::new(&mesh);
        let mut whole = 0;
        for (k, texel) in mesh.texels.iter().enumerate() {
            let point = texel.position + Vec3::splat(0.1);
            let cut = tree.choose_cut([point].into_iter(), MAX_CUT_NODES);
            let choice = tree.weigh_lamps(&cut, receive_at(point, Vec3::new(0.6, 0.8, 0.0)));
            let mut drawn = [0.0; MAX_CUT_NODES];
            for n in 0..STRATUM_COUNT as u32 {
                let [number, ..] = sample_4d(n, 1, k as u32);
                if let Some(lamp) = choice.draw_lamp(number) {
                    drawn[lamp.entry] += 1.0;
                }
            }
            for (drawn, strata) in drawn.iter().zip(&choice.strata).filter(|(_, strata)| **strata >= 1.0) {
                assert_eq!(drawn, strata);
                whole += 1;
            }
        }
        assert!(whole > 100, "{whole}");
    }

    /// Strata are in proportion to weights but for rounding; small weights share a whole number of them.
    #[test]
    fn weights_are_rounded_to_strata() {
        let of = |own: &[f32]| {
            let mut weights = [0.0; MAX_CUT_NODES];
            weights[..own.len()].copy_from_slice(own);
            round_to_strata(&mut weights);
            let (rounded, others) = weights.split_at(own.len());
            assert!(others.iter().all(|weight| *weight == 0.0));
            rounded.to_vec()
        };
        assert_eq!(of(&[3.0]), [128.0]);
        assert_eq!(of(&[0.0, 0.0]), [0.0, 0.0]);
        assert_eq!(of(&[1.0, 0.0, 1.0, 1.0]), [43.0, 0.0, 42.0, 43.0]);
        assert_eq!(of(&[1.0; MAX_CUT_NODES]), [2.0; MAX_CUT_NODES]);
        // 127.5 of 128 strata, and 0.3 and 0.2 of one, which share the last.
        let shared = of(&[127.5, 0.3, 0.2]);
        assert_eq!(shared[0], 127.0);
        assert!(
            (shared[1] - 0.6).abs() < 1e-5 && (shared[2] - 0.4).abs() < 1e-5,
            "{shared:?}"
        );
    }

    /// Lamps of one wall, seen from afar: each is drawn in proportion to its power, and told to be.
    #[test]
    fn distant_lamps_are_drawn_by_power() {
        let lamp = |k: u32| {
            let corner = DVec3::new(f64::from(k % 4), f64::from(k / 4), 0.0) * 0.1;
            let corners = [[0.0, 0.0], [0.1, 0.0], [0.1, 0.1], [0.0, 0.1]].map(|[x, y]| corner + DVec3::new(x, y, 0.0));
            Face::quad("lamp", corners, Vec3::splat(1.0 + k as f32), Vec3::ZERO)
        };
        let scene = Scene {
            faces: (0..16).map(lamp).collect(),
            ..Scene::default()
        };
        let mesh = Mesh::uniform(&scene, 1, 1).unwrap();
        let tree = LampTree::new(&mesh);
        let middle = mesh.texels.iter().map(|texel| texel.position).sum::<Vec3>() / 16.0;
        let power = |f: u32| (1 + f) as f32;
        let all: f32 = (0..16).map(power).sum();
        // In mesh units: the wall's width is at most 1.
        for (distance, even) in [(20.0, true), (0.1, false)] {
            let point = middle + Vec3::Z * distance;
            let cut = tree.choose_cut([point].into_iter(), 1);
            let choice = tree.weigh_lamps(&cut, receive_at(point, Vec3::NEG_Z));
            let off = (0..16).map(|f| (choice.lamp_probability(f) * all / power(f) - 1.0).abs());
            assert_eq!(off.fold(0.0, f32::max) < 1e-5, even, "at {distance}");
            for number in [0.0, 0.3, 1.0 - f32::EPSILON] {
                let drawn = choice.draw_lamp(number).unwrap();
                assert!((drawn.probability / choice.lamp_probability(drawn.lamp) - 1.0).abs() < 1e-5);
            }
        }
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
            let root = tree.choose_cut([texel.position].into_iter(), 1);
            assert_eq!(tree.weigh_lamps(&root, at).lamp_probability(texel.face), 0.0);
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
        let cut = tree.choose_cut([texel.position].into_iter(), 2);
        let at = Receiver {
            radius: 0.05,
            ..receive_at(texel.position, mesh.faces[0].normal)
        };
        let choice = tree.weigh_lamps(&cut, at);
        let [a, b, c, d] = [0, 1, 2, 3].map(|lamp| choice.lamp_probability(lamp));
        assert_eq!([a, b], [0.0; 2]);
        assert!((c + d - 1.0).abs() < 1e-6, "{c} + {d}");
    }

    /// E A cos θ cos θ' / r²; the lamp's angular size adds at most a hundredth.
    #[test]
    fn bound_of_a_small_lamp_is_its_irradiance() {
        let corners = [[-0.01, -0.01], [0.01, -0.01], [0.01, 0.01], [-0.01, 0.01]];
        let lamp = Lamp {
            number: 0,
            corners: corners.map(|[x, z]| Vec3::new(x, 3.0, z)),
            normal: Vec3::NEG_Y,
            power: 5.0,
        };
        let tree = LampTree::from_lamps([lamp].into_iter(), 1);
        for at in [Vec3::ZERO, Vec3::new(1.0, 0.0, 2.0), Vec3::new(-4.0, 0.0, 3.0)] {
            let square = at.distance_squared(3.0 * Vec3::Y);
            let expected = 5.0 * 9.0 / square / square;
            let light = tree.nodes[0].light_at(&receive_at(at, Vec3::Y));
            let ratio = light.importance / expected;
            assert!((1.0..1.01).contains(&ratio) && light.even, "{at}: {ratio}");
        }
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
        let cut = tree.choose_cut([point].into_iter(), MAX_CUT_NODES);
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
