//! Radiance maps merged from exposures of a known scene by a known camera.

use approx::abs_diff_eq;
use common::Error;
use radiosity::merge::brackets::{
    Brackets, CameraResponse, MIDDLE_CODE, Photograph, RadianceMap, UnseenPixels, check_picture_size,
};
use radiosity::merge::merge_notes;
use std::path::PathBuf;

const SIZE: [usize; 2] = [160, 120];
/// Stops from one exposure to the next: ten exposures cover 18 stops, and each shows about 8.
const STEP: i32 = 2;
const COUNT: i32 = 10;
/// Sensitivities of red, green and blue.
const GAIN: [f64; 3] = [0.8, 1.0, 1.4];

/// Response of the camera: about a gamma of 2, with a toe and a shoulder that differ between channels.
fn camera(exposure: f64, channel: usize) -> f64 {
    let x = exposure * GAIN[channel];
    let toe = x / (x + 0.002);
    let shoulder = 1.0 - (-(1.2 * x).powf(0.5 + 0.03 * channel as f64)).exp();
    (260.0 * toe * shoulder).min(255.0)
}

/// Exposure that gives a code, by bisection.
fn exposure(code: f64, channel: usize) -> f64 {
    let (mut low, mut high) = (-30.0_f64, 30.0_f64);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if camera(middle.exp(), channel) < code {
            low = middle;
        } else {
            high = middle;
        }
    }
    low.exp()
}

/// A scene with five decades of radiance in hills and valleys; colours differ by up to a half.
fn scene() -> Vec<[f64; 3]> {
    let pixel = |k: usize| {
        let (x, y) = ((k % SIZE[0]) as f64, (k / SIZE[0]) as f64);
        let height = 0.5 + 0.25 * ((x / 23.0).sin() + (y / 17.0 + x / 91.0).cos());
        let luminance = 10_f64.powf(5.0 * height - 2.5);
        [0.0, 2.0, 4.0].map(|phase| luminance * (1.0 + 0.3 * (x / 40.0 + phase).sin()))
    };
    (0..SIZE[0] * SIZE[1]).map(pixel).collect()
}

fn seconds(k: i32) -> f64 {
    2_f64.powi(STEP * (COUNT / 2 - k) - 1)
}

/// Photographs of the scene in whole codes, labelled with exposure times of `labels` seconds.
fn photographs(labels: impl Fn(i32) -> f64) -> Vec<Photograph> {
    let scene = scene();
    let photograph = |k: i32| Photograph {
        path: PathBuf::from(format!("{k}.png")),
        seconds: labels(k),
        size: SIZE,
        pixels: scene
            .iter()
            .map(|e| std::array::from_fn(|c| camera(e[c] * seconds(k), c).round() as u8))
            .collect(),
    };
    (0..COUNT).map(photograph).collect()
}

fn brackets(labels: impl Fn(i32) -> f64) -> Brackets {
    Brackets::new(photographs(labels)).unwrap()
}

/// RMS deviation of ln(merged ÷ true) from its mean, and that mean, over all values with a code of 32…223; true
/// is 1 where code 128 takes one second.
fn error(brackets: &Brackets, merged: &RadianceMap) -> (f64, f64) {
    let (mut sum, mut square, mut count) = (0.0, 0.0, 0.0);
    let unit: [f64; 3] = std::array::from_fn(|c| exposure(MIDDLE_CODE as f64, c));
    for (k, truth) in scene().iter().enumerate() {
        for c in 0..3 {
            let code = |e: &Photograph| (32..=223).contains(&e.pixels[k][c]);
            if brackets.photographs().iter().any(code) {
                let off = (f64::from(merged.radiance[k][c]) * unit[c] / truth[c]).ln();
                sum += off;
                square += off * off;
                count += 1.0;
            }
        }
    }
    assert!(count > 0.99 * 3.0 * merged.radiance.len() as f64, "{count}");
    let mean: f64 = sum / count;
    ((square / count - mean * mean).sqrt(), mean)
}

#[test]
fn known_camera_response_is_recovered() {
    let response = CameraResponse::from_brackets(&brackets(seconds)).unwrap();
    let mut worst = 0.0_f64;
    for (c, curve) in response.curves.iter().enumerate() {
        let unit = exposure(MIDDLE_CODE as f64, c);
        assert_eq!(curve[MIDDLE_CODE], 0.0);
        assert_eq!(response.count_falls(c), 0);
        assert!(response.samples[c] > 256, "{:?}", response.samples);
        for (z, g) in curve.iter().enumerate().take(248).skip(8) {
            let ln = |z: f64| (exposure(z, c) / unit).ln();
            // A code is an interval of exposures, half a code to either side. So is code 128, to which all are
            // relative.
            let half = |z: usize| 0.5 * (ln(z as f64 + 0.5) - ln(z as f64 - 0.5));
            let share = (g - ln(z as f64)).abs() / (half(z) + half(MIDDLE_CODE));
            worst = worst.max(share);
            assert!(share <= 1.0, "channel {c}, code {z}: {share}");
        }
    }
    println!("at most {worst:.2} of the uncertainty from rounding to whole codes");
}

