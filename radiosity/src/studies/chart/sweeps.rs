//! Sets of methods with one truth: all methods, or one varied option, all others at stated settings.
//!
//! To add a parameter, add a [`Sweep`] and a value of `--vary`; to add a variant of it, a curve.

use super::methods::{SolveMethod, has_dense_truth, list_methods};
use common::form_factor::FormFactor;
use common::scene::Scene;
use common::settings::ItemBufferProjection::{self, Hemicube, Hemisphere, Paper, Stereographic};
use common::settings::Lookup::{self, Exact, Neighbours};
use common::settings::{ItemBufferSettings, Settings, SolveQuality, Visibility};
use oracle::solve::dense;
use oracle::solve::solver::{MIN_ERROR, SolverKind};

/// Methods with one truth.
pub struct MethodSet {
    /// The varied option, if there is one.
    pub sweep: Option<Sweep>,
    /// Method that solves the truth; its options name it.
    pub truth: SolveMethod,
    /// Methods to measure.
    pub methods: Vec<SolveMethod>,
}

impl MethodSet {
    /// Makes the set of all methods of these solvers on N×N texels. Their truth is the dense solver's, or else the
    /// CPU's to the smallest error that can be requested.
    pub fn of_solvers(scene: &Scene, solvers: &[SolverKind], quality: SolveQuality, texels: u32) -> Self {
        let settings = dense::dense_settings(texels);
        let all = solvers
            .iter()
            .flat_map(|solver| list_methods(scene, *solver, quality, texels));
        // The dense solver on the texels of its own truth would be that truth.
        let is_truth = |m: &SolveMethod| m.solver == SolverKind::Dense && m.settings.meshing.texels == texels;
        Self {
            sweep: None,
            truth: match has_dense_truth(scene, texels) {
                true => SolveMethod::new(SolverKind::Dense, "the dense solver", settings),
                false => SolveMethod::to_error(SolverKind::Cpu, MIN_ERROR, settings),
            },
            methods: all.filter(|method| !is_truth(method)).collect(),
        }
    }
}

/// A change of settings.
pub type SettingsChange = fn(&mut Settings);

/// Truth of a sweep, unless a result is given.
#[derive(Clone, Copy)]
pub enum SweepTruth {
    /// Base of the sweep with this value, one step finer than the last point.
    Finer(f64),
    /// Name of the parameter's limit, and the change of the base that sets it.
    Limit(&'static str, SettingsChange),
}

/// Sweep of one parameter.
#[derive(Clone, Copy)]
pub struct Sweep {
    /// Name in headings.
    pub name: &'static str,
    /// Command-line option.
    pub option: &'static str,
    /// Values, coarse to fine.
    pub values: &'static [f64],
    /// Sets the parameter.
    pub set: fn(&mut Settings, f64),
    /// Change to the default settings.
    pub base: SettingsChange,
    /// Truth of the points.
    pub truth: SweepTruth,
    /// Name of each curve, and its change to the base.
    pub curves: &'static [(&'static str, SettingsChange)],
}

impl Sweep {
    /// Returns the methods of all curves and their truth.
    pub fn method_set(&self, has_gpu: bool) -> MethodSet {
        let truth = match self.truth {
            SweepTruth::Finer(value) => self.method_at(NO_CHANGE, value, has_gpu),
            SweepTruth::Limit(name, change) => SolveMethod {
                options: name.into(),
                ..self.method_at(change, self.values[0], has_gpu)
            },
        };
        let curve = |(name, change): &(&'static str, SettingsChange)| {
            let (name, change) = (*name, *change);
            self.values.iter().map(move |value| SolveMethod {
                curve: Some((name, *value)),
                ..self.method_at(change, *value, has_gpu)
            })
        };
        MethodSet {
            sweep: Some(*self),
            truth,
            methods: self.curves.iter().flat_map(curve).collect(),
        }
    }

    fn method_at(&self, change: SettingsChange, value: f64, has_gpu: bool) -> SolveMethod {
        let mut settings = Settings::default();
        (self.base)(&mut settings);
        change(&mut settings);
        (self.set)(&mut settings, value);
        // Without a GPU the CPU's twin draws item buffers.
        let on_gpu = has_gpu && settings.transport.visibility.item_buffer().is_some();
        let solver = if on_gpu { SolverKind::Gpu } else { SolverKind::Cpu };
        SolveMethod::new(solver, format!("{} {value}", self.option), settings)
    }

