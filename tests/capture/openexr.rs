//! Decoding of OpenEXR maps of every layout, from files made by the tests.

use common::Error;
use common::capture::{MAX_PIXELS, MapProjection};
use exr::prelude::*;
use glam::Vec3;
use radiosity_tests::radiance_files::{read_panorama, refusal_of_bytes};
use std::io::Cursor;

/// An EXR file of one layer.
fn layer(
    size: [usize; 2],
    attributes: LayerAttributes,
    encoding: Encoding,
    channels: Vec<AnyChannel<FlatSamples>>,
) -> Vec<u8> {
    let channels = AnyChannels::sort(channels.into());
    let image = Image::from_layer(Layer::new(Vec2(size[0], size[1]), attributes, encoding, channels));
    written(image)
}

fn written(image: Image<Layer<AnyChannels<FlatSamples>>>) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// Channels of these names, each pixel (k + ½) × the channel's place, 1, 2, 3, ….
fn channels(names: &[&str], count: usize) -> Vec<AnyChannel<FlatSamples>> {
    let plane = |c: usize| (0..count).map(|k| (k as f32 + 0.5) * (c + 1) as f32).collect();
    let channel = |(c, name): (usize, &&str)| AnyChannel::new(*name, FlatSamples::F32(plane(c)));
    names.iter().enumerate().map(channel).collect()
}

#[test]
fn openexr_layers_are_found_by_their_channels() {
    let size = [16, 8];
    let value = |k: usize| Vec3::new(1.0, 2.0, 3.0) * (k as f32 + 0.5);
    let colours: Vec<Vec3> = (0..128).map(value).collect();
    let grey: Vec<Vec3> = (0..128).map(|k| Vec3::splat(k as f32 + 0.5)).collect();
    let plain = LayerAttributes::default();
    let cases: [(&[&str], &[Vec3], usize); 5] = [
        (&["R", "G", "B"], &colours, 0),
        (&["R", "G", "B", "A", "Z"], &colours, 0),
        (&["diffuse.R", "diffuse.G", "diffuse.B", "Z"], &colours, 1),
        (&["Y"], &grey, 1),
        (&["R", "G", "B", "Y", "left.R", "left.G", "left.B"], &colours, 0),
    ];
    let tiles = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::Tiles(Vec2(5, 3)),
        line_order: LineOrder::Increasing,
    };
    for (names, truth, notes) in cases {
        for encoding in [Encoding::FAST_LOSSLESS, Encoding::UNCOMPRESSED, tiles] {
            let map = read_panorama(&layer(size, plain.clone(), encoding, channels(names, 128)), None).unwrap();
            assert!(map.pixels() == truth, "{names:?}");
            assert_eq!(map.notes.len(), notes, "{:?}", map.notes);
        }
    }
    for names in [&["R", "G"][..], &["Z"], &["Y", "RY", "BY"]] {
        let bytes = layer(size, plain.clone(), Encoding::UNCOMPRESSED, channels(names, 128));
        refusal_of_bytes(&bytes);
    }
    let mut half = channels(&["R", "G", "B"], 128);
    half[1].sample_data = FlatSamples::F16(grey.iter().map(|v| f16::from_f32(v.x)).collect());
    half[2].sample_data = FlatSamples::U32((0..128).collect());
    let map = read_panorama(&layer(size, plain, Encoding::FAST_LOSSLESS, half), None).unwrap();
    assert_eq!(map.pixels()[100], Vec3::new(100.5, 100.5, 100.0));
}

