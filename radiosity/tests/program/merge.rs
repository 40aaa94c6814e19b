//! `merge` run as a program: the files it writes, the input it refuses.

use common::solution::pixels::ImagePlanes;
use image::{ImageBuffer, Luma, Rgb, RgbImage};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn empty_folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("merge-{}-{name}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn run_merge(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_radiosity"))
        .current_dir(folder)
        .arg("merge")
        .args(arguments)
        .output()
        .unwrap()
}

/// Photographs a smooth scene of eight stops; gamma 2, code 255 at a radiance of 1 in a second.
fn expose_scene([w, h]: [u32; 2], seconds: f64) -> RgbImage {
    RgbImage::from_fn(w, h, |x, y| {
        let stops = 8.0 * f64::from(x * h + y) / f64::from(w * h);
        let code = 255.0 * (seconds * (-stops).exp2()).sqrt();
        Rgb([code.min(255.0).round() as u8; 3])
    })
}

/// Writes photographs a, b and c of 1, 4 and 16 seconds; returns their names.
fn write_bracket(folder: &Path, size: [u32; 2], ending: &str) -> [String; 3] {
    [("a", 1.0), ("b", 4.0), ("c", 16.0)].map(|(name, seconds)| {
        let file = format!("{name}.{ending}");
        expose_scene(size, seconds).save(folder.join(&file)).unwrap();
        file
    })
}

