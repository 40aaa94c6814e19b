//! Draws the figures of one comparison: pictures and plots with their captions.

use crate::report::document::{Figure, bold_text, colour_bar, plain_text, styled_text};
use crate::report::format::{format_number, format_percent};
use crate::report::picture::{
    Exposure, decode_srgb, draw_item_buffer, draw_radiosity_atlas, face_colour, luminance, weighted_rms,
};
use crate::report::plot::{Axis, CPU_COLOUR, GPU_COLOUR, Legend, LineStyle, Plot, PlotArea, Series, format_share};
use crate::report::preview::choose_exposure;
use crate::report::view::camera::Camera;
use crate::report::view::interpolation::InterpolationSurface;
use crate::report::view::quality::InterpolationQuality;
use crate::report::view::render::{ViewHit, ViewHits};
use crate::report::viewer::{SceneViewer, ViewerLayer};
use common::rays::Rays;
use common::settings::{Iteration, Visibility};
use common::shooting::{RadiosityField, SolveRun};
use glam::{Vec3, Vec4};
use maud::Markup;
use oracle::compare::comparison::Comparison;

/// Pixels per side of a rendered view.
const VIEW_SIDE: u32 = 560;
/// Width and height of a plot in CSS pixels; the page scales it.
const PLOT_SIZE: [u32; 2] = [720, 340];
/// Approximate maximum number of points per curve.
const MAX_CURVE_POINTS: usize = 800;
/// Differences up to this, relative to the rms of reflected radiosity, count as 32-bit rounding (6·10⁻⁸ each).
const ROUNDING_TOLERANCE: f64 = 1e-6;

/// Camera, exposure and rendered views of a comparison.
pub struct ComparisonView<'a> {
    c: &'a Comparison,
    camera: Camera,
    exposure: Exposure,
    surface: InterpolationSurface<'a>,
    hits: ViewHits,
    /// Views of the free runs as sources of `img` elements: CPU, GPU.
    views: [String; 2],
    /// RMS of the luminance of the CPU's ρH, W/m².
    rms: f64,
    quality: InterpolationQuality,
}

impl<'a> ComparisonView<'a> {
    /// Renders the free runs.
    pub fn new(c: &'a Comparison) -> Self {
        let rays = Rays::new(&c.mesh);
        let camera = Camera::automatic_view(&c.mesh, &rays);
        let surface = InterpolationSurface::new(&c.scene, &c.mesh);
        let hits = ViewHits::new(&camera, &surface, &rays, VIEW_SIDE);
        let cpu = surface.interpolate(&c.cpu.field.irradiance);
        let gpu = surface.interpolate(&c.gpu.field.irradiance);
        let exposure = choose_exposure(&hits, &cpu);
        let views = [&cpu, &gpu].map(|field| {
            let colour = |hit: &ViewHit| exposure.display_light(field.radiosity_at(&hit.stencil));
            hits.shade_hits(colour).data_uri()
        });
        let quality = InterpolationQuality::new(&cpu);
        let texels = c.mesh.texels.iter().zip(&c.cpu.field.irradiance);
        let rms = weighted_rms(texels.map(|(texel, irradiance)| {
            let reflected = texel.reflectance * irradiance.truncate();
            (f64::from(luminance(reflected)), f64::from(texel.area))
        }));
        drop((cpu, gpu));
        Self {
            c,
            camera,
            exposure,
            surface,
            hits,
            views,
            rms,
            quality,
        }
    }

    /// Renders the interactive viewer of both solutions.
    pub fn render_viewer(&self) -> Markup {
        let c = self.c;
        let layer = |name, field| ViewerLayer {
            name,
            mesh: &c.mesh,
            field,
        };
        let viewer = SceneViewer {
            scene: &c.scene,
            layers: vec![layer("CPU", &c.cpu.field), layer("GPU", &c.gpu.field)],
            difference: [1, 0],
            irradiance: true,
            reflected: false,
            texel_errors: c.error_map.as_deref(),
            camera: self.camera,
            exposure: self.exposure,
        };
        viewer.render_element()
    }

