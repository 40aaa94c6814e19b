//! Causes of a wrong deposit, by the ratio of the GPU's change to the CPU's.

use crate::compare::parting::Factor;

/// Largest relative error of a ratio of two changes, each the difference of two sums, that still is that of a cause.
const MAX_RATIO_ERROR: f32 = 1e-3;

/// Returns the cause of a wrong ΔH = w·Φ/A of a shooter of this area; `values` are those of GPU and CPU.
pub fn explain_irradiance(values: [f32; 2], area: f32) -> (Factor, String) {
    if is_close(values[0] / values[1], area) {
        return (Factor::Area, "the shooter's flux is not divided by its area".into());
    }
    let text = format!("the irradiance grows by {} times w·Φ/A", ratio(values));
    (Factor::Accumulation, text)
}

/// Returns the cause of a wrong ΔB or Δr = ρ·ΔH; `symbol` is the name of B or r.
pub fn explain_reflection(values: [f32; 2], reflectance: f32, symbol: &str) -> (Factor, String) {
    let found = values[0] / values[1];
    if is_close(found, reflectance) {
        let text = format!("the {symbol} is multiplied by ρ = {reflectance} twice");
        (Factor::Reflectance, text)
    } else if is_close(found, 1.0 / reflectance) {
        let text = format!("the {symbol} is not multiplied by ρ = {reflectance}");
        (Factor::Reflectance, text)
    } else {
        let text = format!("the {symbol} grows by {} times ρ·ΔH", ratio(values));
        (Factor::Accumulation, text)
    }
}

fn is_close(found: f32, expected: f32) -> bool {
    (found / expected - 1.0).abs() <= MAX_RATIO_ERROR
}

/// Formats the ratio of GPU to CPU; both numbers where there is none.
pub fn ratio([gpu, cpu]: [f32; 2]) -> String {
    let ratio = gpu / cpu;
    if ratio.is_finite() {
        format!("{ratio:.4}")
    } else {
        format!("{gpu}/{cpu}")
    }
}
