//! Writes raw frames as Matroska: of the formats that ffmpeg reads from a pipe, no other has raw frames with times. A
//! file consists of elements (identifier, size, data): see <https://www.matroska.org/technical/elements.html>.

/// Size field that means "unknown". The element, here the segment with all frames, extends to the end of the file.
const UNKNOWN: [u8; 8] = [1, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF];
/// Unit of all timestamps, in nanoseconds.
const MICROSECOND: u64 = 1000;

pub(super) fn head((width, height): (u32, u32)) -> Vec<u8> {
    let video =
        [number(&[0xB0], width.into()), number(&[0xBA], height.into()), element(&[0x2E, 0xB5, 0x24], b"RGB\x18")];
    let track = [
        number(&[0xD7], 1),
        number(&[0x73, 0xC5], 1),
        number(&[0x83], 1),
        element(&[0x86], b"V_UNCOMPRESSED"),
        element(&[0xE0], &video.concat()),
    ];
    [
        element(&[0x1A, 0x45, 0xDF, 0xA3], &element(&[0x42, 0x82], b"matroska")),
        [&[0x18, 0x53, 0x80, 0x67], &UNKNOWN[..]].concat(),
        element(&[0x15, 0x49, 0xA9, 0x66], &number(&[0x2A, 0xD7, 0xB1], MICROSECOND)),
        element(&[0x16, 0x54, 0xAE, 0x6B], &element(&[0xAE], &track.concat())),
    ]
    .concat()
}

/// Returns a cluster with one RGB frame, shown at a time for a duration, in microseconds. Without a duration, MP4 would
/// end before the second of two frames.
pub(super) fn frame((time, duration): (u64, u64), rgb: &[u8]) -> Vec<u8> {
    let (time, duration) = (number(&[0xE7], time), number(&[0x9B], duration));
    // Block header: track 1, time offset 0 from the cluster.
    let block = [begin(&[0xA1], 4 + rgb.len()), vec![0x81, 0, 0, 0]].concat();
    let group = [begin(&[0xA0], block.len() + rgb.len() + duration.len()), block].concat();
    let cluster = begin(&[0x1F, 0x43, 0xB6, 0x75], time.len() + group.len() + rgb.len() + duration.len());
    // The pixels, which are many, are copied only once.
    [&cluster, &time, &group, rgb, &duration].concat()
}

fn number(identifier: &[u8], value: u64) -> Vec<u8> {
    element(identifier, &value.to_be_bytes())
}

fn element(identifier: &[u8], data: &[u8]) -> Vec<u8> {
    [&begin(identifier, data.len()), data].concat()
}

/// Returns the beginning of an element with `size` bytes of data.
fn begin(identifier: &[u8], size: usize) -> Vec<u8> {
    // A size field of eight bytes is marked by a 1 in the lowest bit of its first byte.
    [identifier, &(size as u64 | 1 << 56).to_be_bytes()].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_element_is_its_identifier_its_size_and_its_data() {
        assert_eq!(element(&[0x42, 0x82], b"abc"), *b"\x42\x82\x01\0\0\0\0\0\0\x03abc");
        assert_eq!(number(&[0xE7], 258), *b"\xE7\x01\0\0\0\0\0\0\x08\0\0\0\0\0\0\x01\x02");
        let group = [element(&[0xA1], b"\x81\0\0\0\x01\x02\x03"), number(&[0x9B], 1)].concat();
        let cluster = [number(&[0xE7], 7), element(&[0xA0], &group)].concat();
        assert_eq!(frame((7, 1), &[1, 2, 3]), element(&[0x1F, 0x43, 0xB6, 0x75], &cluster));
    }
}
