//! `merge` run as a program: the files it writes, the input it refuses.

use super::command::TestFolder;
use image::{ImageBuffer, ImageFormat, Luma, Rgb, RgbImage};
use std::io::Cursor;

/// Photographs a smooth scene of eight stops; gamma 2, code 255 at a radiance of 1 in a second.
pub fn expose_scene([w, h]: [u32; 2], seconds: f64) -> RgbImage {
    RgbImage::from_fn(w, h, |x, y| {
        let stops = 8.0 * f64::from(x * h + y) / f64::from(w * h);
        let code = 255.0 * (seconds * (-stops).exp2()).sqrt();
        Rgb([code.min(255.0).round() as u8; 3])
    })
}

/// Makes a folder with photographs a, b and c of 1, 4 and 16 seconds.
pub fn folder_with_bracket(ending: &str) -> TestFolder {
    let folder = TestFolder::new();
    for (name, seconds) in [("a", 1.0), ("b", 4.0), ("c", 16.0)] {
        let file = folder.path(&format!("{name}.{ending}"));
        expose_scene([48, 32], seconds).save(file).unwrap();
    }
    folder
}

#[test]
fn merge_writes_map_and_page() {
    let folder = folder_with_bracket("png");
    let end = folder.succeed("merge c.png a.png b.png --seconds 16,1/1,4.0");
    assert!(end.stderr.contains("3 exposures, 48×32"), "{end}");
    let planes = folder.read_planes("out/radiance.exr");
    assert_eq!((planes.width, planes.height), (48, 32));
    // Code 128 in one second is a radiance of 1.
    let unit = (128.0_f64 / 255.0).powi(2);
    for (k, value) in planes.channels["R"].iter().enumerate() {
        let (x, y) = (k % 48, k / 48);
        let stops = 8.0 * (x * 32 + y) as f64 / 1536.0;
        let off = f64::from(*value) * unit / (-stops).exp2() - 1.0;
        assert!(off.abs() < 0.05, "{x}, {y}: {off}");
    }
    let page = folder.read_text("out/merge.html");
    assert!(page.contains("<svg") && page.contains("data:image/png"));
    assert!(!page.contains("http"), "the page needs the network");
    assert_eq!(std::fs::read_dir(folder.path("out")).unwrap().count(), 2);
}

#[test]
fn jpegs_are_read_upright() {
    let folder = folder_with_bracket("jpg");
    for file in ["a.jpg", "b.jpg", "c.jpg"] {
        let mut bytes = folder.read(file);
        // Exif after the first marker: orientation 6, a quarter turn to the right.
        let mut exif = b"\xff\xe1\x00\x22Exif\0\0MM\0\x2a\0\0\0\x08\0\x01".to_vec();
        exif.extend(b"\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0");
        bytes.splice(2..2, exif);
        folder.write(file, bytes);
    }
    let merge = |more: &str| {
        let line = format!("merge a.jpg b.jpg c.jpg --seconds 1,4,16 --quiet {more}");
        assert_eq!(folder.succeed(&line).stderr, "");
        folder.read_planes("out/radiance.exr")
    };
    let upright = merge("");
    assert_eq!((upright.width, upright.height), (32, 48));
    // The photograph becomes darker to the right, upright it becomes darker downwards.
    let red = &upright.channels["R"];
    assert!(red[16] > 100.0 * red[47 * 32 + 16]);
}

/// Returns the picture with a colour profile of 128 MiB of zeros, which is a small part of that in the file.
pub fn with_inflating_profile(png: &[u8]) -> Vec<u8> {
    let mut zeros = Cursor::new(Vec::new());
    let black = ImageBuffer::from_pixel(1 << 13, 1 << 14, Luma([0_u8]));
    black.write_to(&mut zeros, ImageFormat::Png).unwrap();
    let mut profile = b"iCCPx\0\0".to_vec();
    let mut rest = &zeros.get_ref()[8..];
    while let Some((length, after)) = rest.split_first_chunk() {
        let (chunk, after) = after.split_at(4 + u32::from_be_bytes(*length) as usize);
        profile.extend(chunk.strip_prefix(b"IDAT").unwrap_or_default());
        rest = &after[4..];
    }
    let add_bit = |crc: u32, _| (crc >> 1) ^ ((crc & 1) * 0xedb8_8320);
    let crc = !profile
        .iter()
        .fold(!0, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), add_bit));
    let length = profile.len() as u32 - 4;
    // The header is 33 bytes long.
    let (header, pixels) = png.split_at(33);
    [header, &length.to_be_bytes(), &profile, &crc.to_be_bytes(), pixels].concat()
}

const REFUSED: &str = "
merge a.png b.png --seconds 1 => 2 images and 1
merge a.png --seconds 1 => two at least
merge a.png b.png --seconds 1,1 => b.png
merge a.png b.png --seconds 1,0 => --seconds
merge a.png b.png --seconds=-1,4 => --seconds
merge a.png b.png --seconds 1,1/0 => --seconds
merge a.png b.png --seconds 1,1e20 => b.png
merge a.png b.png --seconds 4,1 => darker
merge a.png b.png => --seconds
merge => <IMAGE>
merge a.png none.png --seconds 1,4 => none.png: cannot be read
merge a.png cut.png --seconds 1,4 => cut.png: cannot be decoded
merge cut.jpg a.jpg --seconds 1,4 => cut.jpg: is cut off
merge almost.jpg a.jpg --seconds 1,4 => almost.jpg: is cut off
merge a.png text.png --seconds 1,4 => text.png: cannot be decoded
merge a.png deep.png --seconds 1,4 => deep.png: has pixels of kind L16
merge a.png turned.png --seconds 1,4 => turned.png: has 32×48
";

#[test]
fn unusable_photographs_are_refused() {
    let folder = folder_with_bracket("png");
    let a = folder.path("a.jpg");
    expose_scene([48, 32], 1.0).save(a).unwrap();
    let turned = folder.path("turned.png");
    expose_scene([32, 48], 4.0).save(turned).unwrap();
    let deep = ImageBuffer::from_pixel(48, 32, Luma([9_u16]));
    deep.save(folder.path("deep.png")).unwrap();
    let (png, jpeg) = (folder.read("b.png"), folder.read("a.jpg"));
    folder.write("cut.png", &png[..png.len() / 2]);
    folder.write("cut.jpg", &jpeg[..jpeg.len() * 4 / 5]);
    folder.write("almost.jpg", &jpeg[..jpeg.len() - 1]);
    folder.write("text.png", "no picture");
    folder.assert_refused(REFUSED);
}