    /// Returns the GPU's view with the errors of both solutions.
    pub fn opening_figure(&self, preset: &str, errors: &[String; 2]) -> Figure {
        let says = match &self.c.truth {
            Some(_) => {
                styled_text("gpu", format!("{} off", errors[1]))
                    + " on the GPU, which this shows, and "
                    + styled_text("cpu", format!("{} off", errors[0]))
                    + " on the CPU."
            }
            None => plain_text("Its error is not known."),
        };
        let alt = format!("The scene, {}", self.c.preset.name());
        Figure::from_picture(&self.views[1], &alt, bold_text(preset) + ". " + says)
    }

    /// Returns both views, and those of the differences if the solutions differ by more than rounding.
    pub fn view_figures(&self) -> Vec<Figure> {
        let c = self.c;
        let white = format_number(f64::from(self.exposure.white));
        let gpu_visibility = match (c.error_target, c.gpu_settings.transport.visibility) {
            (Some(_), _) => "visibility by rays",
            (None, Visibility::Rays) => "visibility by rays as well",
            (None, _) => "visibility by item buffer",
        };
        let cpu_visibility = match c.error_target {
            Some(_) => "visibility by shafts and rays",
            None => "visibility by rays",
        };
        let runs = [("CPU", "cpu", cpu_visibility), ("GPU", "gpu", gpu_visibility)];
        let views = runs.into_iter().zip(&self.views).map(|((name, class, how), source)| {
            let alt = format!("The scene as the {name} solved it");
            let says = format!(" · radiosity, {how}. White is {white} W/m²; emitters clip.");
            Figure::from_picture(source, &alt, styled_text(class, name) + says)
        });
        let differences = match self.is_alike() {
            true => Vec::new(),
            false => self.difference_figures(),
        };
        views.chain(differences).collect()
    }

    /// Returns whether the solutions are equal up to rounding; NaN does not count as alike.
    pub fn is_alike(&self) -> bool {
        let both = [&self.c.free_difference, &self.c.lockstep_difference];
        both.iter()
            .all(|difference| difference.max_relative <= ROUNDING_TOLERANCE)
    }

    /// Draws the signed differences of reflected luminance at one range.
    fn difference_figures(&self) -> Vec<Figure> {
        let c = self.c;
        // Lockstep is the CPU's log on the GPU, or the GPU's decisions on the CPU.
        let runs = match c.error_target {
            Some(_) => [
                ("free", "independent solves", &c.gpu, &c.cpu),
                ("lockstep", "the CPU decides by rays too", &c.gpu, &c.lockstep),
            ],
            None => [
                ("free", "each with its own choice of shooters", &c.gpu, &c.cpu),
                ("lockstep", "the same shooters", &c.lockstep, &c.cpu),
            ],
        };
        let fields = runs.map(|(_, _, run, from)| {
            let difference = subtract_irradiance(run, &from.field);
            self.surface.interpolate(&difference)
        });
        let at = |k: usize, hit: &ViewHit| {
            let reflectance = c.mesh.texels[hit.stencil.texel as usize].reflectance;
            let difference = reflectance * fields[k].stencil_value(&hit.stencil).as_vec3();
            let size = f64::from(luminance(difference));
            if size == 0.0 { 0.0 } else { size / self.rms }
        };
        let range = [0, 1].map(|k| self.hits.false_colour_range(|hit| at(k, hit)));
        let range = range[0].max(range[1]);
        let figure = |(k, (name, how, ..)): (usize, (&str, &str, &SolveRun, &SolveRun))| {
            let picture = self.hits.draw_false_colours(range, |hit| at(k, hit));
            let says = format!(
                " · {how}. Luminance of reflected radiosity, relative to its rms on the CPU ({} W/m²); clipped beyond \
                 the range.",
                format_number(self.rms)
            );
            let caption = bold_text(format!("GPU − CPU, {name}")) + says + colour_bar(range);
            let alt = format!("Difference of the {name} runs in false colours");
            Figure::from_picture(&picture.data_uri(), &alt, caption)
        };
        runs.into_iter().enumerate().map(figure).collect()
    }

    /// Describes camera, exposure and interpolation of the views.
    pub fn describe_views(&self) -> String {
        let eye = self
            .camera
            .eye
            .to_array()
            .map(|x| format_number(f64::from(x)))
            .join(", ");
        format!(
            "All from one automatic camera (at {eye} in the mesh's unit; back faces are transparent). Both views share \
             one exposure: the 90th percentile of the CPU's reflected radiosity is at 80 % of white. Magenta stands \
             for “not a number”. Irradiance is interpolated between texels: the mean over a texel deviates by {} RMS \
             (shadow edges are blurred over a texel), and the largest step between coplanar faces is {} of the rms \
             irradiance.",
            format_percent(self.quality.relative_rms),
            format_percent(self.quality.max_step),
        )
    }

