//! What `result.json` says of the settings: every option in force, side by side, and no other.

use common::settings::{
    Drawing, Lookup, Projection, Quality, Raster, Schedule, Settings, Visibility,
};
use serde_json::json;

fn drawn(projection: Projection) -> serde_json::Value {
    let visibility = Visibility::Drawn(Drawing {
        projection,
        size: 64,
        lookup: Lookup::Exact,
    });
    serde_json::to_value(visibility).unwrap()
}

#[test]
fn rays_have_no_item_buffer() {
    let rays = serde_json::to_value(Settings::of(Quality::Reference)).unwrap();
    let options = json!({
        "quality": "reference", "texels": 16, "cells": 8, "samples": 16, "visibility": "rays",
        "form-factor": "polygon", "conserve": false, "iteration": "southwell", "epsilon": 1e-4,
        "max-shots": 1_000_000,
    });
    assert_eq!(rays, options);
}

#[test]
fn an_item_buffer_lies_flat_among_the_other_options() {
    let settings = Settings {
        schedule: Schedule {
            epsilon: 0.5,
            ..Schedule::default()
        },
        ..Settings::default()
    };
    let rays = serde_json::to_value(settings).unwrap();
    let mut all = rays.as_object().unwrap().clone();
    let drawing = json!({
        "visibility": "stereographic", "item-buffer": 1024, "raster": "pixel", "lookup": "3x3",
    });
    all.extend(drawing.as_object().unwrap().clone());
    let drawn = settings.by(Visibility::Drawn(Drawing::DEFAULT));
    assert_eq!(serde_json::to_value(drawn).unwrap(), json!(all));
}

/// The names of the command line, and the raster that is in force.
#[test]
fn projections_have_the_rasters_that_they_can_have() {
    use Projection::{Hemicube, Hemisphere, Paper, Stereographic};
    use Raster::{Pixel, Tessellated};
    let options = |name, raster| json!({"visibility": name, "item-buffer": 64, "raster": raster, "lookup": "exact"});
    assert_eq!(drawn(Paper), options("paper", "tessellated"));
    assert_eq!(drawn(Hemicube), options("hemicube", "pixel"));
    assert_eq!(
        drawn(Hemisphere(Tessellated)),
        options("hemisphere", "tessellated")
    );
    assert_eq!(
        drawn(Stereographic(Pixel)),
        options("stereographic", "pixel")
    );

    assert_eq!((Paper.by(Pixel), Hemicube.by(Tessellated)), (None, None));
    assert_eq!(Paper.by(Tessellated), Some(Paper));
    assert_eq!(Hemicube.by(Pixel), Some(Hemicube));
    assert_eq!(
        Stereographic(Pixel).by(Tessellated),
        Some(Stereographic(Tessellated))
    );
}
