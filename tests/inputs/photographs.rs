//! Readers of pictures: textures, and the photographs of `merge`, with the merging itself.

use crate::allow_caught_panics;
use crate::folder::Folder;
use crate::numbers::Numbers;
use crate::requirements::require_one_line;
use common::paint::{TexturePicture, WrapMode};
use glam::{DVec2, DVec3};
use radiosity::merge::brackets::{Brackets, CameraResponse, Photograph, RadianceMap};
use radiosity::merge::photographs::read_photographs;
use radiosity::merge::{luminance_stops, merge_notes};

/// Value that a texture has where it would be 1.
const MAXIMUM: f32 = 0.95;

thread_local! {
    static FOLDER: Folder = Folder::new(&[]);
}

/// Checks the reader of textures: PNG, JPEG, WebP.
pub fn check_texture(data: &[u8]) {
    allow_caught_panics();
    let picture = match TexturePicture::decode_image(data, [MAXIMUM; 3]) {
        Ok(picture) => picture,
        Err(message) => return require_one_line(&message),
    };
    assert!(picture.pixel_count() > 0);
    let triangle = [[0.1, 0.2], [2.3, 0.4], [0.5, -1.6]].map(DVec2::from);
    for wrap in [WrapMode::Repeat, WrapMode::Mirror, WrapMode::Clamp] {
        require_colour(picture.mean_over(&triangle, [wrap; 2]));
        for place in triangle {
            require_colour(picture.colour_at(place, [wrap; 2]));
        }
    }
    require_colour(picture.mean_colour());
}

/// Requires a colour from 0 to below 1: of the values above [`MAXIMUM`] only 1 itself is replaced.
fn require_colour(colour: DVec3) {
    assert!(
        colour.cmpge(DVec3::splat(-1e-9)).all() && colour.cmplt(DVec3::ONE).all(),
        "{colour}"
    );
}

/// Checks the reader of photographs: PNG, JPEG.
pub fn check_photograph(data: &[u8]) {
    allow_caught_panics();
    FOLDER.with(|folder| {
        folder.write("a.png", data);
        match read_photographs(&[folder.path("a.png")], &[1.0]) {
            Ok(photographs) => {
                let [width, height] = photographs[0].size;
                assert!(width > 0 && photographs[0].pixels.len() == width * height);
            }
            Err(error) => require_one_line(&error),
        }
    });
}

/// Checks the merging of photographs: their number, their size of up to four pixels per side, and then of each its seconds and
/// its codes.
pub fn check_merge(data: &[u8]) {
    let mut numbers = Numbers(data);
    let count = numbers.choice(&[2, 3, 4, 1]);
    let size = [numbers.choice(&[2, 1, 3, 4]), numbers.choice(&[2, 1, 3, 4])];
    let mut exposures = Vec::new();
    for k in 0..count {
        let seconds = numbers.choice(&[1.0, 0.25, 4.0, 1.0 / 60.0, 1e-9, 1e9, 30.0, f64::NAN]);
        exposures.push(Photograph {
            path: format!("{k}.png").into(),
            seconds,
            size,
            pixels: (0..size[0] * size[1]).map(|_| numbers.take()).collect(),
        });
    }
    let brackets = Brackets::new(exposures);
    let response = brackets.as_ref().map(CameraResponse::from_brackets);
    match (&brackets, response) {
        (Ok(brackets), Ok(Ok(response))) => require_sound_map(brackets, &response),
        (Err(error), _) => require_one_line(error),
        (_, Ok(Err(error))) => require_one_line(&error),
        (_, Err(error)) => require_one_line(error),
    }
}

fn require_sound_map(brackets: &Brackets, response: &CameraResponse) {
    assert!(response.curves.as_flattened().iter().all(|value| value.is_finite()));
    let merged = RadianceMap::new(brackets, response);
    assert!(
        merged
            .radiance
            .iter()
            .all(|value| value.is_finite() && value.min_element() >= 0.0)
    );
    assert!(luminance_stops(&merged).is_none_or(f64::is_finite));
    for note in merge_notes(brackets, response, &brackets.exposure_steps(response)) {
        require_one_line(&note);
    }
}
