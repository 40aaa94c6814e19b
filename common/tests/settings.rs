//! Settings in `result.json`: every option in force, at one level, and no other.

use common::settings::{ItemBufferProjection, ItemBufferSettings, Lookup, Settings, SolveQuality, Visibility};
use serde_json::json;

/// Rays have no options of an item buffer; projections have the names of the command line.
#[test]
fn settings_are_written_at_one_level() {
    let settings = Settings::with_quality(SolveQuality::Reference);
    let mut expected = json!({
        "quality": "reference", "texels": 16, "cells": 8, "samples": 16, "visibility": "rays",
        "form-factor": "polygon", "conserve": false, "iteration": "southwell", "epsilon": 1e-4,
        "max-shots": 1_000_000,
    });
    assert_eq!(serde_json::to_value(settings).unwrap(), expected);
    for (projection, name, lookup, lookup_name) in [
        (ItemBufferProjection::Paper, "paper", Lookup::Exact, "exact"),
        (ItemBufferProjection::Hemicube, "hemicube", Lookup::Exact, "exact"),
        (
            ItemBufferProjection::Hemisphere,
            "hemisphere",
            Lookup::Neighbours,
            "3x3",
        ),
        (
            ItemBufferProjection::Stereographic,
            "stereographic",
            Lookup::Neighbours,
            "3x3",
        ),
    ] {
        let drawing = ItemBufferSettings {
            projection,
            size: 64,
            lookup,
        };
        let drawn = settings.with_visibility(Visibility::ItemBuffer(drawing));
        expected["visibility"] = json!(name);
        expected["item-buffer"] = json!(64);
        expected["lookup"] = json!(lookup_name);
        assert_eq!(serde_json::to_value(drawn).unwrap(), expected);
    }
}
