//! Completeness and size of JPEG files: decoders fill the missing part of a truncated file with grey, without an error.

/// Largest number of pixels per side that is decoded: in 16 bits the decoder rounds up to a multiple of eight.
pub const MAX_SIDE: u32 = 65_528;

/// Markers (ITU-T T.81, table B.1): end of image, start of scan.
const END_OF_IMAGE: u8 = 0xd9;
const START_OF_SCAN: u8 = 0xda;

/// Checks that a JPEG of this size can be decoded.
///
/// Errors: the end of a sentence that begins with the picture's name.
pub fn check_sides(size: (u32, u32)) -> Result<(), String> {
    let (width, height) = size;
    if width.max(height) > MAX_SIDE {
        return Err(format!(
            "has {width}×{height} pixels, more than {MAX_SIDE} on a side: scale it down"
        ));
    }
    Ok(())
}

/// Checks that a JPEG file is complete. Walks the segments from the start of the image to its end, since
/// an embedded thumbnail has an end of its own; bytes after the end are ignored.
///
/// Errors: a message that the file is cut off.
pub fn check_whole(bytes: &[u8]) -> Result<(), String> {
    const CUT_OFF: &str = "is cut off: copy it again";
    // After the marker of the start of the image.
    let mut at = 2;
    loop {
        at = next_marker(bytes, at).ok_or(CUT_OFF)?;
        let kind = bytes[at];
        at += 1;
        match kind {
            END_OF_IMAGE => return Ok(()),
            // Markers without a length.
            0x01 | 0xd0..=0xd8 => {}
            _ => {
                let length = bytes.get(at..at + 2).ok_or(CUT_OFF)?;
                at += usize::from(u16::from_be_bytes([length[0], length[1]]));
            }
        }
        if kind == START_OF_SCAN {
            at = scan_end(bytes, at).ok_or(CUT_OFF)?;
        }
    }
}

/// Returns the position of the next marker's second byte.
fn next_marker(bytes: &[u8], from: usize) -> Option<usize> {
    let first = from + bytes.get(from..)?.iter().position(|b| *b == 0xff)?;
    // Any number of 0xff may precede it.
    Some(first + bytes[first..].iter().position(|b| *b != 0xff)?)
}

/// Returns the end of the entropy-coded data: the next marker that is neither a stuffed zero nor a restart.
fn scan_end(bytes: &[u8], from: usize) -> Option<usize> {
    let pairs = bytes.get(from..)?.windows(2);
    let ends = |pair: &[u8]| pair[0] == 0xff && !matches!(pair[1], 0 | 0xff | 0xd0..=0xd7);
    Some(from + pairs.into_iter().position(ends)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A complete file with a thumbnail in its header, restarts and stuffed zeros in its scan, and bytes
    /// after its end.
    const WHOLE_FILE: &[u8] = b"\xff\xd8\xff\xe1\x00\x06..\xff\xd9\xff\xff\xda\x00\x03.\
        ab\xff\x00c\xff\xd0d\xff\xdb\x00\x02\xff\xda\x00\x02e\xff\xff\xd9trailer";

    #[test]
    fn file_is_complete_from_the_end_of_image_on() {
        assert_eq!(check_whole(WHOLE_FILE), Ok(()));
        let end = WHOLE_FILE.len() - b"trailer".len();
        for length in 0..end {
            assert!(check_whole(&WHOLE_FILE[..length]).is_err(), "{length} bytes");
        }
        assert_eq!(check_whole(&WHOLE_FILE[..end]), Ok(()));
    }
}
