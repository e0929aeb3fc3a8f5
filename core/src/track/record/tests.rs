//! Tests of reading: a plain reader finds the same entries, and the work is linear in the size of any record.

use super::*;
use proptest::prelude::*;
use std::{vec, vec::Vec};

fn head(tag: Tag, number: u32, length: u32) -> Vec<u8> {
    [tag.bytes(), number.to_le_bytes(), length.to_le_bytes()].concat()
}

fn sealed(tag: Tag, number: u32, content: &[u8]) -> Vec<u8> {
    let mut entry = head(tag, number, content.len() as u32);
    entry.extend(content);
    entry.extend(crc32fast::hash(&entry).to_le_bytes());
    entry
}

/// A begin with as few bytes as possible, and `size` bytes of entries after it.
fn flight(sizes: &[usize]) -> Vec<u8> {
    let entries =
        sizes.iter().zip(1..).flat_map(|(&size, number)| sealed(Tag::Restored, number, &vec![number as u8; size]));
    sealed(Tag::Begin, 0, &[2, 0, b'P', 0]).into_iter().chain(entries).collect()
}

/// An entry as (offset, size, number, skipped bytes before it), or the damage.
type Read = Result<(usize, usize, u32, usize), Damage>;

/// Reads a record with `entries`. Returns what it found, the skipped bytes at the end, and the work.
fn read(record: &[u8]) -> (Vec<Read>, usize, u64) {
    let (mut all, mut found) = (entries(record), vec![]);
    while let Some(next) = all.next() {
        let cut_off = all.cut_off();
        found.push(next.map(|found| (found.at, found.size, found.number, cut_off)));
    }
    let cut_off = if found.last().is_some_and(Result::is_err) { 0 } else { all.cut_off() };
    assert!(all.work() <= 70 * record.len() as u64, "{} for {}", all.work(), record.len());
    (found, cut_off, all.work())
}

/// Reads a record as the format says, with any amount of work: an entry begins at the first offset that has one.
fn read_plainly(record: &[u8]) -> (Vec<Read>, usize) {
    let entry = |at: usize| {
        let word = |at: usize| record.get(at..at + 4).map(|bytes| u32::from_le_bytes(bytes.try_into().unwrap()));
        let tag = Tag::ALL.into_iter().find(|tag| record[at..].starts_with(&tag.bytes()))?;
        let (number, length) = (word(at + 4)?, word(at + 8)? as usize);
        let sum = word(at + HEAD + length)?;
        (crc32fast::hash(&record[at..at + HEAD + length]) == sum).then_some((at, tag, number, length))
    };
    let (mut found, mut start, mut expected) = (vec![], 0, 0);
    while let Some((at, tag, number, length)) = (start..record.len()).find_map(entry) {
        let wanted = if tag == Tag::Begin { 0 } else { expected };
        let damage = |at, flaw| Err(Damage { at, flaw });
        let read = if at > start && tag != Tag::Begin {
            damage(start, Flaw::NoEntry(at - start))
        } else if number != wanted {
            damage(at, Flaw::Missing(wanted))
        } else {
            Ok((at, AROUND + length, number, at - start))
        };
        found.push(read);
        if read.is_err() {
            return (found, 0);
        }
        (start, expected) = (at + AROUND + length, number + 1);
    }
    (found, record.len() - start)
}

fn piece() -> impl Strategy<Value = Vec<u8>> {
    let sizes = prop::collection::vec(prop_oneof![0..40_usize, 300..700_usize], 0..5);
    let nested = (any::<[u8; 20]>(), sizes.clone()).prop_map(|(around, sizes)| {
        let inner = [&around[..], &flight(&sizes), &around[..]].concat();
        [sealed(Tag::Begin, 0, &[2, 0, b'R', 0]), sealed(Tag::Restored, 1, &inner)].concat()
    });
    prop_oneof![
        4 => sizes.prop_map(|sizes| flight(&sizes)),
        1 => nested,
        1 => prop::collection::vec(any::<u8>(), 1..60),
        1 => (prop::sample::select(&Tag::ALL[..]), 0..3_u32, 0..2000_u32).prop_map(|(tag, number, length)| head(tag, number, length)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(2000) })]

    /// Restarts in the middle of an entry, lost bytes, changed bits, and records inside of entries.
    #[test]
    fn a_plain_reader_finds_the_same_entries(
        pieces in prop::collection::vec((piece(), prop::option::weighted(0.3, 0..700_usize)), 1..6),
        flips in prop::collection::vec(any::<prop::sample::Index>(), 0..3),
    ) {
        let cut = |(mut piece, end): (Vec<u8>, Option<usize>)| {
            piece.truncate(end.unwrap_or(usize::MAX));
            piece
        };
        let mut record: Vec<u8> = pieces.into_iter().flat_map(cut).collect();
        for flip in flips.iter().filter(|_| !record.is_empty()).map(|flip| flip.index(record.len() * 8)).collect::<Vec<_>>() {
            record[flip / 8] ^= 1 << (flip % 8);
        }
        let (found, cut_off, _) = read(&record);
        prop_assert_eq!((found, cut_off), read_plainly(&record));
    }

}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(30) })]

    /// Heads of every kind, that claim anything, between and over intact entries. `read` checks the work.
    #[test]
    fn the_work_is_linear_in_the_size_of_any_record(
        kinds in prop::collection::vec((0..=6_usize, prop_oneof![Just(0), Just(u32::MAX), 0..700_u32, 0..40_000_u32]), 300..900),
        tail in 0..20_000_usize,
    ) {
        let all: usize = 16 * kinds.len() + tail;
        let mut record = vec![];
        for (kind, claims) in kinds {
            let left = all.saturating_sub(record.len() + AROUND) as u32;
            match Tag::ALL.get(kind) {
                Some(&tag) => record.extend(head(tag, u32::from(tag != Tag::Begin), claims.min(left))),
                None => record.extend(sealed(Tag::Begin, 0, &[2, 0, b'P', 0])),
            }
        }
        record.resize(record.len() + tail, 0);
        read(&record);
    }
}

