//! Elements of Matroska and WebM files, and their checksums, which ffmpeg writes but does not check.

use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Result, Seek, copy, sink};
use std::path::Path;

const HEAD: u32 = 0x1A45_DFA3;
const SEGMENT: u32 = 0x1853_8067;
const CLUSTER: u32 = 0x1F43_B675;
const TRACKS: u32 = 0x1654_AE6B;
/// First bytes of an element with a checksum: the id CRC-32 and its length, 4 bytes.
const CHECKSUM: [u8; 2] = [0xBF, 0x84];
/// Ids of the elements of a segment: Cluster, SeekHead, Info, Tracks, Cues, Tags, Chapters, Attachments, Void.
const IN_SEGMENT: [u32; 9] =
    [0x1F43_B675, 0x114D_9B74, 0x1549_A966, TRACKS, 0x1C53_BB6B, 0x1254_C367, 0x1043_A770, 0x1941_A469, 0xEC];

/// Id, and length of the content; `None` for an unknown length. Errors: the end, or no element.
fn element(input: &mut impl Read) -> Result<(u32, Option<u64>)> {
    let (id, _) = variable(input, 4, true)?;
    let (length, bits) = variable(input, 8, false)?;
    let id = u32::try_from(id).map_err(|_| ErrorKind::InvalidData)?;
    Ok((id, (length != (1 << bits) - 1).then_some(length)))
}

/// Reads a number of 1 to `most` bytes, whose first one states how many; returns it with its count of bits.
fn variable(input: &mut impl Read, most: u32, keeps_mark: bool) -> Result<(u64, u32)> {
    let mut first = [0];
    input.read_exact(&mut first)?;
    let bytes = first[0].leading_zeros() + 1;
    if bytes > most {
        return Err(ErrorKind::InvalidData.into());
    }
    // Eight bytes leave no bit of the first one.
    let start = if keeps_mark { first[0] } else { first[0] & 0xFF_u8.checked_shr(bytes).unwrap_or(0) };
    let mut value = u64::from(start);
    for _ in 1..bytes {
        let mut next = [0];
        input.read_exact(&mut next)?;
        value = value << 8 | u64::from(next[0]);
    }
    Ok((value, 7 * bytes))
}

/// Returns the number at the end of a path of ids in the elements of a file, each the first of its id.
pub(super) fn number(bytes: &[u8], path: &[u32]) -> Option<u64> {
    let Some((id, rest)) = path.split_first() else {
        return Some(bytes.iter().fold(0, |number, byte| number << 8 | u64::from(*byte)));
    };
    let mut left = bytes;
    while let Ok((found, length)) = element(&mut left) {
        let length = length.and_then(|length| usize::try_from(length).ok()).unwrap_or(left.len()).min(left.len());
        let (content, after) = left.split_at(length);
        if found == *id {
            return number(content, rest);
        }
        left = after;
    }
    None
}

/// Returns the offset in bytes of the first element whose checksum is wrong, or where an element should begin and does
/// not. `None` if there is none, if the file has no checksums, or if it is only cut, which ffmpeg notices.
pub(super) fn damage(file: &Path) -> Option<u64> {
    let file = File::open(file).ok()?;
    let length = file.metadata().ok().filter(std::fs::Metadata::is_file)?.len();
    let mut input = BufReader::with_capacity(1 << 16, file);
    let (id, head) = element(&mut input).ok()?;
    if id != HEAD {
        return None;
    }
    input.seek_relative(i64::try_from(head?).ok()?).ok()?;
    let (id, segment) = element(&mut input).ok()?;
    if id != SEGMENT {
        return None;
    }
    let end = segment.and_then(|segment| Some(input.stream_position().ok()?.saturating_add(segment)));
    let mut has_checksums = false;
    loop {
        let at = input.stream_position().ok()?;
        if at >= length {
            return None;
        }
        let is_inside = end.is_none_or(|end| at < end);
        let (id, size) = match element(&mut input) {
            Ok((id, Some(size))) if is_inside && IN_SEGMENT.contains(&id) => (id, size),
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => return None,
            // Another file is joined to this one.
            Ok((HEAD, _)) if !is_inside => return None,
            _ => return has_checksums.then_some(at),
        };
        // An element that ends behind its segment has a wrong length; one that ends behind the file may be cut.
        if end.is_some_and(|end| input.stream_position().map_or(true, |begin| begin.saturating_add(size) > end)) {
            return has_checksums.then_some(at);
        }
        let is_whole = match sum_holds(&mut input, size)? {
            Some(holds) => {
                has_checksums = true;
                // Nothing else, such as tags, decides about images.
                holds || ![CLUSTER, TRACKS].contains(&id)
            }
            // A writer of checksums writes one into every cluster.
            None => id != CLUSTER || !has_checksums,
        };
        if !is_whole {
            return Some(at);
        }
    }
}