#[test]
fn merge_writes_map_and_page() {
    let folder = empty_folder("files");
    let size = [48, 32];
    write_bracket(&folder, size, "png");
    let list = "\u{feff}file, note ,seconds\r\n\r\nc.png,x,16\r\na.png,,1/1\r\nb.png,,4.0\r\n";
    fs::write(folder.join("list.csv"), list).unwrap();
    let output = run_merge(&folder, &["--exposures", "list.csv", "--out", "out"]);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains("3 exposures, 48×32"), "{text}");
    let out = folder.join("out");
    let planes = ImagePlanes::read(&out.join("radiance.exr"), 1 << 20).unwrap();
    assert_eq!((planes.width, planes.height), (48, 32));
    let [red, ..] = planes.colour_planes("").unwrap();
    // Code 128 in one second is a radiance of 1.
    let unit = (128.0_f64 / 255.0).powi(2);
    for (k, value) in red.iter().enumerate() {
        let (x, y) = (k % 48, k / 48);
        let stops = 8.0 * (x * 32 + y) as f64 / 1536.0;
        let off = f64::from(*value) * unit / (-stops).exp2() - 1.0;
        assert!(off.abs() < 0.05, "{x}, {y}: {off}");
    }
    let page = fs::read_to_string(out.join("merge.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("data:image/png"));
    assert!(!page.contains("http"), "the page needs the network");
    assert_eq!(fs::read_dir(&out).unwrap().count(), 2);
}

#[test]
fn jpegs_are_read_upright_and_fisheye_becomes_angular_map() {
    let folder = empty_folder("jpeg");
    for file in write_bracket(&folder, [48, 32], "jpg") {
        let mut bytes = fs::read(folder.join(&file)).unwrap();
        // Exif after the first marker: orientation 6, a quarter turn to the right.
        let mut exif = b"\xff\xe1\x00\x22Exif\0\0MM\0\x2a\0\0\0\x08\0\x01".to_vec();
        exif.extend(b"\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0");
        bytes.splice(2..2, exif);
        fs::write(folder.join(&file), bytes).unwrap();
    }
    let images = ["a.jpg", "b.jpg", "c.jpg", "--seconds", "1,4,16", "--quiet"];
    let of = |more: &[&str]| {
        let output = run_merge(&folder, &[&images[..], more].concat());
        assert_eq!((output.status.code(), output.stderr), (Some(0), Vec::new()));
        let path = folder.join(more.last().unwrap()).join("radiance.exr");
        ImagePlanes::read(&path, 1 << 20).unwrap()
    };
    let upright = of(&["--out", "plain"]);
    assert_eq!((upright.width, upright.height), (32, 48));
    // The photograph becomes darker to the right, upright it becomes darker downwards.
    let [red, ..] = upright.colour_planes("").unwrap();
    assert!(red[16] > 100.0 * red[47 * 32 + 16]);
    let framed = of(&["--fisheye", "180", "--out", "framed"]);
    assert_eq!((framed.width, framed.height), (64, 64));
    let [red, ..] = framed.colour_planes("").unwrap();
    assert!(red[32 * 64 + 32] > 0.0 && red[15 * 64 + 32] == 0.0);
}

/// Arguments and text of the message.
const REFUSED: [(&[&str], &str); 25] = [
    (&["a.png", "b.png", "--seconds", "1"], "2 images and 1"),
    (&["a.png", "--seconds", "1"], "two at least"),
    (&["a.png", "b.png", "--seconds", "1,1"], "b.png"),
    (&["a.png", "b.png", "--seconds", "1,0"], "--seconds"),
    (&["a.png", "b.png", "--seconds=-1,4"], "--seconds"),
    (&["a.png", "b.png", "--seconds", "1,1/0"], "--seconds"),
    (&["a.png", "b.png", "--seconds", "1,1e20"], "b.png"),
    (&["a.png", "b.png", "--seconds", "4,1"], "darker"),
    (&["a.png", "b.png"], "--seconds"),
    (&[], "--seconds"),
    (&["a.png", "none.png", "--seconds", "1,4"], "none.png: cannot be read"),
    (&["a.png", "cut.png", "--seconds", "1,4"], "cut.png: cannot be decoded"),
    (
        &["a.png", "text.png", "--seconds", "1,4"],
        "text.png: cannot be decoded",
    ),
    (
        &["a.png", "deep.png", "--seconds", "1,4"],
        "deep.png: has pixels of kind L16",
    ),
    (&["a.png", "turned.png", "--seconds", "1,4"], "turned.png: has 32×48"),
    (&["--exposures", "none.csv"], "none.csv"),
    (&["--exposures", "no_column.csv"], "no_column.csv: its first line"),
    (&["--exposures", "no_file.csv"], "`file`"),
    (&["--exposures", "word.csv"], "word.csv: line 3"),
    (&["--exposures", "short.csv"], "short.csv: line 3"),
    (&["--exposures", "quoted.csv"], "quoted.csv: line 2"),
    (&["--exposures", "empty.csv"], "empty.csv: is empty"),
    (&["--exposures", "one.csv"], "two at least"),
    (&["--exposures", "other.csv", "--column", "t"], "other.csv: line 3"),
    (&["a.png", "b.png", "--seconds", "1,4", "--fisheye", "0"], "--fisheye 0"),
];

#[test]
fn bad_input_is_one_error_line_and_code_2() {
    let folder = empty_folder("bad");
    write_bracket(&folder, [48, 32], "png");
    let put = |name: &str, text: &str| fs::write(folder.join(name), text).unwrap();
    expose_scene([32, 48], 4.0).save(folder.join("turned.png")).unwrap();
    let deep = ImageBuffer::from_pixel(48, 32, Luma([9_u16]));
    deep.save(folder.join("deep.png")).unwrap();
    let bytes = fs::read(folder.join("b.png")).unwrap();
    fs::write(folder.join("cut.png"), &bytes[..bytes.len() / 2]).unwrap();
    put("text.png", "no picture");
    put("no_column.csv", "file,time\na.png,1\n");
    put("no_file.csv", "name,seconds\na.png,1\n");
    put("word.csv", "file,seconds\na.png,1\nb.png,four\n");
    put("short.csv", "file,seconds\n\na.png\n");
    put("quoted.csv", "file,seconds\n\"a.png\",1\n");
    put("empty.csv", "");
    put("one.csv", "file,seconds\na.png,1\n");
    put("other.csv", "file,seconds,t\na.png,1,1\nb.png,4,0\n");
    for (arguments, says) in REFUSED {
        let output = run_merge(&folder, &[arguments, &["--out", "out"]].concat());
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
        let lines: Vec<&str> = text.lines().collect();
        assert!(
            matches!(lines[..], [line] if line.starts_with("error:") && line.contains(says)),
            "{arguments:?}: {text}"
        );
        assert!(!folder.join("out").exists(), "{arguments:?} wrote something");
    }
}
