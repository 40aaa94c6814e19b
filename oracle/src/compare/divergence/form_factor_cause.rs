//! Finds the part of a form factor that explains its difference: the CPU computes F again with one cosine, distance or
//! area changed, and counts the texels at which that gives the GPU's F.

use crate::compare::parting::Factor;
use crate::compare::roundings::form_factor_roundings;
use crate::compare::stages::factor_scales;
use common::constants::{CONTACT_DISTANCE, PI};
use common::form_factor::{FormFactor, Shooter, disc_factor, form_factor};
use common::mesh::{Mesh, Texel};
use cpu::shader_twins::link::mean_over_texel;
use glam::Vec3;
use stage_check::tally::ulp_distance;

/// Least share of the differing texels that a cause has to explain.
const MIN_EXPLAINED_SHARE: f64 = 0.9;

/// Parts of the form factor at one point.
#[derive(Clone, Copy)]
struct FactorParts {
    /// Cosines at the shooter and at the receiver; negative where they face away.
    cosines: [f32; 2],
    distance: f32,
    /// Areas of shooter and texel.
    areas: [f32; 2],
    /// Area of the disc in the denominator.
    disc_area: f32,
    /// The shooter's horizon hides the point.
    below: bool,
    /// F as it should be.
    expected: f32,
}