    /// Returns the step h, which tends to 0 as the parameter gets finer.
    pub fn step_size(&self, value: f64) -> f64 {
        let is_count = self.values.first() < self.values.last();
        if is_count { 1.0 / value } else { value }
    }
}

const NO_CHANGE: SettingsChange = |_| ();

/// Texels per side. The solution is their mean; with one sample it is taken at their centre.
pub const TEXEL_SWEEP: Sweep = Sweep {
    name: "Texels",
    option: "--texels",
    values: &[4.0, 8.0, 16.0, 32.0],
    set: |settings, value| settings.meshing.texels = value as u32,
    base: |settings| settings.meshing.samples = 16,
    truth: SweepTruth::Finer(64.0),
    curves: &[
        ("rays, centre to centre", |settings| settings.meshing.samples = 1),
        ("rays, 16 samples", NO_CHANGE),
    ],
};

/// Patches per side of a face; each shoots its mean radiosity from its centre.
pub const PATCH_SWEEP: Sweep = Sweep {
    name: "Patches",
    option: "--patches",
    values: &[1.0, 2.0, 4.0, 8.0],
    set: |settings, value| settings.meshing.patches = value as u32,
    base: NO_CHANGE,
    truth: SweepTruth::Finer(16.0),
    curves: &[
        ("polygon", NO_CHANGE),
        ("disc", |settings| settings.transport.form_factor = FormFactor::Disc),
    ],
};

/// Visibility samples per link of a patch and a texel.
pub const SAMPLE_SWEEP: Sweep = Sweep {
    name: "Samples",
    option: "--samples",
    values: &[1.0, 2.0, 4.0, 8.0, 16.0, 32.0],
    set: |settings, value| settings.meshing.samples = value as u32,
    base: NO_CHANGE,
    truth: SweepTruth::Finer(128.0),
    curves: &[
        ("as they come", NO_CHANGE),
        ("every shot closed (--conserve)", |settings| {
            settings.transport.conserve = true
        }),
    ],
};

/// Pixels per side of the item buffer; its limit is visibility by rays. Whole faces shoot, for few
/// shots and large projections.
pub const ITEM_BUFFER_SWEEP: Sweep = Sweep {
    name: "Item buffer",
    option: "--item-buffer",
    values: &[256.0, 512.0, 1024.0, 2048.0],
    set: |settings, value| {
        // All curves of this sweep use an item buffer.
        if let Visibility::ItemBuffer(drawing) = &mut settings.transport.visibility {
            drawing.size = value as u32;
        }
    },
    base: |settings| settings.meshing.patches = 1,
    truth: SweepTruth::Limit("rays", |settings| settings.transport.visibility = Visibility::Rays),
    curves: &[
        ("stereographic, 3x3", |s| draw_with(s, Stereographic, Neighbours)),
        ("stereographic, exact", |s| draw_with(s, Stereographic, Exact)),
        ("hemicube, 3x3", |s| draw_with(s, Hemicube, Neighbours)),
        ("hemisphere, 3x3", |s| draw_with(s, Hemisphere, Neighbours)),
        ("paper, exact", |s| draw_with(s, Paper, Exact)),
    ],
};

/// Share of unshot power at which a solve stops.
pub const EPSILON_SWEEP: Sweep = Sweep {
    name: "Unshot power ε",
    option: "--epsilon",
    values: &[0.3, 0.1, 0.03, 0.01, 0.003, 0.001],
    set: |settings, value| settings.schedule.epsilon = value,
    base: NO_CHANGE,
    truth: SweepTruth::Finer(0.0001),
    curves: &[("rays", NO_CHANGE)],
};

/// All sweeps, in the order of the values of `--vary`.
pub const SWEEPS: [Sweep; 5] = [TEXEL_SWEEP, PATCH_SWEEP, SAMPLE_SWEEP, ITEM_BUFFER_SWEEP, EPSILON_SWEEP];

/// Sets an item buffer of the default size.
fn draw_with(settings: &mut Settings, projection: ItemBufferProjection, lookup: Lookup) {
    settings.transport.visibility = Visibility::ItemBuffer(ItemBufferSettings {
        projection,
        lookup,
        ..ItemBufferSettings::DEFAULT
    });
}
