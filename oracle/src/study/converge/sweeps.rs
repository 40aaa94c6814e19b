//! The table of sweeps: one parameter each, everything else at stated settings.
//!
//! A parameter that a later solver brings is one more entry of [`sweeps`], a way to set it is one
//! more [`Curve`], and one that may set a floor for others is one more entry of [`REFINEMENTS`].

use common::form_factor::FormFactor;
use common::settings::{Lookup, Raster, Settings, Visibility};

/// Changes settings.
pub type Change = fn(&mut Settings);

/// One line of a sweep's chart.
#[derive(Clone, Copy)]
pub struct Curve {
    /// In the legend.
    pub label: &'static str,
    /// What it changes of the sweep's base.
    pub change: Change,
}

/// What the points of a sweep are measured against, unless a directory is given.
#[derive(Clone, Copy)]
pub enum Truth {
    /// The sweep's base with this value, one step finer than the last point.
    Finer(f64),
    /// The sweep's base, changed: the limit that the parameter is to reach.
    Limit {
        /// In words.
        name: &'static str,
        /// To the base.
        change: Change,
    },
}

/// One parameter, from coarse to fine.
#[derive(Clone, Copy)]
pub struct Sweep {
    /// In headings.
    pub name: &'static str,
    /// On the command line.
    pub option: &'static str,
    /// Coarse to fine.
    pub values: &'static [f64],
    /// Sets the parameter.
    pub set: fn(&mut Settings, f64),
    /// Whether a larger value is finer (a count) or a smaller one.
    pub larger_is_finer: bool,
    /// To the default settings.
    pub base: Change,
    /// The truth.
    pub truth: Truth,
    /// At least one.
    pub curves: &'static [Curve],
}

impl Sweep {
    /// The settings of `curve` at `value`.
    pub fn settings(&self, curve: &Curve, value: f64) -> Settings {
        let mut settings = self.start();
        (curve.change)(&mut settings);
        (self.set)(&mut settings, value);
        settings
    }

    /// The settings of the truth.
    pub fn truth_settings(&self) -> Settings {
        let mut settings = self.start();
        match self.truth {
            Truth::Finer(value) => (self.set)(&mut settings, value),
            Truth::Limit { change, .. } => change(&mut settings),
        }
        settings
    }

    /// The step h that goes to 0 as the parameter gets finer.
    pub fn step(&self, value: f64) -> f64 {
        if self.larger_is_finer {
            1.0 / value
        } else {
            value
        }
    }

    fn start(&self) -> Settings {
        let mut settings = Settings::default();
        (self.base)(&mut settings);
        settings
    }
}

const AS_IT_IS: Change = |_| ();

/// All sweeps of the default study.
pub fn sweeps() -> Vec<Sweep> {
    vec![TEXELS, CELLS, SAMPLES, ITEM_BUFFER, EPSILON]
}

/// Texels a side; their centres are asked, and their means are wanted.
pub const TEXELS: Sweep = Sweep {
    name: "Texels",
    option: "--texels",
    values: &[4.0, 8.0, 16.0, 32.0],
    set: |settings, value| settings.texels = value as u32,
    larger_is_finer: true,
    base: |settings| settings.samples = 16,
    truth: Truth::Finer(64.0),
    curves: &[
        Curve {
            label: "rays, centre to centre",
            change: |settings| settings.samples = 1,
        },
        Curve {
            label: "rays, 16 samples",
            change: AS_IT_IS,
        },
    ],
};

/// Pairs of points by which a texel sees a cell.
pub const SAMPLES: Sweep = Sweep {
    name: "Samples",
    option: "--samples",
    values: &[1.0, 2.0, 4.0, 8.0, 16.0, 32.0],
    set: |settings, value| settings.samples = value as u32,
    larger_is_finer: true,
    base: AS_IT_IS,
    truth: Truth::Finer(128.0),
    curves: &[
        Curve {
            label: "as they come",
            change: AS_IT_IS,
        },
        Curve {
            label: "every shot closed (--conserve)",
            change: |settings| settings.conserve = true,
        },
    ],
};

/// Cells a side; each shoots from its centre, at its mean radiosity.
pub const CELLS: Sweep = Sweep {
    name: "Cells",
    option: "--cells",
    values: &[1.0, 2.0, 4.0, 8.0],
    set: |settings, value| settings.cells = value as u32,
    larger_is_finer: true,
    base: AS_IT_IS,
    truth: Truth::Finer(16.0),
    curves: &[
        Curve {
            label: "polygon",
            change: AS_IT_IS,
        },
        Curve {
            label: "disc",
            change: |settings| settings.form_factor = FormFactor::Disc,
        },
    ],
};