#[test]
fn known_radiance_is_merged_and_swapped_exposure_times_are_reported() {
    let right = brackets(seconds);
    let response = CameraResponse::from_brackets(&right).unwrap();
    let merged = RadianceMap::new(&right, &response);
    let (rms, scale) = error(&right, &merged);
    assert!(rms < 0.02, "{rms}");
    assert!(scale.abs() < 0.01, "{scale}");
    assert_eq!(merged.unseen, UnseenPixels::default());
    assert!(merge_notes(&right, &response, &right.exposure_steps(&response)).is_empty());
    for step in right.exposure_steps(&response) {
        assert!(
            abs_diff_eq!(step.measured.unwrap(), step.nominal, epsilon = 0.05),
            "{step:?}"
        );
    }
    // The fifth and the sixth picture have swapped seconds.
    let swapped = brackets(|k| seconds([0, 1, 2, 3, 5, 4, 6, 7, 8, 9][k as usize]));
    let response = CameraResponse::from_brackets(&swapped).unwrap();
    let (wrong, _) = error(&swapped, &RadianceMap::new(&swapped, &response));
    assert!(wrong > 10.0 * rms && wrong > 0.1, "{wrong}");
    let notes = merge_notes(&swapped, &response, &swapped.exposure_steps(&response));
    let has_note = |text: &str| notes.iter().any(|note| note.contains(text));
    assert!(has_note("5.png to 4.png"), "{notes:?}");
}

#[test]
fn order_of_photographs_does_not_matter() {
    let mut shuffled = photographs(seconds);
    shuffled.swap(0, 7);
    shuffled.rotate_left(3);
    let (a, b) = (brackets(seconds), Brackets::new(shuffled).unwrap());
    let (of_a, of_b) = (
        CameraResponse::from_brackets(&a).unwrap(),
        CameraResponse::from_brackets(&b).unwrap(),
    );
    assert_eq!(of_a, of_b);
    assert_eq!(
        RadianceMap::new(&a, &of_a).radiance,
        RadianceMap::new(&b, &of_b).radiance
    );
}

#[test]
fn saturated_and_black_pixels_are_counted_and_bounded() {
    let mut response = CameraResponse {
        curves: [[0.0; 256]; 3],
        samples: [0; 3],
    };
    for curve in &mut response.curves {
        for (z, g) in curve.iter_mut().enumerate() {
            *g = (z as f64 - 128.0) / 64.0;
        }
    }
    let exposure = |seconds: f64, codes: [u8; 4]| Photograph {
        path: PathBuf::from("x.png"),
        seconds,
        size: [4, 1],
        pixels: codes.map(|z| [z; 3]).to_vec(),
    };
    let list = vec![
        exposure(0.125, [255, 0, 0, 0]),
        exposure(0.25, [255, 0, 0, 64]),
        exposure(2.0, [255, 0, 255, 255]),
        exposure(4.0, [255, 0, 255, 255]),
    ];
    let merged = RadianceMap::new(&Brackets::new(list).unwrap(), &response);
    assert_eq!(
        merged.unseen,
        UnseenPixels {
            saturated: 1,
            black: 1,
            between: 1
        }
    );
    let expected = [
        // 255 in an eighth of a second; 0; between 255 in two seconds and 0 in a quarter; 64 in a quarter.
        (127.0_f64 / 64.0).exp() / 0.125,
        0.0,
        (0.5 * ((127.0 / 64.0 - 2_f64.ln()) + (-2.0 - 0.25_f64.ln()))).exp(),
        (-1_f64).exp() / 0.25,
    ];
    for (value, expected) in merged.radiance.iter().zip(expected) {
        assert!(
            abs_diff_eq!(value.x as f64, expected, epsilon = 1e-6 * expected),
            "{value} {expected}"
        );
        assert!(value.x == value.y && value.y == value.z, "grey stays grey");
    }
}

#[test]
fn invalid_brackets_are_refused_with_file_name() {
    let refused = |change: &dyn Fn(&mut Vec<Photograph>), says: [&str; 2]| {
        let mut list = photographs(seconds);
        change(&mut list);
        let text = match Brackets::new(list).and_then(|b| CameraResponse::from_brackets(&b)) {
            Err(error @ (Error::Input { .. } | Error::Usage(_))) => error.to_string(),
            other => panic!("{other:?}"),
        };
        assert!(says.iter().all(|s| text.contains(s)), "{text}");
        assert!(!text.contains('\n'));
    };
    refused(&|list| list.clear(), ["0 exposures", "two at least"]);
    for wrong in [f64::NAN, f64::INFINITY, 1e-300] {
        refused(&|list| list[3].seconds = wrong, ["3.png", "above 0"]);
    }
    for (side, count) in [(0, 2), (1 << 14, 2), (1 << 13, 9)] {
        let error = check_picture_size("big.png".as_ref(), [side; 2], count).unwrap_err();
        assert!(error.to_string().contains("big.png"), "{error}");
    }
    assert!(check_picture_size("big.png".as_ref(), [1 << 13; 2], 8).is_ok());
    let black = |list: &mut Vec<Photograph>| {
        for exposure in list {
            exposure.pixels.fill([0; 3]);
        }
    };
    refused(&black, ["red channel", "well exposed"]);
    let same = |list: &mut Vec<Photograph>| {
        let pixels = list[4].pixels.clone();
        for exposure in list {
            exposure.pixels.clone_from(&pixels);
        }
    };
    refused(&same, ["red channel", "well exposed"]);
}