    /// Returns the error estimate per texel; none without one.
    pub fn error_figure(&self) -> Option<Figure> {
        let errors = self.c.error_map.as_ref()?;
        let at = |hit: &ViewHit| match errors.get(hit.stencil.texel as usize) {
            Some(error) if self.rms > 0.0 => f64::from(*error) / self.rms,
            _ => 0.0,
        };
        let range = self.hits.false_colour_range(at);
        let picture = self.hits.draw_false_colours(range, at);
        let caption = bold_text("Error estimate")
            + " · of each texel of the CPU's solution, relative to the rms of reflected luminance; clipped beyond the range."
            + colour_bar(range);
        Some(Figure::from_picture(
            &picture.data_uri(),
            "Error estimate per texel",
            caption,
        ))
    }

    /// Returns the item buffer of one shot and the scene in its colours; none without shots.
    pub fn item_buffer_figures(&self) -> Option<[Figure; 2]> {
        let c = self.c;
        let shot = c.item_buffer.as_ref()?;
        let shooter = c.mesh.patches.get(shot.patch as usize).map_or(0, |patch| patch.face);
        let name = c.scene.faces.get(shooter as usize).map_or("", |face| &face.name);
        let projection = match c.gpu_settings.transport.visibility {
            Visibility::Rays => "stereographic (for illustration: the GPU used rays)",
            drawn => drawn.name(),
        };
        let (patch, size) = (shot.patch, shot.size);
        let says = format!(
            " · view of face {shooter} “{name}” (patch {patch}), {size}×{size} pixels, projection {projection}. One \
             colour per face, black: nothing."
        );
        let colour = |hit: &ViewHit| match hit.face == shooter {
            true => Vec3::ONE,
            false => decode_srgb(face_colour(hit.face)),
        };
        Some([
            Figure::from_picture(
                &draw_item_buffer(&shot.ids, size).data_uri(),
                "Item buffer in false colours",
                bold_text("Item buffer") + says,
            ),
            Figure::from_picture(
                &self.hits.shade_hits(colour).data_uri(),
                "The scene in the item buffer's colours",
                bold_text("The same colours in the scene") + " · the front of the shooter is white.",
            ),
        ])
    }

    /// Returns the radiosity of all texels of both runs.
    pub fn atlas_figures(&self) -> [Figure; 2] {
        let runs = [("CPU", "cpu", &self.c.cpu), ("GPU", "gpu", &self.c.gpu)];
        runs.map(|(name, class, run)| {
            let atlas = draw_radiosity_atlas(&self.c.mesh, &run.field.radiosity, self.exposure);
            let says = " · radiosity of every texel, all faces side by side in file order, exposed as above.";
            let alt = format!("Atlas of all faces, {name}");
            Figure::from_texels(&atlas.data_uri(), &alt, styled_text(class, name) + says)
        })
    }
}

/// Returns the difference of two irradiance fields.
fn subtract_irradiance(run: &SolveRun, from: &RadiosityField) -> Vec<Vec4> {
    let pairs = run.field.irradiance.iter().zip(&from.irradiance);
    pairs.map(|(a, b)| a - b).collect()
}

/// Plots unshot power over emitted power after each shot of both free runs, and the stopping threshold.
pub fn convergence_figure(c: &Comparison) -> Figure {
    // Only patches that shoot one at a time leave a log to draw.
    let shoots_singly = c.settings.schedule.iteration == Iteration::Southwell;
    let none = if c.cpu.shots.is_empty() || shoots_singly {
        "Nothing was shot.".to_owned()
    } else {
        format!(
            "Many patches shot at once: {} passes on the CPU, {} on the GPU.",
            c.cpu.passes, c.gpu.passes
        )
    };
    let plot = shoots_singly.then(|| convergence_plot(c)).flatten();
    let caption = bold_text("Unshot power")
        + " after each shot, as a share of the emitted power, free runs; the dotted line is the stopping threshold.";
    Figure::from_plot(plot.as_ref(), &none, caption)
}