/// A change of the form factor: the factor, the change in words, and F with it.
type Change = (Factor, &'static str, fn(&FactorParts) -> f32);

/// Changes of a disc's form factor.
const DISC_CHANGES: [Change; 16] = [
    (Factor::Cosine, "the cosine at the receiver is missing", |p| {
        p.disc(p.up(0), 1.0)
    }),
    (Factor::Cosine, "the cosine at the shooter is missing", |p| {
        p.disc(1.0, p.up(1))
    }),
    (Factor::Cosine, "both cosines are missing", |p| p.disc(1.0, 1.0)),
    (
        Factor::Cosine,
        "the cosine at the receiver is not cut off below its horizon",
        |p| p.disc(p.up(0), p.cosines[1]),
    ),
    (
        Factor::Cosine,
        "the cosine at the receiver counts by its absolute value",
        |p| p.disc(p.up(0), p.cosines[1].abs()),
    ),
    (Factor::Cosine, "the receiver's normal points the other way", |p| {
        p.disc(p.up(0), (-p.cosines[1]).max(0.0))
    }),
    (
        Factor::Cosine,
        "the cosine at the shooter is not cut off below its horizon",
        |p| p.free_disc(p.cosines[0], p.up(1)),
    ),
    (
        Factor::Cosine,
        "the cosine at the shooter counts by its absolute value",
        |p| p.free_disc(p.cosines[0].abs(), p.up(1)),
    ),
    (Factor::Cosine, "the shooter's normal points the other way", |p| {
        p.free_disc((-p.cosines[0]).max(0.0), p.up(1))
    }),
    (Factor::Distance, "1/d in the place of 1/d²", |p| {
        p.over(PI * p.distance + p.disc_area)
    }),
    (Factor::Distance, "1/d⁴ in the place of 1/d²", |p| {
        p.over(PI * p.distance.powi(4) + p.disc_area)
    }),
    (Factor::FormFactor, "π is missing beside the distance", |p| {
        p.over(p.distance.powi(2) + p.disc_area)
    }),
    (Factor::Area, "the disc's area is missing beside the distance", |p| {
        p.over(PI * p.distance.powi(2))
    }),
    (Factor::Area, "the texel's area in the place of the shooter's", |p| {
        p.of_areas(p.areas[1], p.disc_area)
    }),
    (
        Factor::Area,
        "the texel's area in the place of the shooter's, for the disc too",
        |p| p.of_areas(p.areas[1], p.areas[1]),
    ),
    (Factor::Area, "the area of the other side for the disc", |p| {
        p.of_areas(p.areas[0], p.other_disc_area())
    }),
];

/// Changes of any form factor.
const ANY_CHANGES: [Change; 4] = [
    (
        Factor::Cosine,
        "the cosine at the receiver counts once too often",
        |p| p.expected * p.up(1),
    ),
    (Factor::Cosine, "the cosine at the shooter counts once too often", |p| {
        p.expected * p.up(0)
    }),
    (
        Factor::Area,
        "the form factor of a disc in the place of the polygon's",
        |p| p.disc(p.up(0), p.up(1)),
    ),
    (Factor::FormFactor, "it is 0", |_| 0.0),
];

/// Ratios of GPU to CPU with a name.
const NAMED_RATIOS: [(f32, &str); 4] = [
    (PI, "1/π is missing"),
    (1.0 / PI, "1/π counts twice"),
    (2.0, "it is twice as large"),
    (0.5, "it is half as large"),
];

impl FactorParts {
    fn new(kind: FormFactor, shooter: &Shooter, texel: &Texel, position: Vec3, normal: Vec3) -> Self {
        let d = position - shooter.centre;
        let distance = d.length();
        let height = shooter.normal.dot(d);
        Self {
            cosines: [height / distance, -normal.dot(d) / distance],
            distance,
            areas: [shooter.area, texel.area],
            disc_area: if kind == FormFactor::Paper {
                texel.area
            } else {
                shooter.area
            },
            below: height <= CONTACT_DISTANCE,
            expected: form_factor(kind, shooter, position, normal, texel.area),
        }
    }

    /// Returns a cosine, 0 below the horizon.
    fn up(&self, side: usize) -> f32 {
        self.cosines[side].max(0.0)
    }

    /// Returns the factor of a disc with these cosines, without a horizon of the shooter.
    fn free_disc(&self, at_shooter: f32, at_receiver: f32) -> f32 {
        disc_factor(
            at_shooter,
            at_receiver,
            self.distance * self.distance,
            self.areas[0],
            self.disc_area,
        )
    }

    fn disc(&self, at_shooter: f32, at_receiver: f32) -> f32 {
        if self.below {
            0.0
        } else {
            self.free_disc(at_shooter, at_receiver)
        }
    }

    /// Returns A·cosines over another denominator.
    fn over(&self, denominator: f32) -> f32 {
        if self.below {
            0.0
        } else {
            self.areas[0] * self.up(0) * self.up(1) / denominator
        }
    }

    fn of_areas(&self, shooter_area: f32, disc_area: f32) -> f32 {
        let r2 = self.distance * self.distance;
        if self.below {
            0.0
        } else {
            disc_factor(self.up(0), self.up(1), r2, shooter_area, disc_area)
        }
    }

    fn other_disc_area(&self) -> f32 {
        self.areas[0] + self.areas[1] - self.disc_area
    }
}

/// F of a texel from a position with a normal, changed.
type Changed<'c> = &'c dyn Fn(u32, Vec3, Vec3) -> f32;

/// Numbers of texels at which a change gives the GPU's F.
struct Fit {
    /// Of those that differ.
    explained: usize,
    /// Of all.
    texels: usize,
}

/// The GPU's form factors of one shooter beside the CPU's.
pub struct FormFactorCause<'a> {
    mesh: &'a Mesh,
    kind: FormFactor,
    patch: u32,
    /// The GPU's F of each texel.
    gpu: &'a [f32],
    sizes: Vec<f32>,
    /// Texels at which they differ by more than rounding.
    differing: Vec<u32>,
}

