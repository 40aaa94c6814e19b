//! Collects input faces into a scene, splits those that have to be, and counts what is odd.

use super::input::Polygon;
use super::material::Material;
use super::polygon::{self, Piece, Remark};
use super::surface::{DEFAULT_REFLECTANCE, Surface};
use crate::error::{Error, Result};
use crate::paint::WHITEST;
use crate::scene::{Face, Scene};
use crate::text::plain;
use glam::{DVec3, Vec3};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

/// More faces than this are refused: a small glTF can name one mesh a million times.
pub const MAX_FACES: usize = 1 << 22;

/// So many faces are named in a note.
const NAMED: usize = 6;

/// A scene in the making.
pub struct Builder<'a> {
    path: &'a Path,
    /// Of all faces, whatever the file says.
    reflectance: Option<Vec3>,
    /// Entry k is input face k.
    faces: Vec<Face>,
    /// Further pieces of split faces.
    pieces: Vec<Face>,
    remarks: BTreeMap<Remark, Faces>,
    without_material: Faces,
    /// Materials that reflect all of a channel.
    white: BTreeSet<String>,
    /// Materials of which textures would.
    whitish: BTreeSet<String>,
    /// Materials with textures on faces without coordinates.
    lost: BTreeSet<String>,
    notes: Vec<String>,
}

impl<'a> Builder<'a> {
    /// A scene without faces; `reflectance` is that of all to come, whatever the file says.
    pub fn new(path: &'a Path, reflectance: Option<Vec3>) -> Self {
        Self {
            path,
            reflectance,
            faces: Vec::new(),
            pieces: Vec::new(),
            remarks: BTreeMap::new(),
            without_material: Faces::default(),
            white: BTreeSet::new(),
            whitish: BTreeSet::new(),
            lost: BTreeSet::new(),
            notes: Vec::new(),
        }
    }

    /// Something worth saying about the file.
    pub fn note(&mut self, note: impl Into<String>) {
        self.notes.push(plain(&note.into()));
    }

    /// Whether the file's reflectances are replaced.
    pub fn replaces_reflectance(&self) -> bool {
        self.reflectance.is_some()
    }

    /// The faces so far.
    pub fn faces(&self) -> impl Iterator<Item = &Face> {
        self.faces.iter().chain(&self.pieces)
    }

    /// The next input face; `place` says where in the file it is, for errors.
    pub fn add(
        &mut self,
        name: &str,
        polygon: &Polygon,
        material: Option<&Material>,
        place: impl Fn() -> String,
    ) -> Result<()> {
        let k = self.faces.len();
        let corners = polygon.corners;
        let fail = |message: String| {
            Err(Error::input(
                self.path,
                format!("face {} ({})", k + 1, place()),
                message,
            ))
        };
        if corners.is_empty() || !corners.iter().all(|p| p.is_finite()) {
            return fail("a corner is not a finite number".into());
        }
        if corners.len() > polygon::MAX_CORNERS {
            let (n, most) = (corners.len(), polygon::MAX_CORNERS);
            return fail(format!(
                "has {n} corners, and {most} is the most: split it into triangles"
            ));
        }
        if k + self.pieces.len() >= MAX_FACES {
            return fail(format!(
                "more than {MAX_FACES} faces cannot be solved: simplify the mesh"
            ));
        }
        if material.is_none() {
            self.without_material.add(k);
        }
        let name = &plain(name);
        let (pieces, remarks) = polygon::split(corners);
        for remark in remarks {
            self.remarks.entry(remark).or_default().add(k);
        }
        let split = pieces.len() > 1;
        for (n, piece) in pieces.into_iter().enumerate() {
            let mut face = match piece {
                Piece::Quad(c) => Face::quad(name, c, Vec3::ZERO, Vec3::ZERO),
                Piece::Triangle(c) => Face::triangle(name, c, Vec3::ZERO, Vec3::ZERO),
            };
            self.dress(&mut face, polygon, material)?;
            face.from = split.then_some(k as u32);
            face.rounding = polygon.rounding;
            face.normals = polygon.normals_of(&face.corners);
            face.chart = polygon.chart;
            if n == 0 {
                &mut self.faces
            } else {
                &mut self.pieces
            }
            .push(face);
        }
        Ok(())
    }

