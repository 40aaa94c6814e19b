//! glTF 2.0 and GLB: the default scene's meshes, where their nodes put them.
//!
//! The crate `gltf` parses; everything it finds is taken by checked access, since its own readers
//! and its validation panic on damaged files.

mod accessor;
mod buffers;
mod indices;
mod lights;
mod material;
mod primitive;
mod texture;

use super::ImportOptions;
use super::builder::Builder;
use super::input::Polygon;
use super::material::{Colour, Material};
use super::polygon;
use crate::error::{Error, Result};
use crate::precision::ROUNDOFF;
use buffers::Document;
use glam::{DMat4, DQuat, DVec3};
use gltf::json::mesh::Semantic;
use gltf::json::scene::Node;
use gltf::json::validation::Checked;
use gltf::json::{self, Index, Mesh};
use primitive::{Asked, Triangle};
use std::collections::BTreeMap;
use std::path::Path;
use std::rc::Rc;
use texture::Pictures;

/// Adds the faces of a glTF file.
pub fn read(
    builder: &mut Builder,
    path: &Path,
    bytes: &[u8],
    options: &ImportOptions,
) -> Result<()> {
    let document = Document::read(path, bytes)?;
    let mut import = Import {
        path,
        document: &document,
        builder,
        join_quads: options.join_quads && !options.charts,
        charts: options.charts,
        pictures: Pictures::new(path, &document),
        materials: BTreeMap::new(),
        lamps: Vec::new(),
        left_out: LeftOut::default(),
    };
    import.scene()?;
    lights::add(import.builder, path, &document, &import.lamps)?;
    import.notes();
    Ok(())
}

struct Import<'a, 'b> {
    path: &'a Path,
    document: &'a Document,
    builder: &'a mut Builder<'b>,
    join_quads: bool,
    charts: bool,
    pictures: Pictures<'a>,
    /// Those used so far, and the sets of coordinates of their textures.
    materials: BTreeMap<usize, (Rc<Material>, [Option<u32>; 2])>,
    /// Lights without a surface, and where their nodes put them.
    lamps: Vec<(usize, DMat4)>,
    left_out: LeftOut,
}

/// What the file has and the scene has not.
#[derive(Default)]
struct LeftOut {
    points_and_lines: usize,
    poses: bool,
}

impl Import<'_, '_> {
    fn fail<T>(&self, place: impl Into<String>, message: impl Into<String>) -> Result<T> {
        Err(Error::input(self.path, place, message))
    }

    /// Depth first, in file order, without recursion: a file may nest as deep as it likes.
    fn scene(&mut self) -> Result<()> {
        let nodes = &self.document.root.nodes;
        let mut stack: Vec<(usize, DMat4)> = self
            .roots()?
            .into_iter()
            .rev()
            .map(|n| (n, DMat4::IDENTITY))
            .collect();
        let mut seen = vec![false; nodes.len()];
        while let Some((index, parent)) = stack.pop() {
            let place = || format!("node {index}");
            let Some(node) = nodes.get(index) else {
                return self.fail(place(), "does not exist");
            };
            // glTF's nodes are a tree; without that, few of them could make any number of faces.
            if std::mem::replace(&mut seen[index], true) {
                return self.fail(place(), "has two parents, or is its own ancestor");
            }
            let world = parent * transform(node);
            if let Some(mesh) = node.mesh {
                self.left_out.poses |= node.skin.is_some();
                self.mesh(node, mesh, world)?;
            }
            let lights = node.extensions.as_ref();
            if let Some(light) = lights.and_then(|e| e.khr_lights_punctual.as_ref()) {
                self.lamps.push((light.light.value(), world));
            }
            let children = node.children.iter().flatten().rev();
            stack.extend(children.map(|child| (child.value(), world)));
        }
        Ok(())
    }

    /// The roots of the default scene, else of the first, else all nodes that are nobody's child.
    fn roots(&self) -> Result<Vec<usize>> {
        let root = &self.document.root;
        let scene = match root.scene {
            Some(index) => match root.get(index) {
                Some(scene) => Some(scene),
                None => return self.fail(format!("scene {index}"), "does not exist"),
            },
            None => root.scenes.first(),
        };
        if let Some(scene) = scene {
            return Ok(scene.nodes.iter().map(Index::value).collect());
        }
        let mut is_root = vec![true; root.nodes.len()];
        for child in root
            .nodes
            .iter()
            .flat_map(|node| node.children.iter().flatten())
        {
            if let Some(flag) = is_root.get_mut(child.value()) {
                *flag = false;
            }
        }
        Ok((0..is_root.len()).filter(|k| is_root[*k]).collect())
    }

