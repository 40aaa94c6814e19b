//! The table of sweeps: one parameter each, all others at stated settings.
//!
//! To add a parameter, add a [`Sweep`] and a value of `--vary`; to add a variant of it, a [`SweepCurve`]; if it may
//! set an error floor for other parameters, an entry to [`PARAMETER_REFINEMENTS`].

use crate::studies::chart::methods::option_values;
use crate::studies::{PIXEL_HEMISPHERE, PIXEL_STEREOGRAPHIC};
use common::form_factor::FormFactor;
use common::settings::{ItemBufferProjection, ItemBufferSettings, Lookup, Raster, Settings, Visibility};

/// A change of settings.
pub type SettingsChange = fn(&mut Settings);

/// One curve of a sweep's chart.
#[derive(Clone, Copy)]
pub struct SweepCurve {
    /// In the legend.
    pub label: &'static str,
    /// Change to the sweep's base.
    pub change: SettingsChange,
}

/// Truth of a sweep, unless a directory is given.
#[derive(Clone, Copy)]
pub enum SweepTruth {
    /// Base of the sweep with this value, one step finer than the last point.
    Finer(f64),
    /// Changed base: the limit of the parameter.
    Limit {
        /// Description.
        name: &'static str,
        /// Change to the base.
        change: SettingsChange,
    },
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
    /// Curves, at least one.
    pub curves: &'static [SweepCurve],
}

impl Sweep {
    /// Returns the settings of `curve` at `value`.
    pub fn settings_at(&self, curve: &SweepCurve, value: f64) -> Settings {
        let mut settings = self.base_settings();
        (curve.change)(&mut settings);
        (self.set)(&mut settings, value);
        settings
    }

    /// Returns the settings of the truth.
    pub fn truth_settings(&self) -> Settings {
        let mut settings = self.base_settings();
        match self.truth {
            SweepTruth::Finer(value) => (self.set)(&mut settings, value),
            SweepTruth::Limit { change, .. } => change(&mut settings),
        }
        settings
    }

    /// Returns the step h, which tends to 0 as the parameter gets finer.
    pub fn step_size(&self, value: f64) -> f64 {
        let is_count = self.values.first() < self.values.last();
        if is_count { 1.0 / value } else { value }
    }

    fn base_settings(&self) -> Settings {
        let mut settings = Settings::default();
        (self.base)(&mut settings);
        settings
    }
}

const NO_CHANGE: SettingsChange = |_| ();

const fn sweep_curve(label: &'static str, change: SettingsChange) -> SweepCurve {
    SweepCurve { label, change }
}

/// Texels per side. The solution is their mean; with one sample it is taken at their centre.
pub const TEXEL_SWEEP: Sweep = Sweep {
    name: "Texels",
    option: "--texels",
    values: &[4.0, 8.0, 16.0, 32.0],
    set: |settings, value| settings.meshing.texels = value as u32,
    base: |settings| settings.meshing.samples = 16,
    truth: SweepTruth::Finer(64.0),
    curves: &[
        sweep_curve("rays, centre to centre", |settings| settings.meshing.samples = 1),
        sweep_curve("rays, 16 samples", NO_CHANGE),
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
        sweep_curve("as they come", NO_CHANGE),
        sweep_curve("every shot closed (--conserve)", |settings| {
            settings.transport.conserve = true
        }),
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
        sweep_curve("polygon", NO_CHANGE),
        sweep_curve("disc", |settings| settings.transport.form_factor = FormFactor::Disc),
    ],
};

/// Pixels per side of the item buffer; its limit is visibility by rays. Whole faces shoot, for few
/// shots and large projections.
pub const ITEM_BUFFER_SWEEP: Sweep = Sweep {
    name: "Item buffer",
    option: "--item-buffer",
    values: &[256.0, 512.0, 1024.0, 2048.0],
    // All curves of this sweep use an item buffer.
    set: |settings, value| {
        if let Visibility::ItemBuffer(drawing) = &mut settings.transport.visibility {
            drawing.size = value as u32;
        }
    },
    base: |settings| settings.meshing.patches = 1,
    truth: SweepTruth::Limit {
        name: "rays",
        change: |settings| settings.transport.visibility = Visibility::Rays,
    },
    curves: &[
        sweep_curve("stereographic, 3x3", |settings| {
            set_item_buffer(settings, PIXEL_STEREOGRAPHIC, Lookup::Neighbours);
        }),
        sweep_curve("stereographic, exact", |settings| {
            set_item_buffer(settings, PIXEL_STEREOGRAPHIC, Lookup::Exact);
        }),
        sweep_curve("stereographic, tessellated, 3x3", |settings| {
            let tessellated = ItemBufferProjection::Stereographic(Raster::Tessellated);
            set_item_buffer(settings, tessellated, Lookup::Neighbours);
        }),
        sweep_curve("hemicube, 3x3", |settings| {
            set_item_buffer(settings, ItemBufferProjection::Hemicube, Lookup::Neighbours);
        }),
        sweep_curve("hemicube, exact", |settings| {
            set_item_buffer(settings, ItemBufferProjection::Hemicube, Lookup::Exact);
        }),
        sweep_curve("hemisphere, 3x3", |settings| {
            set_item_buffer(settings, PIXEL_HEMISPHERE, Lookup::Neighbours);
        }),
        sweep_curve("hemisphere, exact", |settings| {
            set_item_buffer(settings, PIXEL_HEMISPHERE, Lookup::Exact);
        }),
        sweep_curve("paper, exact", |settings| {
            set_item_buffer(settings, ItemBufferProjection::Paper, Lookup::Exact);
        }),
    ],
};