/// Pixels a side of the item buffer; rays are what they are to become. Whole faces shoot, so that
/// there are few shots and large projections.
pub const ITEM_BUFFER: Sweep = Sweep {
    name: "Item buffer",
    option: "--item-buffer",
    values: &[256.0, 512.0, 1024.0, 2048.0],
    set: |settings, value| settings.item_buffer = value as u32,
    larger_is_finer: true,
    base: |settings| settings.cells = 1,
    truth: Truth::Limit {
        name: "rays",
        change: |settings| settings.visibility = Visibility::Rays,
    },
    curves: &[
        item_buffer("stereographic, 3x3", |settings| {
            settings.visibility = Visibility::Stereographic;
        }),
        item_buffer("stereographic, exact", |settings| {
            settings.visibility = Visibility::Stereographic;
            settings.lookup = Lookup::Exact;
        }),
        item_buffer("stereographic, tessellated, 3x3", |settings| {
            settings.visibility = Visibility::Stereographic;
            settings.raster = Raster::Tessellated;
        }),
        item_buffer("hemicube, 3x3", |settings| {
            settings.visibility = Visibility::Hemicube;
        }),
        item_buffer("hemicube, exact", |settings| {
            settings.visibility = Visibility::Hemicube;
            settings.lookup = Lookup::Exact;
        }),
        item_buffer("hemisphere, 3x3", |settings| {
            settings.visibility = Visibility::Hemisphere;
        }),
        item_buffer("hemisphere, exact", |settings| {
            settings.visibility = Visibility::Hemisphere;
            settings.lookup = Lookup::Exact;
        }),
        item_buffer("paper, exact", |settings| {
            settings.visibility = Visibility::Paper;
            settings.lookup = Lookup::Exact;
        }),
    ],
};

const fn item_buffer(label: &'static str, change: Change) -> Curve {
    Curve { label, change }
}

/// Unshot power at which a solve stops.
pub const EPSILON: Sweep = Sweep {
    name: "Unshot power ε",
    option: "--epsilon",
    values: &[0.3, 0.1, 0.03, 0.01, 0.003, 0.001],
    set: |settings, value| settings.epsilon = value,
    larger_is_finer: false,
    base: AS_IT_IS,
    truth: Truth::Finer(0.0001),
    curves: &[Curve {
        label: "rays",
        change: AS_IT_IS,
    }],
};

/// A way to make one parameter finer; none where it is at its best or has no effect.
pub struct Refinement {
    /// The option that it changes.
    pub option: &'static str,
    /// The finer settings, and the change in words.
    pub finer: fn(&Settings) -> Option<(Settings, String)>,
}

/// What may set the floor of another parameter; the cheapest first.
pub const REFINEMENTS: &[Refinement] = &[
    Refinement {
        option: "--epsilon",
        finer: |s| {
            let mut finer = s.clone();
            finer.epsilon /= 10.0;
            let text = format!("ε {} → {}", s.epsilon, finer.epsilon);
            Some((finer, text))
        },
    },
    Refinement {
        option: "--lookup",
        finer: |s| {
            let mut finer = s.clone();
            finer.lookup = Lookup::Neighbours;
            let possible = s.visibility != Visibility::Rays && s.lookup == Lookup::Exact;
            possible.then(|| (finer, "lookup exact → 3x3".into()))
        },
    },
    Refinement {
        option: "--visibility",
        finer: |s| {
            let mut finer = s.clone();
            (finer.visibility, finer.lookup) = match s.visibility {
                Visibility::Paper => (Visibility::Hemisphere, s.lookup),
                Visibility::Hemisphere => (Visibility::Stereographic, s.lookup),
                _ => (Visibility::Rays, s.lookup),
            };
            let name = |v: Visibility| format!("{v:?}").to_lowercase();
            let text = format!("{} → {}", name(s.visibility), name(finer.visibility));
            (s.visibility != Visibility::Rays).then_some((finer, text))
        },
    },
    Refinement {
        option: "--form-factor",
        finer: |s| {
            let mut finer = s.clone();
            finer.form_factor = FormFactor::Polygon;
            let possible = s.form_factor != FormFactor::Polygon;
            possible.then(|| (finer, "form factor → polygon".into()))
        },
    },
    Refinement {
        option: "--item-buffer",
        finer: |s| {
            let mut finer = s.clone();
            finer.item_buffer *= 2;
            let possible = s.visibility != Visibility::Rays && finer.item_buffer <= 4096;
            let text = format!("item buffer {} → {}", s.item_buffer, 2 * s.item_buffer);
            possible.then_some((finer, text))
        },
    },
    Refinement {
        option: "--samples",
        finer: |s| {
            let mut finer = s.clone();
            finer.samples *= 4;
            let text = format!("samples {} → {}", s.samples, finer.samples);
            (finer.samples <= 256).then_some((finer, text))
        },
    },
    Refinement {
        option: "--cells",
        finer: |s| {
            let mut finer = s.clone();
            finer.cells *= 2;
            let possible = finer.cells <= s.texels;
            possible.then(|| (finer, format!("cells {} → {}", s.cells, 2 * s.cells)))
        },
    },
    Refinement {
        option: "--texels",
        finer: |s| {
            let mut finer = s.clone();
            finer.texels *= 2;
            Some((finer, format!("texels {} → {}", s.texels, 2 * s.texels)))
        },
    },
];
