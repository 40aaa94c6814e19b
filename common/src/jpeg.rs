//! Whether a JPEG file is whole: decoders fill what is missing of it with grey and say nothing.

/// Markers (ITU-T T.81, table B.1): end of image, start of scan.
const END: u8 = 0xd9;
const SCAN: u8 = 0xda;

/// Walks the segments from the start of the image to its end, since a thumbnail within may have an
/// end of its own; what follows the end does not matter.
///
/// Errors: what is missing.
pub fn whole(bytes: &[u8]) -> Result<(), String> {
    const CUT: &str = "is cut off: copy it again";
    // Behind the marker that begins the image.
    let mut at = 2;
    loop {
        at = marker(bytes, at).ok_or(CUT)?;
        let kind = bytes[at];
        at += 1;
        match kind {
            END => return Ok(()),
            // Without a length.
            0x01 | 0xd0..=0xd8 => {}
            _ => {
                let length = bytes.get(at..at + 2).ok_or(CUT)?;
                at += usize::from(u16::from_be_bytes([length[0], length[1]]));
            }
        }
        if kind == SCAN {
            at = scan_end(bytes, at).ok_or(CUT)?;
        }
    }
}

/// The next marker's second byte.
fn marker(bytes: &[u8], from: usize) -> Option<usize> {
    let first = from + bytes.get(from..)?.iter().position(|b| *b == 0xff)?;
    // Any number of 0xff may stand before it.
    Some(first + bytes[first..].iter().position(|b| *b != 0xff)?)
}

/// Where the entropy-coded data end: at a marker that is neither a stuffed zero nor a restart.
fn scan_end(bytes: &[u8], from: usize) -> Option<usize> {
    let pairs = bytes.get(from..)?.windows(2);
    let ends = |pair: &[u8]| pair[0] == 0xff && !matches!(pair[1], 0 | 0xff | 0xd0..=0xd7);
    Some(from + pairs.into_iter().position(ends)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A thumbnail in its header, restarts and stuffed zeros in its scan, something behind its end.
    const WHOLE: &[u8] = b"\xff\xd8\xff\xe1\x00\x06..\xff\xd9\xff\xff\xda\x00\x03.\
        ab\xff\x00c\xff\xd0d\xff\xdb\x00\x02\xff\xda\x00\x02e\xff\xff\xd9trailer";

    #[test]
    fn whole_is_up_to_the_end_of_the_image() {
        assert_eq!(whole(WHOLE), Ok(()));
        let end = WHOLE.len() - b"trailer".len();
        for length in 0..end {
            assert!(whole(&WHOLE[..length]).is_err(), "{length} bytes");
        }
        assert_eq!(whole(&WHOLE[..end]), Ok(()));
    }
}
