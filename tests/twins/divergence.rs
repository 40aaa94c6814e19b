//! The first divergence names the shot, the texel and the factor of a planted fault, with both sides' numbers and the
//! shares of the stages; two solvers that agree part nowhere.

use super::named_faults::{BY_PIXELS, BY_RAYS, NamedFault, fault_settings};
use common::settings::Settings;
use gpu::ShaderFault;
use oracle::compare::divergence::find_first_divergence;
use oracle::compare::parting::{Factor, FirstDivergence};
use oracle::solve::progress::without_progress;
use radiosity_tests::bundled_scene;
use radiosity_tests::engines::shared_gpu;
use radiosity_tests::shader_faults::compare_with_faults;

/// Shader, text, replacement, factor, and a part of the cause.
type FactorFault = (&'static str, &'static str, &'static str, Factor, &'static str);

/// Factor and a part of the cause of each fault of [`BY_PIXELS`].
const PIXEL_FACTORS: [(Factor, &str); 23] = [
    (Factor::Cosine, "the cosine at the receiver is missing"),
    (Factor::FormFactor, "π is missing"),
    (Factor::Distance, "1/d in the place of 1/d²"),
    (Factor::Frame, "points to the back"),
    (Factor::Area, "the texel's area in the place of the shooter's"),
    (Factor::Visibility, "stage lookup"),
    (Factor::Cosine, "the cosine at the shooter is not cut off"),
    (Factor::Visibility, "hides more"),
    (Factor::Accumulation, "the shooter's residual is not cleared"),
    (Factor::Reflectance, "twice"),
    (
        Factor::Cosine,
        "the cosine at the receiver counts by its absolute value",
    ),
    (Factor::Visibility, "hides more"),
    (Factor::Escape, "directions"),
    (Factor::Stage, "select: workgroups"),
    (Factor::Cosine, "the cosine at the receiver is not cut off"),
    (Factor::Cosine, "the receiver's normal points the other way"),
    (Factor::Cosine, "the receiver's normal is that of face"),
    (Factor::Visibility, "hides more"),
    (Factor::Escape, "directions"),
    (Factor::SampleWeight, "weights"),
    (Factor::Accumulation, "stage exchange"),
    (Factor::Accumulation, "stage collect"),
    (Factor::Link, "0.5000 times"),
];

/// More faults of single shots by an item buffer.
const MORE_FAULTS: [FactorFault; 8] = [
    (
        "select",
        "if power > best {",
        "if power < best {",
        Factor::Choice,
        "the GPU chooses patch",
    ),
    (
        "select",
        "shot.patch_index = patch_index;",
        "shot.patch_index = 4000000000u;",
        Factor::Choice,
        "4000000000, which does not exist",
    ),
    (
        "select",
        "= shot.flux / shot.area;",
        "= shot.flux;",
        Factor::Area,
        "not divided by its area",
    ),
    (
        "unshot_power",
        "vec4f(r * area,",
        "vec4f(r * area * 1.001,",
        Factor::Power,
        "1.0010 times",
    ),
    (
        "deposit",
        "texels[k].reflectance * received;",
        "received;",
        Factor::Reflectance,
        "not multiplied by ρ",
    ),
    (
        "deposit",
        "irradiance[k].xyz + received",
        "irradiance[k].xyz + 2.0 * received",
        Factor::Accumulation,
        "2.0000 times",
    ),
    (
        "deposit",
        "shot.radiosity * f;",
        "shot.radiosity * (f / (f - f));",
        Factor::Accumulation,
        "",
    ),
    (
        "closure",
        "sum += transfers[",
        "sum += 1.01 * transfers[",
        Factor::Closure,
        "1.0100 times",
    ),
];

/// Compares on the plates and finds the first divergence.
fn divergence_with(settings: Settings, faults: &[ShaderFault]) -> FirstDivergence {
    let comparison = compare_with_faults(&bundled_scene("occluded_plates.obj"), settings, faults).unwrap();
    find_first_divergence(&comparison, (shared_gpu(), faults), &without_progress()).unwrap()
}

/// Returns why the first divergence with a fault is not that of `factor`, for a cause with this `text`.
fn find_mistake(fault: ShaderFault, settings: Settings, (factor, text): (Factor, &str)) -> Option<String> {
    let found = divergence_with(settings, &[fault]);
    println!("{fault:?}\n    {}", found.sentences().join("\n    "));
    let names_it = |of: &oracle::compare::parting::Parting| of.factor == factor && of.cause.contains(text);
    let is_named = found.parting.as_ref().is_some_and(names_it);
    (!is_named).then(|| format!("{fault:?}: {}, not {factor:?} {text}", found.headline()))
}

#[test]
fn factor_of_each_planted_fault_is_named() {
    let [by_pixels, by_rays] = fault_settings();
    let planted = |[_, file, _, from, to]: NamedFault| ShaderFault { file, from, to };
    let named = BY_PIXELS.into_iter().map(planted).zip(PIXEL_FACTORS);
    let more = MORE_FAULTS.map(|(file, from, to, factor, text)| (ShaderFault { file, from, to }, (factor, text)));
    let mut mistakes: Vec<String> = (named.chain(more))
        .filter_map(|(fault, expected)| find_mistake(fault, by_pixels, expected))
        .collect();
    mistakes.extend(find_mistake(
        planted(BY_RAYS[0]),
        by_rays,
        (Factor::Visibility, "shows more"),
    ));
    assert!(mistakes.is_empty(), "{mistakes:#?}");
}

#[test]
fn solvers_that_agree_part_nowhere() {
    for settings in fault_settings() {
        let found = divergence_with(settings, &[]);
        assert!(found.parting.is_none() && found.refusal.is_none(), "{found:#?}");
        assert!(found.followed_shots > 2, "{found:#?}");
    }
}

/// The whole difference is that of the stage with the fault.
#[test]
fn stage_of_the_fault_has_the_whole_share() {
    let [by_pixels, _] = fault_settings();
    for (file, from, to, stage) in [
        (
            "form_factor",
            "(PI * r2 + disc_area)",
            "(r2 + disc_area)",
            "form factor",
        ),
        (
            "link",
            "* (seen / (sums.all * open))",
            "* (0.5 * seen / (sums.all * open))",
            "link",
        ),
        (
            "item_buffer",
            "min(hit.t * DEPTH_SCALE, MAX_DEPTH)",
            "0.5",
            "visibility",
        ),
        (
            "deposit",
            "= texels[k].reflectance *",
            "= texels[k].reflectance * texels[k].reflectance *",
            "deposit",
        ),
    ] {
        let found = divergence_with(by_pixels, &[ShaderFault { file, from, to }]);
        let shares = found.shares.unwrap();
        assert!(shares.relative_rms > 0.1, "{shares:?}");
        for share in &shares.stages {
            let expected = if share.stage == stage { shares.relative_rms } else { 0.0 };
            // A changed radiosity changes the GPU's choices as well.
            let is_choice = share.stage == "choice";
            assert!(
                is_choice || (share.relative_rms - expected).abs() < 1e-5,
                "{stage}: {shares:?}"
            );
        }
    }
}
