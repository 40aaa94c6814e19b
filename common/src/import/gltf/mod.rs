//! Reads glTF 2.0 and GLB files: the meshes of the default scene, transformed by their nodes.
//!
//! The crate `gltf` parses the JSON and decodes numbers. Each access is checked here, since the crate's validation
//! and its readers of whole accessors panic on damaged files.

mod accessor;
mod document;
mod draco;
mod lights;
mod material;
mod primitive;

use super::ImportOptions;
use super::builder::Builder;
use super::material::{ImportedMaterial, InputVertex};
use super::picture_cache::PictureCache;
use super::polygon;
use super::scene_file::{FileTriangle, PlacedPrimitive};
use crate::error::{Error, Result};
use document::GltfDocument;
use glam::{DMat4, DQuat, DVec3};
use gltf::json::mesh::Semantic;
use gltf::json::scene::Node;
use gltf::json::validation::Checked;
use gltf::json::{self, Index, Mesh};
pub use material::DOUBLE_SIDED;
use std::collections::BTreeMap;
use std::path::Path;
use std::rc::Rc;

/// Adds the faces of a glTF file to `builder`.
///
/// Errors: the file is invalid, or a part of it cannot be read.
pub fn read(builder: &mut Builder, path: &Path, bytes: &[u8], options: &ImportOptions) -> Result<()> {
    let mut document = GltfDocument::read(path, bytes)?;
    draco::decode_meshes(&mut document).map_err(|(place, message)| Error::bad_input(path, place, message))?;
    if let Some(file) = &mut builder.file {
        file.json.clone_from(&document.json);
    }
    let (white, names) = ([DVec3::ONE, DVec3::ZERO], ["COLOR_0", ""]);
    let white = ImportedMaterial::from_factors(path, "of vertex colours", white, names);
    let mut import = GltfImport {
        path,
        document: &document,
        builder: &mut *builder,
        join_quads: options.join_quads && !options.charts,
        charts: options.charts,
        two_sided: options.two_sided,
        pictures: PictureCache::new(),
        vertex_material: Rc::new(white),
        materials: BTreeMap::new(),
        lamps: Vec::new(),
        points_and_lines: 0,
        has_poses: false,
    };
    import.import_scene()?;
    lights::add_lamps(import.builder, path, &document, &import.lamps)?;
    import.add_notes();
    if let Some(file) = &mut builder.file {
        file.buffers = document.buffers;
    }
    Ok(())
}

struct GltfImport<'a, 'b> {
    path: &'a Path,
    document: &'a GltfDocument,
    builder: &'a mut Builder<'b>,
    join_quads: bool,
    charts: bool,
    two_sided: bool,
    pictures: PictureCache<usize>,
    /// Material of primitives with vertex colours alone.
    vertex_material: Rc<ImportedMaterial>,
    /// Materials used so far.
    materials: BTreeMap<usize, GltfMaterial>,
    /// Lights without a surface, and their nodes' transforms.
    lamps: Vec<(usize, DMat4)>,
    /// Number of primitives of points or lines.
    points_and_lines: usize,
    /// True if a mesh has a skin or morph targets.
    has_poses: bool,
}

/// A material, and the sets of texture coordinates of its textures.
type GltfMaterial = (Rc<ImportedMaterial>, [Option<u32>; 2]);

impl GltfImport<'_, '_> {
    fn fail_at<T>(&self, place: impl Into<String>, message: impl Into<String>) -> Result<T> {
        Err(Error::bad_input(self.path, place, message))
    }