    /// What a face reflects and emits.
    fn dress(
        &mut self,
        face: &mut Face,
        polygon: &Polygon,
        material: Option<&Material>,
    ) -> Result<()> {
        let given = self.reflectance;
        let Some(material) = material else {
            face.reflectance = given.unwrap_or(Surface::DEFAULT.reflectance);
            return Ok(());
        };
        let corner = |c: &DVec3| polygon.corners.iter().position(|p| p == c).unwrap_or(0);
        let of: Vec<usize> = face.outline().iter().map(corner).collect();
        let look = material.on(polygon, &of, given.is_some());
        let mut means = look.plain;
        if let Some(paint) = &look.paint {
            let (over, whole) = (
                paint.over(face.outline(), face.outline()),
                paint.whole(of.len()),
            );
            let mean = |k: usize| over[k].or(whole[k]).unwrap_or(look.plain[k]);
            means = [mean(0), mean(1)];
        }
        let radiance = (look.paint.as_ref()).and_then(|paint| paint.coats[1].as_ref());
        let surface = || {
            // Parts of a face shine no brighter than this.
            radiance.map_or(Ok(Surface::DEFAULT), |coat| {
                Surface::new(DVec3::ZERO, coat.factor, material.names)
            })?;
            let reflectance = if given.is_some() {
                DVec3::ZERO
            } else {
                means[0]
            };
            Surface::new(reflectance, means[1], material.names)
        };
        let fail = |message| {
            let place = format!("material {}", material.name);
            Error::input(&material.file, place, message)
        };
        let surface = surface().map_err(fail)?;
        if given.is_none() && means[0].as_vec3().max_element() == 1.0 {
            add(&mut self.white, &material.name);
        } else if given.is_none() && look.white {
            add(&mut self.whitish, &material.name);
        }
        if look.lost {
            add(&mut self.lost, &material.name);
        }
        face.reflectance = given.unwrap_or(surface.reflectance);
        face.emission = surface.emission;
        face.paint = look.paint.and_then(|mut paint| {
            if face.emission == Vec3::ZERO {
                paint.coats[1] = None;
            }
            let varies = paint.coats.iter().any(Option::is_some);
            varies.then(|| Arc::new(paint))
        });
        Ok(())
    }

    /// The scene, if it can be lit at all.
    pub fn finish(mut self) -> Result<Scene> {
        let count = self.faces.len();
        if count == 0 {
            return Err(Error::input(self.path, "", "has no faces"));
        }
        if self
            .remarks
            .get(&Remark::NoArea)
            .is_some_and(|f| f.count == count)
        {
            return Err(Error::input(
                self.path,
                "",
                format!("none of its {count} faces has an area"),
            ));
        }
        for (remark, faces) in &self.remarks {
            self.notes.push(faces.note(sentence(*remark)));
        }
        if self.without_material.count > 0 {
            let taken = match self.reflectance {
                None => format!("reflectance {DEFAULT_REFLECTANCE}, "),
                Some(_) => String::new(),
            };
            let without = format!("without material: {taken}no emission");
            self.notes.push(self.without_material.note(&without));
        }
        if let Some(names) = listed(&self.lost) {
            self.note(format!(
                "textures on faces without coordinates are taken as their mean: materials {names}"
            ));
        }
        if let Some(names) = listed(&self.white) {
            self.note(format!(
                "materials {names} reflect all light: taken as {WHITEST}"
            ));
        }
        if let Some(names) = listed(&self.whitish) {
            self.note(format!(
                "materials {names} reflect all light in places: taken as {WHITEST} there"
            ));
        }
        self.faces.append(&mut self.pieces);
        Ok(Scene {
            name: plain(&self.path.display().to_string()),
            faces: self.faces,
            notes: self.notes,
        })
    }
}

fn add(names: &mut BTreeSet<String>, name: &str) {
    if !names.contains(name) {
        names.insert(name.into());
    }
}

/// None where there is none.
fn listed(names: &BTreeSet<String>) -> Option<String> {
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    (!names.is_empty()).then(|| names.join(", "))
}

fn sentence(remark: Remark) -> &'static str {
    match remark {
        Remark::NoArea => "without area: neither lit nor lighting",
        Remark::Repeated => "with a repeated corner, which counts once",
        Remark::NonPlanar => "not planar: split into two triangles",
        Remark::NonConvex => "not convex: split into two triangles",
        Remark::Polygon => "with more than four corners: split into triangles",
    }
}

/// How many input faces share an oddity, and the first of them.
#[derive(Default)]
struct Faces {
    count: usize,
    first: Vec<usize>,
}

impl Faces {
    fn add(&mut self, k: usize) {
        self.count += 1;
        if self.first.len() < NAMED {
            self.first.push(k);
        }
    }

    fn note(&self, what: &str) -> String {
        let names: Vec<String> = self.first.iter().map(|k| (k + 1).to_string()).collect();
        let more = if self.count > NAMED { ", …" } else { "" };
        let s = if self.count == 1 { "" } else { "s" };
        format!("{} face{s} {what} ({}{more})", self.count, names.join(", "))
    }
}