    fn mesh(&mut self, node: &Node, index: Index<Mesh>, world: DMat4) -> Result<()> {
        let Some(mesh) = self.document.root.get(index) else {
            return self.fail(format!("mesh {index}"), "does not exist");
        };
        let name = node
            .name
            .clone()
            .or_else(|| mesh.name.clone())
            .unwrap_or_else(|| format!("mesh {index}"));
        for (k, primitive) in mesh.primitives.iter().enumerate() {
            self.left_out.poses |= primitive.targets.is_some();
            let colour = Checked::Valid(Semantic::Colors(0));
            let coloured =
                primitive.attributes.contains_key(&colour) && !self.builder.replaces_reflectance();
            let place = format!("mesh {index} primitive {k}");
            let material = match primitive.material {
                Some(material) => Some(self.material(material)?),
                // glTF's default is white, so that the colours are those that are seen.
                None => coloured.then(|| (Rc::new(self.white()), [None; 2])),
            };
            let asked = Asked {
                sets: material.as_ref().map_or([None; 2], |(_, sets)| *sets),
                colours: coloured,
                charts: self.charts,
            };
            let corners = match primitive::triangles(self.document, primitive, &asked) {
                Ok(Some(corners)) => corners,
                Ok(None) => {
                    self.left_out.points_and_lines += 1;
                    continue;
                }
                Err(message) => return self.fail(place, message),
            };
            let roundings: Vec<f64> = corners.iter().map(|t| rounding(t, world)).collect();
            let triangles = placed(corners, world);
            self.faces(&name, &place, (&triangles, &roundings), material.as_ref())?;
        }
        Ok(())
    }

    fn faces(
        &mut self,
        name: &str,
        place: &str,
        (triangles, roundings): (&[Triangle], &[f64]),
        material: Option<&(Rc<Material>, [Option<u32>; 2])>,
    ) -> Result<()> {
        let mut rest = triangles;
        while let Some((first, after)) = rest.split_first() {
            let quad = after
                .first()
                .filter(|second| self.join_quads && first.goes_on(second))
                .and_then(|second| polygon::join(first.corners, second.corners));
            let used = if quad.is_some() { 2 } else { 1 };
            let begin = triangles.len() - rest.len();
            let rounding = roundings[begin..begin + used]
                .iter()
                .copied()
                .fold(0.0, f64::max);
            let corners = quad
                .as_ref()
                .map_or(first.corners.as_slice(), |q| q.as_slice());
            let own = &rest[..used];
            let normals = each(corners, own, |t| t.normals);
            let places = [0, 1].map(|k| each(corners, own, |t| t.places[k]));
            let colours = each(corners, own, |t| t.colours);
            // A corner of both lies on the diagonal.
            let odd = own.len() > 1 && own.iter().all(|t| t.corners.contains(&corners[1]));
            let polygon = Polygon {
                corners,
                normals: &normals.unwrap_or_default(),
                rounding,
                places: places.each_ref().map(Option::as_deref),
                colours: colours.as_deref(),
                odd,
                chart: first.chart,
            };
            let material = material.map(|(material, _)| material.as_ref());
            let place = || format!("{place}, node {name}");
            self.builder.add(name, &polygon, material, place)?;
            rest = &rest[used..];
        }
        Ok(())
    }

    /// What primitives without a material have.
    fn white(&self) -> Material {
        Material {
            file: self.path.to_owned(),
            name: "of vertex colours".into(),
            colours: [DVec3::ONE, DVec3::ZERO].map(Colour::plain),
            names: ["COLOR_0", ""],
        }
    }