/// Sets an item buffer of the default size.
fn set_item_buffer(settings: &mut Settings, projection: ItemBufferProjection, lookup: Lookup) {
    settings.transport.visibility = Visibility::ItemBuffer(ItemBufferSettings {
        projection,
        lookup,
        ..ItemBufferSettings::DEFAULT
    });
}

/// Share of unshot power at which a solve stops.
pub const EPSILON_SWEEP: Sweep = Sweep {
    name: "Unshot power ε",
    option: "--epsilon",
    values: &[0.3, 0.1, 0.03, 0.01, 0.003, 0.001],
    set: |settings, value| settings.schedule.epsilon = value,
    base: NO_CHANGE,
    truth: SweepTruth::Finer(0.0001),
    curves: &[sweep_curve("rays", NO_CHANGE)],
};

/// Refinement of a parameter that may lower another one's error floor.
pub struct ParameterRefinement {
    /// Option that is changed.
    pub option: &'static str,
    /// Name in the finding.
    name: &'static str,
    /// Makes the parameter finer, if that is possible and has an effect.
    change: SettingsChange,
}

impl ParameterRefinement {
    /// Returns finer settings and the change in words, or none if there are none.
    pub fn refine(&self, settings: &Settings) -> Option<(Settings, String)> {
        let mut finer = *settings;
        (self.change)(&mut finer);
        let value = |s: &Settings| {
            let all = serde_json::to_value(s).unwrap_or_default();
            option_values(&all)
                .find(|(name, _)| *name == &self.option[2..])
                .map_or(String::new(), |(_, value)| value)
        };
        let text = format!("{} {} → {}", self.name, value(settings), value(&finer));
        (finer != *settings).then_some((finer, text))
    }
}

/// Refinements, cheapest first.
pub const PARAMETER_REFINEMENTS: [ParameterRefinement; 8] = [
    ParameterRefinement {
        option: "--epsilon",
        name: "ε",
        change: |s| s.schedule.epsilon /= 10.0,
    },
    ParameterRefinement {
        option: "--lookup",
        name: "lookup",
        change: |s| change_item_buffer(s, |drawing| drawing.lookup = Lookup::Neighbours),
    },
    ParameterRefinement {
        option: "--visibility",
        name: "visibility",
        change: |s| {
            let drawing = s.transport.visibility.item_buffer();
            let finer = match drawing.map(|drawing| drawing.projection) {
                Some(ItemBufferProjection::Paper) => PIXEL_HEMISPHERE,
                Some(ItemBufferProjection::Hemisphere(raster)) => ItemBufferProjection::Stereographic(raster),
                _ => return s.transport.visibility = Visibility::Rays,
            };
            change_item_buffer(s, |drawing| drawing.projection = finer);
        },
    },
    ParameterRefinement {
        option: "--form-factor",
        name: "form factor",
        change: |s| s.transport.form_factor = FormFactor::Polygon,
    },
    ParameterRefinement {
        option: "--item-buffer",
        name: "item buffer",
        change: |s| change_item_buffer(s, |drawing| drawing.size = finer_count(drawing.size, 2, 4096)),
    },
    ParameterRefinement {
        option: "--samples",
        name: "samples",
        change: |s| s.meshing.samples = finer_count(s.meshing.samples, 4, 256),
    },
    ParameterRefinement {
        option: "--patches",
        name: "patches",
        change: |s| s.meshing.patches = finer_count(s.meshing.patches, 2, s.meshing.texels),
    },
    ParameterRefinement {
        option: "--texels",
        name: "texels",
        change: |s| s.meshing.texels *= 2,
    },
];

/// Changes the item buffer of settings that have one.
fn change_item_buffer(settings: &mut Settings, change: impl FnOnce(&mut ItemBufferSettings)) {
    if let Visibility::ItemBuffer(drawing) = &mut settings.transport.visibility {
        change(drawing);
    }
}

/// Returns `factor` times `count`, or `count` if that exceeds `limit`.
fn finer_count(count: u32, factor: u32, limit: u32) -> u32 {
    if factor * count <= limit { factor * count } else { count }
}
