//! Settings in `result.json`: every option in force, at one level, and no other.

use common::settings::{ItemBufferProjection, ItemBufferSettings, Lookup, Settings, SolveQuality, Visibility};
use serde_json::json;

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
        "visibility": "stereographic", "item-buffer": 1024, "lookup": "3x3",
    });
    all.extend(drawing.as_object().unwrap().clone());
    let drawn = settings.with_visibility(Visibility::ItemBuffer(ItemBufferSettings::DEFAULT));
    assert_eq!(serde_json::to_value(drawn).unwrap(), json!(all));
}

#[test]
fn projections_have_the_names_of_the_command_line() {
    use ItemBufferProjection::{Hemicube, Hemisphere, Paper, Stereographic};
    let named = [
        (Paper, "paper"),
        (Hemicube, "hemicube"),
        (Hemisphere, "hemisphere"),
        (Stereographic, "stereographic"),
    ];
    for (projection, name) in named {
        let drawing = ItemBufferSettings {
            projection,
            size: 64,
            lookup: Lookup::Exact,
        };
        let options = serde_json::to_value(Visibility::ItemBuffer(drawing)).unwrap();
        assert_eq!(
            options,
            json!({"visibility": name, "item-buffer": 64, "lookup": "exact"})
        );
    }
}