    /// Imports the nodes depth first, in file order, without recursion: nodes may nest to any depth.
    fn import_scene(&mut self) -> Result<()> {
        let nodes = &self.document.root.nodes;
        let roots = self.root_nodes()?.into_iter().rev();
        let mut stack: Vec<(usize, DMat4)> = roots.map(|n| (n, DMat4::IDENTITY)).collect();
        let mut seen = vec![false; nodes.len()];
        while let Some((index, parent)) = stack.pop() {
            let place = || format!("node {index}");
            let Some(node) = nodes.get(index) else {
                return self.fail_at(place(), "does not exist");
            };
            // glTF's nodes form a tree; otherwise a few nodes could make any number of faces.
            if std::mem::replace(&mut seen[index], true) {
                return self.fail_at(place(), "has two parents, or is its own ancestor");
            }
            let world = parent * node_transform(node);
            if let Some(mesh) = node.mesh {
                self.has_poses |= node.skin.is_some();
                self.import_mesh(index, mesh, world)?;
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

    /// Returns the roots of the default scene, else of the first scene, else all nodes without a parent.
    fn root_nodes(&self) -> Result<Vec<usize>> {
        let root = &self.document.root;
        let scene = match root.scene {
            Some(index) => match root.get(index) {
                Some(scene) => Some(scene),
                None => return self.fail_at(format!("scene {index}"), "does not exist"),
            },
            None => root.scenes.first(),
        };
        if let Some(scene) = scene {
            return Ok(scene.nodes.iter().map(Index::value).collect());
        }
        let mut is_root = vec![true; root.nodes.len()];
        for child in root.nodes.iter().flat_map(|n| n.children.iter().flatten()) {
            if let Some(flag) = is_root.get_mut(child.value()) {
                *flag = false;
            }
        }
        Ok((0..is_root.len()).filter(|k| is_root[*k]).collect())
    }

    fn import_mesh(&mut self, number: usize, index: Index<Mesh>, world: DMat4) -> Result<()> {
        let document = self.document;
        let node = &document.root.nodes[number];
        let Some(mesh) = document.root.get(index) else {
            return self.fail_at(format!("mesh {index}"), "does not exist");
        };
        let name = node.name.as_ref().or(mesh.name.as_ref()).cloned();
        let name = name.unwrap_or_else(|| format!("mesh {index}"));
        for (k, primitive) in mesh.primitives.iter().enumerate() {
            self.has_poses |= primitive.targets.is_some();
            let colour = Checked::Valid(Semantic::Colors(0));
            let replaced = self.builder.reflectance.is_some();
            let coloured = primitive.attributes.contains_key(&colour) && !replaced;
            let place = format!("mesh {index} primitive {k}");
            let material = match primitive.material {
                Some(material) => Some(self.cached_material(material)?),
                // glTF's default material is white: the vertex colours are the reflectance.
                None => coloured.then(|| (self.vertex_material.clone(), [None; 2])),
            };
            let sets = material.as_ref().map_or([None; 2], |(_, sets)| *sets);
            match primitive::read_triangles(self.document, primitive, world, sets, coloured, self.charts) {
                Ok(Some(faces)) => {
                    if let Some(file) = &mut self.builder.file {
                        file.primitives.push(PlacedPrimitive {
                            node: number,
                            mesh: index.value(),
                            number: k,
                            triangles: Vec::with_capacity(faces.len()),
                        });
                    }
                    self.import_faces(&name, &place, &faces, material.as_ref())?;
                    let kept = self.builder.file.as_mut().and_then(|file| file.primitives.last_mut());
                    // The file's own winding.
                    if let Some(kept) = kept.filter(|_| world.determinant() < 0.0) {
                        kept.triangles.iter_mut().for_each(FileTriangle::reverse);
                    }
                }
                Ok(None) => self.points_and_lines += 1,
                Err(message) => return self.fail_at(place, message),
            }
        }
        Ok(())
    }

    fn import_faces(
        &mut self,
        name: &str,
        place: &str,
        triangles: &[[InputVertex; 3]],
        material: Option<&GltfMaterial>,
    ) -> Result<()> {
        let outline = |triangle: &[InputVertex; 3]| triangle.map(|vertex| vertex.position);
        let mut rest = triangles;
        while let Some((first, after)) = rest.split_first() {
            let second = after
                .first()
                .filter(|second| self.join_quads && are_continuous(first, second));
            let quad = second.and_then(|second| polygon::join_triangles(outline(first), outline(second)));
            let (parts, after) = rest.split_at(if quad.is_some() { 2 } else { 1 });
            let mut corners = first.to_vec();
            if let Some(quad) = quad {
                let vertex = |corner: &DVec3| parts.as_flattened().iter().find(|v| v.position == *corner);
                corners = quad.iter().filter_map(vertex).copied().collect();
            }
            // A corner that both triangles have lies on the diagonal.
            let odd = quad.is_some() && parts.iter().all(|t| outline(t).contains(&corners[1].position));
            let material = material.map(|(material, _)| material.as_ref());
            let place = || format!("{place}, node {name}");
            let face = self.builder.faces.len() as u32;
            if let Some(primitive) = self.builder.file.as_mut().and_then(|file| file.primitives.last_mut()) {
                primitive.triangles.extend(parts.iter().map(|part| FileTriangle {
                    face,
                    vertices: part.map(|vertex| vertex.index),
                    positions: outline(part),
                }));
            }
            self.builder.add_face(name, &corners, odd, material, place)?;
            rest = after;
        }
        Ok(())
    }

    fn cached_material(&mut self, index: Index<json::Material>) -> Result<GltfMaterial> {
        if let Some(material) = self.materials.get(&index.value()) {
            return Ok(material.clone());
        }
        let document = self.document;
        let Some(material) = document.root.get(index) else {
            return self.fail_at(format!("material {index}"), "does not exist");
        };
        let name = material.name.clone().unwrap_or_else(|| index.to_string());
        let read = self.read_material(material, name.clone());
        let (read, sets) = read.or_else(|message| self.fail_at(format!("material {name}"), message))?;
        let material = (Rc::new(read), sets);
        self.materials.insert(index.value(), material.clone());
        Ok(material)
    }

    fn add_notes(&mut self) {
        let root = &self.document.root;
        let mut materials: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for (k, (material, _)) in &self.materials {
            for words in material::unsupported_features(&root.materials[*k], self.two_sided) {
                materials.entry(words).or_default().push(&material.name);
            }
        }
        let materials = materials.into_iter();
        let mut notes: Vec<String> = materials
            .map(|(words, names)| format!("materials that are {words}: {}", names.join(", ")))
            .collect();
        let (left_out, unread) = (self.points_and_lines, document::unsupported_extensions(root).join(", "));
        notes.extend((left_out > 0).then(|| format!("{left_out} primitives of points or lines left out")));
        notes.extend((!unread.is_empty()).then(|| format!("extensions that are not read: {unread}")));
        notes.extend(self.pictures.resolution_note());
        let poses = "skins and morph targets are not used: meshes are as modelled";
        notes.extend(self.has_poses.then(|| poses.into()));
        notes.into_iter().for_each(|note| self.builder.add_note(note));
    }
}

/// Returns whether texture coordinates and colours of two triangles agree at their common corners.
fn are_continuous(first: &[InputVertex; 3], second: &[InputVertex; 3]) -> bool {
    first.iter().all(|a| {
        let there = second.iter().find(|b| b.position == a.position);
        there.is_none_or(|b| (a.texture_coordinates, a.colour) == (b.texture_coordinates, b.colour))
    })
}

fn node_transform(node: &Node) -> DMat4 {
    if let Some(columns) = node.matrix {
        return DMat4::from_cols_array(&columns.map(f64::from));
    }
    let vector = |v: Option<[f32; 3]>, default: DVec3| v.map_or(default, |v| DVec3::from(v.map(f64::from)));
    let rotation = node
        .rotation
        .map_or(DQuat::IDENTITY, |q| DQuat::from_array(q.0.map(f64::from)).normalize());
    DMat4::from_scale_rotation_translation(
        vector(node.scale, DVec3::ONE),
        rotation,
        vector(node.translation, DVec3::ZERO),
    )
}
