//! The first divergence of two solvers, as data: the shot or the stage of links, the face, the texel and the factor, with
//! both sides' numbers, and the share of each stage in the difference of radiosity.

use serde::Serialize;
use std::fmt;

/// Factor of a shot in which two solvers part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Factor {
    /// Choice of the shooter.
    Choice,
    /// Unshot power of a patch, from equal residuals.
    Power,
    /// Frame of the shooter: the point and the normal from which it sees the scene.
    Frame,
    /// Visible part of the shooter.
    Visibility,
    /// A cosine of the form factor.
    Cosine,
    /// The distance in the form factor.
    Distance,
    /// An area.
    Area,
    /// The form factor, by another cause.
    FormFactor,
    /// Weights of the visibility samples.
    SampleWeight,
    /// Link of equal form factor, weights and visibility.
    Link,
    /// Sum of the form factors, and the scale from it.
    Closure,
    /// Share of the shooter's hemisphere that meets no front.
    Escape,
    /// Reflectance.
    Reflectance,
    /// Addition to irradiance, radiosity or residual.
    Accumulation,
    /// Another stage, which its check names.
    Stage,
}

impl Factor {
    /// All of them; where several come from one stage, the first is that of the whole stage.
    const ALL: [Self; 15] = [
        Self::Choice,
        Self::Power,
        Self::Frame,
        Self::Visibility,
        Self::FormFactor,
        Self::Cosine,
        Self::Distance,
        Self::Area,
        Self::Link,
        Self::SampleWeight,
        Self::Closure,
        Self::Escape,
        Self::Accumulation,
        Self::Reflectance,
        Self::Stage,
    ];

    /// Returns the names in the verdict of the stages that compute the factor.
    pub fn stages(self) -> &'static [&'static str] {
        match self {
            Self::Choice => &["select"],
            Self::Power => &["select: unshot", "power"],
            Self::Frame => &["aim"],
            Self::Visibility => &[
                "item buffer",
                "item buffer, all silhouettes",
                "lookup",
                "lookup, all mismatches",
                "rays",
            ],
            Self::FormFactor | Self::Cosine | Self::Distance => &["form factor", "link_factors"],
            Self::Area => &["form factor", "select"],
            Self::Link => &["link"],
            Self::SampleWeight => &["link", "form factor"],
            Self::Closure => &["received", "closure"],
            Self::Escape => &["escape"],
            Self::Accumulation | Self::Reflectance => &["deposit", "exchange", "collect"],
            Self::Stage => &[],
        }
    }

    /// Returns the factor that a stage of the verdict computes.
    pub fn of_stage(name: &str) -> Self {
        let computes = |factor: &Self| factor.stages().contains(&name);
        Self::ALL.into_iter().find(computes).unwrap_or(Self::Stage)
    }

    /// Returns the factor's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Choice => "choice of the shooter",
            Self::Power => "unshot power",
            Self::Frame => "frame of the shooter",
            Self::Visibility => "visibility",
            Self::Cosine => "cosine",
            Self::Distance => "distance",
            Self::Area => "area",
            Self::FormFactor => "form factor",
            Self::SampleWeight => "weights of the samples",
            Self::Link => "link",
            Self::Closure => "sum of form factors",
            Self::Escape => "escaped share",
            Self::Reflectance => "reflectance ρ",
            Self::Accumulation => "accumulation",
            Self::Stage => "stage",
        }
    }
}

/// A quantity of the chain from the shooter to the texel, on both sides.
#[derive(Clone, Debug, Serialize)]
pub struct ChainStep {
    /// The quantity.
    pub quantity: String,
    /// Its unit; empty for numbers without one.
    pub unit: &'static str,
    /// The GPU's value.
    pub gpu: f64,
    /// The CPU's value, from the GPU's values of the steps before.
    pub cpu: f64,
    /// True if they differ by more than rounding.
    pub differs: bool,
}

impl fmt::Display for ChainStep {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [gpu, cpu] = [self.gpu, self.cpu].map(short_number);
        let unit = match self.unit {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        write!(f, "{}: {gpu}{unit} on the GPU, {cpu}{unit} on the CPU", self.quantity)
    }
}

/// Place and cause of a difference between two solvers.
#[derive(Clone, Debug, Serialize)]
pub struct Parting {
    /// Number of the shot, from 1 on; none for links.
    pub shot: Option<u32>,
    /// Patch that shoots, and its face.
    pub shooter: Option<Element>,
    /// Texel that receives, and its face; none if the difference is one of the whole shot.
    pub texel: Option<Element>,
    /// Factor in which the solvers part.
    pub factor: Factor,
    /// Name in the verdict of the stage whose check fails, if that is what parts the solvers.
    pub stage: Option<String>,
    /// What explains the difference.
    pub cause: String,
    /// Both sides' numbers, from the shooter to the texel.
    pub steps: Vec<ChainStep>,
}

/// A patch or a texel, and its face.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Element {
    /// Number of the patch or texel.
    pub number: u32,
    /// Number of its face, from 0 on.
    pub face: u32,
    /// Name of the face; may be empty.
    pub name: String,
}

impl fmt::Display for Element {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} of face {}", self.number, self.face)?;
        match self.name.as_str() {
            "" => Ok(()),
            name => write!(f, " ({name})"),
        }
    }
}

impl fmt::Display for Parting {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if let Some(shot) = self.shot {
            write!(f, "shot {shot}")?;
        }
        if let Some(shooter) = &self.shooter {
            write!(f, " by patch {shooter}")?;
        }
        if let Some(texel) = &self.texel {
            write!(f, ", texel {texel}")?;
        }
        if self.shot.is_some() {
            write!(f, ": ")?;
        }
        write!(f, "{}: {}", self.factor.name(), self.cause)
    }
}

