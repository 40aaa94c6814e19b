//! The steps of a shot (Tables 1 and 2 of the paper, corrected), and the files and functions that do them on CPU and GPU.

use common::settings::{Transport, Visibility};
use oracle::trace::TracedRelight;

/// One line of the algorithm.
pub struct AlgorithmStep {
    /// The line.
    pub text: &'static str,
    /// True within the loop over the texels.
    pub is_inner: bool,
    /// Quantity that shows the line's effect, by its name in the script.
    pub quantity: Option<&'static str>,
    /// Rust function that does it, and its file.
    pub rust: Option<CodePlace>,
    /// WGSL function that does it, and its file.
    pub wgsl: Option<CodePlace>,
}

/// A function and the file that has it.
#[derive(Clone, Copy, Debug)]
pub struct CodePlace {
    /// Path in the repository.
    pub file: &'static str,
    /// Name of the function.
    pub function: &'static str,
}

const fn place(file: &'static str, function: &'static str) -> Option<CodePlace> {
    Some(CodePlace { file, function })
}

/// Returns the steps of a shot by this transport, in a solve or in a relight; `is_covered` if a body covers a part of some shooter.
pub fn algorithm_steps(transport: &Transport, is_covered: bool, relight: Option<&TracedRelight>) -> [AlgorithmStep; 8] {
    let sight = match transport.visibility {
        Visibility::Rays => [
            place("common/src/rays.rs", "find_sight"),
            place("gpu/src/shaders/rays.wgsl", "find_sight"),
        ],
        Visibility::ItemBuffer(_) => [
            place("cpu/src/shader_twins/lookup.rs", "find_sight"),
            place("gpu/src/shaders/lookup.wgsl", "find_sight"),
        ],
    };
    let form_factor = [
        place("common/src/form_factor.rs", "form_factor"),
        place("gpu/src/shaders/form_factor.wgsl", "form_factor"),
    ];
    let deposit = [
        place("cpu/src/shader_twins/deposit.rs", "deposit"),
        place("gpu/src/shaders/deposit.wgsl", "deposit"),
    ];
    let select = [
        place("common/src/shooting.rs", "select_shooter"),
        place("gpu/src/shaders/select.wgsl", "choose_shooter"),
    ];
    let change = match (relight, is_covered) {
        (Some(_), _) => "ΔB ← ρ · F · V · Bᵢ; of captured light ρ · F · (V − V₀) · Bᵢ on the room",
        (None, true) => "ΔB ← ρ · F · V · Bᵢ / oᵢ",
        (None, false) => "ΔB ← ρ · F · V · Bᵢ",
    };
    let [choose, see, keep, clear] = match relight {
        None => [
            "i ← patch with the most unshot power",
            "V ← share of i that j sees",
            "r ← r + ΔB",
            "rᵢ ← 0, the shooter has shot",
        ],
        Some(relight) => [
            "i ← patch with the most captured light left; then with the most unshot change",
            "V, V₀ ← share of i that j sees with and without the objects",
            match relight.reshoot {
                true => "r ← r + ΔB",
                false => "r ← r + ΔB on the objects",
            },
            "rᵢ ← 0 after a shot of its change",
        ],
    };
    let outer = |text, quantity, [rust, wgsl]: [Option<CodePlace>; 2]| AlgorithmStep {
        text,
        is_inner: false,
        quantity,
        rust,
        wgsl,
    };
    let inner = |text, quantity, places| AlgorithmStep {
        is_inner: true,
        ..outer(text, Some(quantity), places)
    };
    [
        outer(choose, Some("before"), select),
        outer("for each texel j:", None, [None; 2]),
        inner(see, "visibility", sight),
        inner("F ← form factor from j to i", "form_factor", form_factor),
        inner(change, "change", deposit),
        inner("B ← B + ΔB", "radiosity", deposit),
        inner(keep, "residual", deposit),
        outer(clear, Some("residual"), deposit),
    ]
}
