//! Faults to plant in shaders, and the comparison that has to notice them.

use common::Result;
use common::form_factor::FormFactor;
use common::scene::Scene;
use common::settings::{Meshing, Schedule, Settings, Transport, Visibility};
use gpu::{Gpu, ShaderFault};
use oracle::compare::comparison::Comparison;
use oracle::compare::{ComparisonRequest, compare_shooting};
use oracle::solve::progress::without_progress;

/// Makes a fault: in shader file `file`, `to` replaces `from`.
pub const fn shader_fault(file: &'static str, from: &'static str, to: &'static str) -> ShaderFault {
    ShaderFault { file, from, to }
}

/// A fault with a name for messages.
#[derive(Clone, Copy, Debug)]
pub struct NamedFault {
    /// Name.
    pub name: &'static str,
    /// Fault.
    pub fault: ShaderFault,
}

const fn named_fault(name: &'static str, file: &'static str, from: &'static str, to: &'static str) -> NamedFault {
    NamedFault {
        name,
        fault: shader_fault(file, from, to),
    }
}

const DISC_FACTOR: &str = "return disc_factor(cos_i, cos_j, r2, shots[slot].area, shots[slot].area);";

/// Faults in the disc form factor and in the shooter's orientation.
pub const FORM_FACTOR_FAULTS: [NamedFault; 3] = [
    named_fault(
        "a dropped cosine",
        "form_factor",
        DISC_FACTOR,
        "return disc_factor(cos_i, 1.0, r2, shots[slot].area, shots[slot].area);",
    ),
    named_fault(
        "swapped areas",
        "form_factor",
        DISC_FACTOR,
        "return disc_factor(cos_i, cos_j, r2, texel_area, texel_area);",
    ),
    named_fault(
        "a flipped normal",
        "view",
        "shots[slot].normal = faces[face].plane.xyz;",
        "shots[slot].normal = -faces[face].plane.xyz;",
    ),
];

/// Faults in the deposit of received power.
pub const DEPOSIT_FAULTS: [NamedFault; 4] = [
    named_fault(
        "a dropped reflectance",
        "deposit",
        "texels[k].reflectance * received;",
        "received;",
    ),
    named_fault("a kept residual", "deposit", "residual[k] = vec4f(0.0);", ""),
    named_fault(
        "a radiosity of zero",
        "deposit",
        "radiosity[k] += vec4f(reflected, 0.0);",
        "radiosity[k] = vec4f(0.0);",
    ),
    named_fault(
        "NaN",
        "deposit",
        "shot.radiosity * f;",
        "shot.radiosity * (f / (f - f));",
    ),
];

/// Faults in drawing and reading the item buffer.
pub const ITEM_BUFFER_FAULTS: [NamedFault; 2] = [
    named_fault(
        "a lookup one pixel off",
        "lookup",
        "clamp(i32(floor(p.x)), 0, last)",
        "clamp(i32(floor(p.x)) + 1, 0, last)",
    ),
    named_fault(
        "a raster one pixel off",
        "item_buffer",
        "pixel_centre(pixel.x, ",
        "pixel_centre(pixel.x + 1u, ",
    ),
];

/// Returns settings like the paper's: whole faces, disc form factor, single shots.
pub fn paper_settings(visibility: Visibility, texels: u32, epsilon: f64, max_shots: u32) -> Settings {
    Settings {
        meshing: Meshing {
            texels,
            patches: 1,
            ..Meshing::default()
        },
        transport: Transport {
            visibility,
            form_factor: FormFactor::Disc,
            ..Transport::default()
        },
        schedule: Schedule {
            epsilon,
            // A fault that keeps the residual would never converge.
            max_shots,
            ..Schedule::default()
        },
        ..Settings::default()
    }
}

/// Compares the solvers on `scene` with `faults` planted in the shaders.
///
/// Errors: the host refuses a result of the faulty shaders.
pub fn compare_with_faults(scene: &Scene, settings: Settings, gpu: &Gpu, faults: &[ShaderFault]) -> Result<Comparison> {
    let request = ComparisonRequest { settings, gpu, faults };
    compare_shooting(scene, &request, &without_progress())
}

/// Returns name, value and bound of each criterion that fails.
pub fn failing_criteria(comparison: &Comparison) -> Vec<String> {
    let failing = comparison.criteria.iter().filter(|criterion| !criterion.pass);
    failing
        .map(|c| format!("{}: {:.3e} > {:.3e}", c.name, c.value, c.bound))
        .collect()
}

/// Asserts that `is_noticed` holds for each fault.
pub fn assert_faults_noticed(
    faults: impl IntoIterator<Item = ShaderFault>,
    mut is_noticed: impl FnMut(ShaderFault) -> bool,
) {
    let unnoticed: Vec<ShaderFault> = faults.into_iter().filter(|fault| !is_noticed(*fault)).collect();
    assert!(unnoticed.is_empty(), "not noticed: {unnoticed:#?}");
}