/// Share of a stage in the difference between GPU and CPU after some shots: with this stage of the GPU and all others of
/// the CPU.
#[derive(Clone, Debug, Serialize)]
pub struct StageShare {
    /// The stage.
    pub stage: &'static str,
    /// Relative RMS of the difference in reflected radiosity, weighted by area.
    pub relative_rms: f64,
}

/// Shares of all stages; they need not add up, since errors may cancel.
#[derive(Clone, Debug, Serialize)]
pub struct StageShares {
    /// Number of shots, those that the CPU chooses.
    pub shots: u32,
    /// Relative RMS of the whole difference.
    pub relative_rms: f64,
    /// Each stage's.
    pub stages: Vec<StageShare>,
}

/// Largest difference between two fields within its bound.
#[derive(Clone, Debug, Serialize)]
pub struct LargestDifference {
    /// The value, of texel and shot.
    pub value: String,
    /// Difference, W/m².
    pub difference: f64,
    /// Largest difference that rounding, and silhouettes of item buffers, can make, W/m².
    pub bound: f64,
}

/// Result of the search for the first divergence.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FirstDivergence {
    /// Number of shots that were followed; 0 for links.
    pub followed_shots: u32,
    /// The first difference beyond rounding and silhouettes, if there is one.
    pub parting: Option<Parting>,
    /// The first difference that only silhouettes of item buffers explain.
    pub silhouette: Option<Parting>,
    /// The largest difference that was found before, by the share of its bound.
    pub largest: Option<LargestDifference>,
    /// Share of each stage in the difference of radiosity.
    pub shares: Option<StageShares>,
    /// Why the search ended early: a result that the host refuses.
    pub refusal: Option<String>,
}

impl FirstDivergence {
    /// Returns where the solvers part, in a sentence.
    pub fn headline(&self) -> String {
        match (&self.parting, self.followed_shots) {
            (Some(parting), _) => format!("first divergence: {parting}"),
            (None, 0) => "no check of a stage parts the solvers".into(),
            (None, 1) => "the first shot does not part the solvers beyond its bound".into(),
            (None, shots) => format!("none of the first {shots} shots parts the solvers beyond its bound"),
        }
    }

    /// Returns sentences about differences within their bounds, the shares of the stages, and an early end.
    pub fn remarks(&self) -> Vec<String> {
        let largest = self.largest.iter().map(|largest| {
            format!(
                "largest difference within its bound: {}, {} of at most {} W/m²",
                largest.value,
                short_number(largest.difference),
                short_number(largest.bound)
            )
        });
        let silhouette = self.silhouette.iter();
        let silhouette = silhouette.map(|at| format!("explained by a silhouette in the item buffer: {at}"));
        let shares = self.shares.iter().map(StageShares::describe);
        let refusal = self
            .refusal
            .iter()
            .map(|text| format!("the search ended early: {text}"));
        largest.chain(silhouette).chain(shares).chain(refusal).collect()
    }

    /// Returns the headline, both sides' numbers and the remarks, a line each.
    pub fn sentences(&self) -> Vec<String> {
        let steps = self
            .parting
            .iter()
            .flat_map(|parting| &parting.steps)
            .map(describe_step);
        let lines = std::iter::once(self.headline()).chain(steps);
        lines.chain(self.remarks()).collect()
    }
}

fn describe_step(step: &ChainStep) -> String {
    format!("  {step}{}", if step.differs { " — they differ" } else { "" })
}

impl StageShares {
    fn describe(&self) -> String {
        let percent = |x: f64| {
            if x.is_finite() {
                format!("{} %", short_number(100.0 * x))
            } else {
                "not finite".to_owned()
            }
        };
        let stages = self
            .stages
            .iter()
            .map(|share| format!("{} {}", share.stage, percent(share.relative_rms)));
        format!(
            "after {} shots the radiosity differs by {} (RMS by area, of the CPU's); with one stage of the GPU and the others of the CPU: {}",
            self.shots,
            percent(self.relative_rms),
            stages.collect::<Vec<_>>().join(", ")
        )
    }
}

/// Formats a number with four significant digits.
fn short_number(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 || !x.is_finite() {
        format!("{x}")
    } else if (1e-3..1e5).contains(&size) {
        let digits = (3 - size.log10().floor() as i32).max(0) as usize;
        format!("{x:.digits$}")
    } else {
        format!("{x:.3e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_name_shot_texel_factor_and_both_numbers() {
        let element = |number, face, name: &str| Element {
            number,
            face,
            name: name.into(),
        };
        let parting = Parting {
            shot: Some(3),
            shooter: Some(element(1, 1, "lamp")),
            texel: Some(element(37, 2, "")),
            factor: Factor::Cosine,
            stage: None,
            cause: "the cosine at the receiver is missing".into(),
            steps: vec![ChainStep {
                quantity: "irradiance ΔH.r".into(),
                unit: "W/m²",
                gpu: 0.535_009,
                cpu: 0.0,
                differs: true,
            }],
        };
        let found = FirstDivergence {
            followed_shots: 3,
            parting: Some(parting),
            ..FirstDivergence::default()
        };
        assert_eq!(
            found.sentences(),
            [
                "first divergence: shot 3 by patch 1 of face 1 (lamp), texel 37 of face 2: cosine: the cosine at the receiver is missing",
                "  irradiance ΔH.r: 0.5350 W/m² on the GPU, 0 W/m² on the CPU — they differ",
            ]
        );
    }
}