#[test]
fn map_covers_the_display_window() {
    let three = channels(&["R", "G", "B"], 4 * 3);
    let attributes = LayerAttributes {
        layer_position: Vec2(-1, 6),
        ..LayerAttributes::default()
    };
    let bytes = {
        let channels = AnyChannels::sort(three.into());
        let layer = Layer::new(Vec2(4, 3), attributes, Encoding::FAST_LOSSLESS, channels);
        let display = IntegerBounds::new(Vec2(0, 0), Vec2(16, 8));
        written(Image::new(ImageAttributes::new(display), layer))
    };
    let map = read_panorama(&bytes, None).unwrap();
    assert_eq!(map.size(), [16, 8]);
    assert_eq!(map.notes.len(), 1, "{:?}", map.notes);
    for (k, pixel) in map.pixels().iter().enumerate() {
        let (x, y) = (k % 16, k / 16);
        let own = (x < 3 && y >= 6).then(|| (y - 6) * 4 + x + 1);
        assert_eq!(pixel.x, own.map_or(0.0, |k| k as f32 + 0.5), "{x} {y}");
    }
}

#[test]
fn primaries_are_converted_and_envmap_sets_projection() {
    let channels = AnyChannels::sort(channels(&["R", "G", "B"], 24).into());
    let mut image = Image::from_layer(Layer::new(
        Vec2(2, 12),
        LayerAttributes {
            environment_map: Some(exr::meta::attribute::EnvironmentMap::LatitudeLongitude),
            ..LayerAttributes::default()
        },
        Encoding::FAST_LOSSLESS,
        channels,
    ));
    image.attributes.chromaticities = Some(exr::meta::attribute::Chromaticities {
        red: Vec2(0.30, 0.60),
        green: Vec2(0.64, 0.33),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.3290),
    });
    let bytes = written(image);
    let map = read_panorama(&bytes, None).unwrap();
    assert_eq!(map.projection(), MapProjection::LatLong, "the attribute, not 1:6");
    // Red and green have changed places, and nothing else.
    let truth = Vec3::new(1.0, 0.5, 1.5);
    assert!(
        (map.pixels()[0] - truth).abs().max_element() < 1e-6,
        "{}",
        map.pixels()[0]
    );
    let cube = read_panorama(&bytes, Some(MapProjection::Cube)).unwrap();
    assert_eq!(cube.projection(), MapProjection::Cube);
    assert!(matches!(
        read_panorama(&bytes, Some(MapProjection::Angular)),
        Err(Error::Input { .. })
    ));
}

#[test]
fn header_of_oversized_image_is_refused_before_allocation() {
    let three = channels(&["R", "G", "B"], 128);
    let whole = layer([16, 8], LayerAttributes::default(), Encoding::UNCOMPRESSED, three);
    let promising = |side: i32| {
        let mut bytes = whole.clone();
        let mut put = |name: &[u8], offset: usize, value: i32| {
            let at = bytes.windows(name.len()).position(|w| w == name).unwrap();
            let at = at + name.len() + 4 + offset;
            bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        };
        for name in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
            put(name, 8, side - 1);
            put(name, 12, side - 1);
        }
        put(b"chunkCount\0int\0", 0, side);
        // The offset table of so many lines would be longer than the file.
        let text = refusal_of_bytes(&bytes);
        assert!(text.contains("blocks") || text.contains("2^26"), "{text}");
    };
    promising(8192);
    promising(8193);
    promising(1_000_000);
}

#[test]
fn damaged_openexr_file_is_refused() {
    let three = || channels(&["R", "G", "B"], 128);
    for encoding in [
        Encoding::FAST_LOSSLESS,
        Encoding::SMALL_LOSSLESS,
        Encoding::UNCOMPRESSED,
    ] {
        let whole = layer([16, 8], LayerAttributes::default(), encoding, three());
        for keep in (0..whole.len()).step_by(5) {
            refusal_of_bytes(&whole[..keep]);
        }
        // A wrong byte gives an error or a map of an allowed size, never a panic.
        for at in (0..whole.len()).step_by(3) {
            let mut bytes = whole.clone();
            bytes[at] ^= 0xff;
            match read_panorama(&bytes, None) {
                Ok(map) => assert!((map.size()[0] * map.size()[1]) as u64 <= MAX_PIXELS),
                Err(Error::Input { .. }) => {}
                Err(error) => panic!("byte {at}: {error}"),
            }
        }
    }
}
