//! Settings in `result.json`: every option in force, at one level, and no other.

use common::settings::{ItemBufferProjection, ItemBufferSettings, Lookup, Raster, Settings, SolveQuality, Visibility};
use serde_json::json;

fn drawn(projection: ItemBufferProjection) -> serde_json::Value {
    let visibility = Visibility::ItemBuffer(ItemBufferSettings {
        projection,
        size: 64,
        lookup: Lookup::Exact,
    });
    serde_json::to_value(visibility).unwrap()
}

#[test]
fn settings_with_rays_have_no_item_buffer_options() {
    let rays = serde_json::to_value(Settings::with_quality(SolveQuality::Reference)).unwrap();
    let options = json!({
        "quality": "reference", "texels": 16, "cells": 8, "samples": 16, "visibility": "rays",
        "form-factor": "polygon", "conserve": false, "iteration": "southwell", "epsilon": 1e-4,
        "max-shots": 1_000_000,
    });
    assert_eq!(rays, options);
}

#[test]
fn item_buffer_options_are_at_the_top_level() {
    let mut settings = Settings::default();
    settings.schedule.epsilon = 0.5;
    let rays = serde_json::to_value(settings).unwrap();
    let mut all = rays.as_object().unwrap().clone();
    let drawing = json!({
        "visibility": "stereographic", "item-buffer": 1024, "raster": "pixel", "lookup": "3x3",
    });
    all.extend(drawing.as_object().unwrap().clone());
    let drawn = settings.with_visibility(Visibility::ItemBuffer(ItemBufferSettings::DEFAULT));
    assert_eq!(serde_json::to_value(drawn).unwrap(), json!(all));
}

/// Checks the names of the command line, and the raster in force.
#[test]
fn projections_accept_only_their_rasters() {
    use ItemBufferProjection::{Hemicube, Hemisphere, Paper, Stereographic};
    use Raster::{Pixel, Tessellated};
    let options = |name, raster| json!({"visibility": name, "item-buffer": 64, "raster": raster, "lookup": "exact"});
    assert_eq!(drawn(Paper), options("paper", "tessellated"));
    assert_eq!(drawn(Hemicube), options("hemicube", "pixel"));
    assert_eq!(drawn(Hemisphere(Tessellated)), options("hemisphere", "tessellated"));
    assert_eq!(drawn(Stereographic(Pixel)), options("stereographic", "pixel"));

    assert_eq!(
        (Paper.with_raster(Pixel), Hemicube.with_raster(Tessellated)),
        (None, None)
    );
    assert_eq!(Paper.with_raster(Tessellated), Some(Paper));
    assert_eq!(Hemicube.with_raster(Pixel), Some(Hemicube));
    assert_eq!(
        Stereographic(Pixel).with_raster(Tessellated),
        Some(Stereographic(Tessellated))
    );
}