#[test]
fn hostile_records_take_linear_work() {
    let size = 128 << 10;
    let heads = |tag: Tag, spacing: usize, claims: &dyn Fn(usize) -> u32| -> Vec<u8> {
        let mut record = vec![];
        while record.len() + spacing + AROUND < size {
            record.extend(head(tag, 0, claims(size - record.len() - AROUND)));
            record.resize(record.len() + spacing - HEAD, 0);
        }
        record.resize(size, 0);
        record
    };
    for tag in Tag::ALL {
        read(&heads(tag, 12, &|left| left as u32));
        read(&heads(tag, 60, &|left| left as u32 / 2));
    }
    let (_, _, work) = read(&heads(Tag::Begin, 12, &|left| left.min(640) as u32));
    assert!(work > 50 * size as u64, "{work}: the bound is nearly reached");
    // Firmware that restarts over and over, and is cut off each time in an entry that claims nearly all of the record.
    let restart = [flight(&[]), head(Tag::Window, 1, size as u32)].concat();
    let count = size / restart.len();
    let record = [restart.repeat(count), flight(&[size])].concat();
    let (found, cut_off, _) = read(&record);
    let (last, begins) = found.split_last().unwrap();
    assert_eq!((begins.len(), cut_off, last.unwrap().1), (count + 1, 0, AROUND + size));
    for (begin, skipped) in begins.iter().zip([0].into_iter().chain(std::iter::repeat(HEAD))) {
        assert!(matches!(begin, Ok((_, 20, 0, cut_off)) if *cut_off == skipped), "{begin:?}");
    }
    // Damage in the middle is told, also after so many restarts.
    let mut damaged = [restart.repeat(count), flight(&[90_000, 90_000, 90_000])].concat();
    let at = restart.len() * count + 20;
    damaged[at + 500] ^= 1;
    let (found, _, _) = read(&damaged);
    assert_eq!(found.last(), Some(&Err(Damage { at, flaw: Flaw::NoEntry(90_000 + AROUND) })));
}

#[test]
fn an_entry_beyond_four_gibibytes_ends_the_record() {
    let pixels = [7; 4];
    let frame = Frame::of_windows(&pixels, Rect::new(0, 0, 2, 2), (u16::MAX, u16::MAX)).unwrap();
    let largest = Rect::new(0, 0, u16::MAX, u16::MAX);
    // Only the parts in memory are written, so a large entry costs nothing here. 65,535^2 + 2 * 65,525 + 20 = 2^32 - 1.
    for (sweep, whole) in [
        (None, true),
        (Some(Rect::new(0, 0, 65_525, 2)), true),
        (Some(Rect::new(0, 0, 65_526, 2)), false),
        (Some(largest), false),
    ] {
        let mut bytes = vec![];
        let mut recorder = Recorder::resume(3, |chunk: &[u8]| {
            bytes.extend(chunk);
            Ok::<(), ()>(())
        });
        assert_eq!(recorder.window_of(&frame, Windows::new(largest, sweep)), Ok(()));
        assert_eq!((recorder.is_whole(), recorder.entries()), (whole, 3 + u32::from(whole)));
        assert_eq!(recorder.moved(1, 2), Ok(()));
        let length = 20 + u64::from(largest.area()) + sweep.map_or(0, |sweep| u64::from(sweep.area()));
        assert_eq!(
            bytes.get(8..HEAD).is_some_and(|said| u64::from(u32::from_le_bytes(said.try_into().unwrap())) == length),
            whole
        );
        assert_eq!(bytes.is_empty(), !whole, "nothing follows an entry that is missing");
    }
}