impl<'a> FormFactorCause<'a> {
    /// Compares the GPU's F of every texel with those of the CPU.
    pub fn new(mesh: &'a Mesh, kind: FormFactor, patch: u32, [gpu, cpu]: [&'a [f32]; 2]) -> Self {
        let sizes = factor_scales(mesh, kind, patch);
        let differs = |k: &u32| {
            let k = *k as usize;
            differ(kind, gpu[k], cpu[k], sizes[k])
        };
        let differing = (0..mesh.texels.len() as u32).filter(differs).collect();
        Self {
            mesh,
            kind,
            patch,
            gpu,
            sizes,
            differing,
        }
    }

    /// Returns the part that explains the difference at texel `k` and at most of the others, in words.
    pub fn find_cause(&self, k: u32, [gpu, cpu]: [f32; 2]) -> (Factor, String) {
        let is_disc = self.kind != FormFactor::Polygon;
        let changes = DISC_CHANGES.iter().filter(|_| is_disc).chain(&ANY_CHANGES);
        let mut fits: Vec<(Fit, Factor, String)> = Vec::new();
        for (factor, text, change) in changes {
            let fit = self.fit(k, &|k, position, normal| change(&self.parts(k, position, normal)));
            fits.extend(fit.map(|fit| (fit, *factor, (*text).to_owned())));
        }
        let ratio = gpu / cpu;
        if ratio.is_finite() && ratio != 0.0 {
            let fit = self.fit(k, &|k, position, normal| {
                ratio * self.parts(k, position, normal).expected
            });
            let named = NAMED_RATIOS
                .iter()
                .find(|(x, _)| ulp_distance(*x, ratio, *x) <= self.roundings());
            let text = named.map_or(format!("it is {ratio:.4} times as large"), |(_, text)| {
                (*text).to_owned()
            });
            fits.extend(fit.map(|fit| (fit, Factor::FormFactor, text)));
        }
        let all = self.differing.len();
        // Of equal fits the first.
        let best = fits.into_iter().rev().max_by_key(|(fit, ..)| fit.texels);
        if let Some((Fit { explained, .. }, factor, text)) = best {
            return (
                factor,
                format!("{text}; this explains {explained} of the {all} form factors that differ"),
            );
        }
        if let Some(face) = self.find_normal(k) {
            return (Factor::Cosine, format!("the receiver's normal is that of face {face}"));
        }
        let text = format!("no single cosine, distance or area explains it; {all} form factors differ");
        (Factor::FormFactor, text)
    }

    /// Returns how well `changed` gives the GPU's F; none if it does not at texel `k` or at most texels that differ.
    fn fit(&self, k: u32, changed: Changed) -> Option<Fit> {
        let equals = |k: &u32| {
            let normal = self.mesh.faces[self.mesh.texels[*k as usize].face as usize].normal;
            self.equals_gpu(*k, normal, changed)
        };
        if !equals(&k) {
            return None;
        }
        let explained = self.differing.iter().filter(|k| equals(k)).count();
        let is_enough = explained as f64 >= MIN_EXPLAINED_SHARE * self.differing.len() as f64;
        is_enough.then(|| Fit {
            explained,
            texels: (0..self.mesh.texels.len() as u32).filter(equals).count(),
        })
    }

    fn equals_gpu(&self, k: u32, normal: Vec3, changed: Changed) -> bool {
        let found = mean_over_texel(self.mesh, self.patch, k, |position| changed(k, position, normal));
        !differ(self.kind, self.gpu[k as usize], found, self.sizes[k as usize])
    }

    /// Returns a face whose normal gives the GPU's F at texel `k`.
    fn find_normal(&self, k: u32) -> Option<usize> {
        let unchanged = |k, position, normal| self.parts(k, position, normal).expected;
        let mut faces = self.mesh.faces.iter();
        faces.position(|face| self.equals_gpu(k, face.normal, &unchanged))
    }

    fn parts(&self, k: u32, position: Vec3, normal: Vec3) -> FactorParts {
        let shooter = &self.mesh.patches[self.patch as usize].shooter;
        FactorParts::new(self.kind, shooter, &self.mesh.texels[k as usize], position, normal)
    }

    fn roundings(&self) -> f64 {
        form_factor_roundings(self.kind)
    }
}

/// True if two form factors differ by more than rounding; `size` is that of F without its cosines.
fn differ(kind: FormFactor, a: f32, b: f32, size: f32) -> bool {
    let equal = ulp_distance(a, b, size) <= form_factor_roundings(kind);
    !equal
}
