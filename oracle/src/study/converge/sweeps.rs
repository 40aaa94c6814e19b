//! The table of sweeps: one parameter each, everything else at stated settings.
//!
//! A parameter that a later solver brings is one more entry of [`sweeps`], a way to set it is one
//! more [`Curve`], and one that may set a floor for others is one more entry of [`REFINEMENTS`].

use common::form_factor::FormFactor;
use common::settings::{Drawing, Lookup, Projection, Raster, Settings, Visibility};

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
    set: |settings, value| settings.meshing.texels = value as u32,
    larger_is_finer: true,
    base: |settings| settings.meshing.samples = 16,
    truth: Truth::Finer(64.0),
    curves: &[
        Curve {
            label: "rays, centre to centre",
            change: |settings| settings.meshing.samples = 1,
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
    set: |settings, value| settings.meshing.samples = value as u32,
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
            change: |settings| settings.transport.conserve = true,
        },
    ],
};

/// Cells a side; each shoots from its centre, at its mean radiosity.
pub const CELLS: Sweep = Sweep {
    name: "Cells",
    option: "--cells",
    values: &[1.0, 2.0, 4.0, 8.0],
    set: |settings, value| settings.meshing.cells = value as u32,
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
            change: |settings| settings.transport.form_factor = FormFactor::Disc,
        },
    ],
};

/// Pixels a side of the item buffer; rays are what they are to become. Whole faces shoot, so that
/// there are few shots and large projections.
pub const ITEM_BUFFER: Sweep = Sweep {
    name: "Item buffer",
    option: "--item-buffer",
    values: &[256.0, 512.0, 1024.0, 2048.0],
    set: |settings, value| {
        // Each of the curves draws.
        if let Visibility::Drawn(drawing) = &mut settings.transport.visibility {
            drawing.size = value as u32;
        }
    },
    larger_is_finer: true,
    base: |settings| settings.meshing.cells = 1,
    truth: Truth::Limit {
        name: "rays",
        change: |settings| settings.transport.visibility = Visibility::Rays,
    },
    curves: &[
        item_buffer("stereographic, 3x3", |settings| {
            drawn(settings, STEREOGRAPHIC, Lookup::Neighbours);
        }),
        item_buffer("stereographic, exact", |settings| {
            drawn(settings, STEREOGRAPHIC, Lookup::Exact);
        }),
        item_buffer("stereographic, tessellated, 3x3", |settings| {
            let tessellated = Projection::Stereographic(Raster::Tessellated);
            drawn(settings, tessellated, Lookup::Neighbours);
        }),
        item_buffer("hemicube, 3x3", |settings| {
            drawn(settings, Projection::Hemicube, Lookup::Neighbours);
        }),
        item_buffer("hemicube, exact", |settings| {
            drawn(settings, Projection::Hemicube, Lookup::Exact);
        }),
        item_buffer("hemisphere, 3x3", |settings| {
            drawn(settings, HEMISPHERE, Lookup::Neighbours);
        }),
        item_buffer("hemisphere, exact", |settings| {
            drawn(settings, HEMISPHERE, Lookup::Exact);
        }),
        item_buffer("paper, exact", |settings| {
            drawn(settings, Projection::Paper, Lookup::Exact);
        }),
    ],
};

const STEREOGRAPHIC: Projection = Projection::Stereographic(Raster::Pixel);
const HEMISPHERE: Projection = Projection::Hemisphere(Raster::Pixel);

const fn item_buffer(label: &'static str, change: Change) -> Curve {
    Curve { label, change }
}

/// An item buffer; its pixels are what is swept.
fn drawn(settings: &mut Settings, projection: Projection, lookup: Lookup) {
    settings.transport.visibility = Visibility::Drawn(Drawing {
        projection,
        lookup,
        ..Drawing::DEFAULT
    });
}

/// Unshot power at which a solve stops.
pub const EPSILON: Sweep = Sweep {
    name: "Unshot power ε",
    option: "--epsilon",
    values: &[0.3, 0.1, 0.03, 0.01, 0.003, 0.001],
    set: |settings, value| settings.schedule.epsilon = value,
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
            let mut finer = *s;
            finer.schedule.epsilon /= 10.0;
            let text = format!("ε {} → {}", s.schedule.epsilon, finer.schedule.epsilon);
            Some((finer, text))
        },
    },
    Refinement {
        option: "--lookup",
        finer: |s| {
            let mut drawing = s.transport.visibility.drawing()?;
            let possible = drawing.lookup == Lookup::Exact;
            drawing.lookup = Lookup::Neighbours;
            possible.then(|| {
                (
                    s.by(Visibility::Drawn(drawing)),
                    "lookup exact → 3x3".into(),
                )
            })
        },
    },
    Refinement {
        option: "--visibility",
        finer: |s| {
            let drawing = s.transport.visibility.drawing()?;
            let drawn = |projection| {
                Visibility::Drawn(Drawing {
                    projection,
                    ..drawing
                })
            };
            let finer = match drawing.projection {
                Projection::Paper => drawn(HEMISPHERE),
                Projection::Hemisphere(raster) => drawn(Projection::Stereographic(raster)),
                Projection::Stereographic(_) | Projection::Hemicube => Visibility::Rays,
            };
            let text = format!("{} → {}", drawing.projection.name(), finer.name());
            Some((s.by(finer), text))
        },
    },
    Refinement {
        option: "--form-factor",
        finer: |s| {
            let mut finer = *s;
            finer.transport.form_factor = FormFactor::Polygon;
            let possible = s.transport.form_factor != FormFactor::Polygon;
            possible.then(|| (finer, "form factor → polygon".into()))
        },
    },
    Refinement {
        option: "--item-buffer",
        finer: |s| {
            let mut drawing = s.transport.visibility.drawing()?;
            let text = format!("item buffer {} → {}", drawing.size, 2 * drawing.size);
            drawing.size *= 2;
            let possible = drawing.size <= 4096;
            possible.then(|| (s.by(Visibility::Drawn(drawing)), text))
        },
    },
    Refinement {
        option: "--samples",
        finer: |s| {
            let mut finer = *s;
            finer.meshing.samples *= 4;
            let text = format!("samples {} → {}", s.meshing.samples, finer.meshing.samples);
            (finer.meshing.samples <= 256).then_some((finer, text))
        },
    },
    Refinement {
        option: "--cells",
        finer: |s| {
            let mut finer = *s;
            finer.meshing.cells *= 2;
            let possible = finer.meshing.cells <= s.meshing.texels;
            possible.then(|| {
                (
                    finer,
                    format!("cells {} → {}", s.meshing.cells, 2 * s.meshing.cells),
                )
            })
        },
    },
    Refinement {
        option: "--texels",
        finer: |s| {
            let mut finer = *s;
            finer.meshing.texels *= 2;
            Some((
                finer,
                format!("texels {} → {}", s.meshing.texels, 2 * s.meshing.texels),
            ))
        },
    },
];
