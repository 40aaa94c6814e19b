//! Versions and indices as the file has them: the crate `gltf` looks at no version, and makes 0 of
//! an index of 2³².

use serde_json::Value;

/// Properties that hold indices: a number, a list of them, or (`attributes`) numbers by name.
const INDICES: [&str; 9] = [
    "scene",
    "nodes",
    "children",
    "mesh",
    "material",
    "attributes",
    "indices",
    "bufferView",
    "buffer",
];

/// Whether the document is glTF 2.0, or a later 2.x that a reader of 2.0 may read.
pub fn version(document: &Value) -> Result<(), String> {
    let of = |name: &str| document["asset"][name].as_str();
    let version = of("version").ok_or("is not valid glTF 2.0: it has no asset.version")?;
    if version.split('.').next() != Some("2") {
        return Err(format!("is glTF version {version}: export it as version 2"));
    }
    match of("minVersion") {
        None | Some("2.0") => Ok(()),
        Some(least) => Err(format!(
            "needs a reader of glTF {least}: export it as version 2.0"
        )),
    }
}

/// Whether every index fits in 32 bits; a file nests no deeper than its parser allows.
pub fn indices(document: &Value) -> Result<(), String> {
    match document {
        Value::Array(values) => values.iter().try_for_each(indices),
        Value::Object(entries) => entries.iter().try_for_each(|(name, value)| {
            if INDICES.contains(&name.as_str()) {
                small(name, value)?;
            }
            indices(value)
        }),
        _ => Ok(()),
    }
}

fn small(name: &str, value: &Value) -> Result<(), String> {
    match value {
        Value::Number(number) if number.as_u64().is_some_and(|n| n > u64::from(u32::MAX)) => {
            Err(format!("has the index {number} in `{name}`: it is damaged"))
        }
        Value::Array(values) => values.iter().try_for_each(|value| small(name, value)),
        Value::Object(entries) if name == "attributes" => {
            entries.values().try_for_each(|value| small(name, value))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn only_versions_that_can_be_read() {
        let asset = |asset: Value| version(&json!({ "asset": asset }));
        for good in [
            json!({"version": "2.0"}),
            json!({"version": "2.1"}),
            json!({"version": "2.1", "minVersion": "2.0"}),
        ] {
            assert_eq!(asset(good), Ok(()));
        }
        for bad in [
            json!({}),
            json!({"version": 2}),
            json!({"version": "1.0"}),
            json!({"version": "20.0"}),
            json!({"version": "3.0"}),
            json!({"version": "2.1", "minVersion": "2.1"}),
        ] {
            assert!(asset(bad.clone()).is_err(), "{bad}");
        }
    }

    #[test]
    fn indices_of_33_bits_are_found_and_other_numbers_are_not() {
        let beyond = 1_u64 << 32;
        for bad in [
            json!({"scene": beyond}),
            json!({"scenes": [{"nodes": [0, beyond]}]}),
            json!({"meshes": [{"primitives": [{"attributes": {"POSITION": beyond}}]}]}),
            json!({"accessors": [{"sparse": {"indices": {"bufferView": beyond}}}]}),
        ] {
            assert!(indices(&bad).is_err(), "{bad}");
        }
        let good = json!({"nodes": [{"mesh": 4_294_967_295_u64, "translation": [beyond, 0, 0]}],
            "accessors": [{"max": [beyond], "indices": {"byteOffset": beyond}}]});
        assert_eq!(indices(&good), Ok(()));
    }
}