/// Reads an element's content. Returns whether its checksum holds, `Some(None)` if it has none, or `None` if the content
/// ends too early.
fn sum_holds(input: &mut impl Read, size: u64) -> Option<Option<bool>> {
    let mut content = input.take(size);
    let mut mark = [0; 6];
    if size < 6 {
        return copy(&mut content, &mut sink()).is_ok_and(|read| read == size).then_some(None);
    }
    content.read_exact(&mut mark).ok()?;
    let (mut sum, mut read, mut chunk) = (crc32fast::Hasher::new(), 6, vec![0; 1 << 16]);
    while read < size {
        match content.read(&mut chunk) {
            Ok(more) if more > 0 => {
                sum.update(&chunk[..more]);
                read += more as u64;
            }
            _ => return None,
        }
    }
    Some((mark[..2] == CHECKSUM).then(|| sum.finalize().to_le_bytes() == mark[2..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn element_of(id: &[u8], content: &[u8]) -> Vec<u8> {
        let mut bytes = id.to_vec();
        bytes.extend((0x4000 | u16::try_from(content.len()).unwrap()).to_be_bytes());
        bytes.extend(content);
        bytes
    }

    fn cluster(content: &[u8]) -> Vec<u8> {
        let sum = crc32fast::hash(content).to_le_bytes();
        element_of(&[0x1F, 0x43, 0xB6, 0x75], &[&CHECKSUM[..], &sum, content].concat())
    }

    fn file(clusters: &[u8]) -> Vec<u8> {
        let head = element_of(&[0x1A, 0x45, 0xDF, 0xA3], b"matroska");
        [head, element_of(&[0x18, 0x53, 0x80, 0x67], clusters)].concat()
    }

    fn damage_of(bytes: &[u8]) -> Option<u64> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.mkv");
        std::fs::write(&file, bytes).unwrap();
        damage(&file)
    }

    #[test]
    fn every_changed_byte_behind_the_head_is_found() {
        let clusters = [cluster(b"first"), cluster(b"second")].concat();
        let whole = file(&clusters);
        let (begin, second) = (whole.len() - clusters.len(), whole.len() - cluster(b"second").len());
        assert_eq!(damage_of(&whole), None);
        for at in begin + 13..whole.len() {
            let mut changed = whole.clone();
            changed[at] ^= 0x55;
            let expected = if at < second { begin } else { second };
            assert_eq!(damage_of(&changed), Some(expected as u64), "byte {at}");
        }
        for length in second..whole.len() {
            assert_eq!(damage_of(&whole[..length]), None, "{length} bytes");
        }
        assert_eq!(damage_of(&[whole.clone(), vec![7]].concat()), Some(whole.len() as u64));
    }

    #[test]
    fn a_file_without_checksums_is_not_judged() {
        let plain = element_of(&[0x1F, 0x43, 0xB6, 0x75], b"plain content");
        let whole = file(&plain);
        for length in 0..=whole.len() {
            assert_eq!(damage_of(&whole[..length]), None);
        }
    }

    #[test]
    fn numbers_are_found_by_their_path() {
        let inner = element_of(&[0x55, 0xBA], &[1, 2]);
        let bytes = [element_of(&[0xEC], b"void"), element_of(&[0xAE], &inner)].concat();
        assert_eq!(number(&bytes, &[0xAE, 0x55BA]), Some(0x102));
        assert_eq!(number(&bytes, &[0xAE, 0x55BB]), None);
    }
}