fn convergence_plot(c: &Comparison) -> Option<Plot> {
    let curves = [unshot_curve(&c.cpu), unshot_curve(&c.gpu)];
    let points = || curves.iter().flatten();
    let shots = points().map(|p| p[0]).fold(0.0, f64::max);
    if shots < 1.0 {
        return None;
    }
    let stop = Some(c.settings.schedule.epsilon).filter(|e| *e > 0.0 && *e < 1.0);
    let low = points().map(|p| p[1]).chain(stop).fold(0.5, f64::min).max(1e-12);
    let high = points().map(|p| p[1]).fold(1.0, f64::max).min(1e12);
    let title = "unshot ÷ emitted power (log)";
    let named = |name: &str, series: Series| Series {
        name: name.into(),
        ..series
    };
    let style = |width, opacity, dashes| LineStyle { width, opacity, dashes };
    let [cpu, gpu] = curves.clone();
    // A thin dashed line over a thick one: both are visible where they agree.
    let mut series = vec![
        named(
            "CPU, rays",
            Series::through_points(CPU_COLOUR, style(5.0, 0.85, None), cpu),
        ),
        named(
            "GPU, item buffer",
            Series::through_points(GPU_COLOUR, style(2.0, 1.0, Some("9 6")), gpu),
        ),
    ];
    series.extend(stop.map(|stop| {
        let ends = [[0.0, stop], [shots, stop]];
        let line = Series::through_points("currentColor", style(1.0, 0.6, Some("2 4")), ends);
        named(&format!("stop: ε = {}", format_share(stop)), line)
    }));
    Some(Plot {
        size: PLOT_SIZE,
        axes: [
            Axis::linear_scale("shots", [0.0, shots], |x| format!("{x:.0}")),
            Axis::logarithmic_scale(title, [low * 0.7, high * 1.2], format_share),
        ],
        areas: Vec::new(),
        series,
        notes: Vec::new(),
        legend: Legend::Inside,
    })
}

/// Returns (shots, unshot fraction), without values that have no logarithm.
fn unshot_curve(run: &SolveRun) -> Vec<[f64; 2]> {
    let emitted = f64::from(run.emitted);
    let unshot = run.shots.iter().map(|shot| f64::from(shot.unshot) / emitted);
    let shares = std::iter::once(1.0).chain(unshot).enumerate();
    let all: Vec<[f64; 2]> = shares
        .map(|(k, y)| [k as f64, y])
        .filter(|[_, y]| y.is_finite() && *y > 0.0)
        .collect();
    let step = all.len().div_ceil(MAX_CURVE_POINTS).max(1);
    let last = all.last().copied();
    let mut thinned: Vec<[f64; 2]> = all.iter().copied().step_by(step).collect();
    thinned.extend(last.filter(|last| thinned.last() != Some(last)));
    thinned
}

/// Plots the number of mismatched pairs against the distance from an ID boundary: bin k is [k/2, (k+1)/2) pixels.
pub fn mismatch_figure(histogram: &[u64]) -> Figure {
    let used = histogram
        .iter()
        .rposition(|count| *count > 0)
        .map_or(0, |last| last + 1);
    let most = histogram.iter().copied().max().unwrap_or(0);
    let bins = histogram[..used].iter().enumerate().filter(|(_, count)| **count > 0);
    let area = |(k, count): (usize, &u64)| PlotArea {
        x: [k as f64 / 2.0 + 0.01, (k + 1) as f64 / 2.0 - 0.01],
        y: [0.0, *count as f64],
        colour: GPU_COLOUR,
        opacity: 0.75,
    };
    let title = "distance to the nearest ID boundary, pixels";
    let plot = Plot {
        size: PLOT_SIZE,
        axes: [
            Axis::linear_scale(title, [0.0, used.max(6) as f64 / 2.0], |x| format!("{x:.1}")),
            // Logarithmic, so that one distant pair shows beside thousands of near ones; the axis begins at ½.
            Axis::logarithmic_scale("mismatched pairs (log)", [0.5, most as f64 * 2.0], |y| {
                format!("{y:.0}")
            }),
        ],
        areas: bins.map(area).collect(),
        series: Vec::new(),
        notes: Vec::new(),
        legend: Legend::None,
    };
    let caption = bold_text("Mismatches by distance")
        + " · pairs on which item buffer and rays disagree, against the distance of the texel's projection to the \
           nearest boundary between two faces, in item buffer pixels.";
    Figure::from_plot(Some(&plot), "No mismatch at all.", caption)
}