    fn material(
        &mut self,
        index: Index<json::Material>,
    ) -> Result<(Rc<Material>, [Option<u32>; 2])> {
        if let Some(material) = self.materials.get(&index.value()) {
            return Ok(material.clone());
        }
        let Some(material) = self.document.root.get(index) else {
            return self.fail(format!("material {index}"), "does not exist");
        };
        let name = material::name(material, index.value());
        let replaced = self.builder.replaces_reflectance();
        let (read, sets) = material::read(
            material,
            (self.path, name.clone()),
            &mut self.pictures,
            replaced,
        )
        .or_else(|message| self.fail(format!("material {name}"), message))?;
        let material = (Rc::new(read), sets);
        self.materials.insert(index.value(), material.clone());
        Ok(material)
    }

    fn notes(&mut self) {
        let root = &self.document.root;
        let mut materials: BTreeMap<&str, Vec<String>> = BTreeMap::new();
        for (k, material) in self
            .materials
            .keys()
            .filter_map(|k| Some((*k, root.materials.get(*k)?)))
        {
            for word in material::left_out(material) {
                materials
                    .entry(word)
                    .or_default()
                    .push(material::name(material, k));
            }
        }
        for (word, names) in materials {
            self.builder
                .note(format!("materials that are {word}: {}", names.join(", ")));
        }
        let LeftOut {
            points_and_lines,
            poses,
        } = self.left_out;
        if points_and_lines > 0 {
            self.builder.note(format!(
                "{points_and_lines} primitives of points or lines left out"
            ));
        }
        let unread = buffers::unread(root);
        if !unread.is_empty() {
            let names = unread.join(", ");
            self.builder
                .note(format!("extensions that are not read: {names}"));
        }
        if let Some(note) = self.pictures.note() {
            self.builder.note(note);
        }
        if poses {
            self.builder
                .note("skins and morph targets are not used: meshes are as modelled");
        }
    }
}

/// What the triangles that make up a face have at its corners; none where one has none.
fn each<T: Copy>(
    corners: &[DVec3],
    triangles: &[Triangle],
    of: impl Fn(&Triangle) -> Option<[T; 3]>,
) -> Option<Vec<T>> {
    let value = |corner: &DVec3| {
        triangles.iter().find_map(|triangle| {
            let k = triangle.corners.iter().position(|c| c == corner)?;
            Some(of(triangle)?[k])
        })
    };
    corners.iter().map(value).collect()
}

fn transform(node: &Node) -> DMat4 {
    if let Some(columns) = node.matrix {
        return DMat4::from_cols_array(&columns.map(f64::from));
    }
    let vector =
        |v: Option<[f32; 3]>, default: DVec3| v.map_or(default, |v| DVec3::from(v.map(f64::from)));
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |q| {
        DQuat::from_array(q.0.map(f64::from)).normalize()
    });
    DMat4::from_scale_rotation_translation(
        vector(node.scale, DVec3::ONE),
        rotation,
        vector(node.translation, DVec3::ZERO),
    )
}

/// What the file's f32 or integers may have rounded a coordinate of the triangle by, in the world. Where a
/// node puts its mesh is the same for all its corners.
fn rounding(triangle: &Triangle, world: DMat4) -> f64 {
    let [x, y, z] = [world.x_axis, world.y_axis, world.z_axis].map(|axis| axis.truncate().abs());
    let in_world = |p: DVec3| (x * p.x + y * p.y + z * p.z).max_element();
    let off = |p: &DVec3| match triangle.step {
        0.0 => ROUNDOFF * in_world(p.abs()),
        step => in_world(DVec3::splat(step)),
    };
    triangle.corners.iter().map(off).fold(0.0, f64::max)
}

/// Triangles in the world; a mirroring node turns them round, so that fronts stay fronts. Normals stay as
/// they are: whether two are the same is all that is asked of them.
fn placed(triangles: Vec<Triangle>, world: DMat4) -> Vec<Triangle> {
    let mirrored = world.determinant() < 0.0;
    let turned = if mirrored { [0, 2, 1] } else { [0, 1, 2] };
    let place = |triangle: Triangle| Triangle {
        corners: turned.map(|k| world.transform_point3(triangle.corners[k])),
        normals: triangle.normals.map(|normals| turned.map(|k| normals[k])),
        places: triangle
            .places
            .map(|places| places.map(|places| turned.map(|k| places[k]))),
        colours: triangle.colours.map(|colours| turned.map(|k| colours[k])),
        chart: triangle.chart.map(|chart| turned.map(|k| chart[k])),
        ..triangle
    };
    triangles.into_iter().map(place).collect()
}
