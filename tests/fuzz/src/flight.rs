//! Replays a flight record with changed entries and correct checksums. The replay stops at the first invalid entry and
//! at the first difference from the record.

use arbitrary::{Result, Unstructured};
use host_sim::replay::replay;
use smr_core::record::{self, AROUND, HEAD, Tag};
use std::sync::LazyLock;

type Entry = Vec<u8>;

/// Entries of the first flight in each tracker's test vectors.
static FLIGHTS: LazyLock<[Vec<Entry>; 3]> = LazyLock::new(|| {
    let records: [&[u8]; 3] = [
        include_bytes!("../../vectors/paper.smr"),
        include_bytes!("../../vectors/robust.smr"),
        include_bytes!("../../vectors/small.smr"),
    ];
    records.map(|record| {
        let mut all = entries(record);
        let next = all.iter().skip(1).position(|entry| entry[..4] == Tag::Begin.bytes());
        all.truncate(next.map_or(all.len(), |next| next + 1));
        all
    })
});

pub(crate) fn run(bytes: &[u8]) -> Result<()> {
    let u = &mut Unstructured::new(bytes);
    if u.ratio(1, 32)? {
        let record = u.bytes(u.len())?;
        let _ = replay(record, false, || ());
        let mut all = record::entries(record);
        all.by_ref().for_each(drop);
        assert!(all.work() <= 70 * record.len() as u64, "{} for {} bytes", all.work(), record.len());
        return Ok(());
    }
    let which = if u.ratio(1, 32)? { u.int_in_range(1..=2)? } else { 0 };
    let mut entries = FLIGHTS[which].clone();
    let changes = u.int_in_range(0..=4_u8)?;
    for _ in 0..changes {
        change(u, &mut entries)?;
    }
    if u.ratio(15, 16)? {
        number(&mut entries);
    }
    let mut record: Vec<u8> = entries.iter().flat_map(sealed).collect();
    let cut = u.ratio(1, 8)?;
    if cut {
        record.truncate(u.choose_index(record.len().max(1))?);
    }
    let logged = u.ratio(1, 16)?;
    let record = if logged { log(&record) } else { record };
    let report = replay(&record[..], false, || ());
    if changes == 0 && !cut {
        let report = report.expect("it is a record");
        assert_eq!((&report.difference, &report.damage, report.cut_off), (&None, &None, 0));
        assert!(report.flights.iter().all(|flight| flight.locks == 1 && flight.answers > 0));
    }
    Ok(())
}

fn entries(mut record: &[u8]) -> Vec<Entry> {
    let mut all = Vec::new();
    while let Some(length) = record.get(8..HEAD) {
        let length = u32::from_le_bytes(length.try_into().expect("four bytes")) as usize;
        let (entry, rest) = record.split_at(AROUND + length);
        all.push(entry[..HEAD + length].to_vec());
        record = rest;
    }
    all
}

/// Encodes an entry with its true length and a correct checksum.
fn sealed(entry: &Entry) -> Vec<u8> {
    let mut bytes = entry.clone();
    let holds = u32::try_from(entry.len() - HEAD).expect("it is small");
    bytes[8..HEAD].copy_from_slice(&holds.to_le_bytes());
    let sum = crc32fast::hash(&bytes);
    bytes.extend(sum.to_le_bytes());
    bytes
}

/// Changes the kind, a number, the length or bytes of an entry, or moves, repeats or removes it.
fn change(u: &mut Unstructured<'_>, entries: &mut Vec<Entry>) -> Result<()> {
    if entries.is_empty() {
        return Ok(());
    }
    let which = u.choose_index(entries.len())?;
    let kind = u.int_in_range(0..=9_u8)?;
    let Some(entry) = entries.get_mut(which) else { return Ok(()) };
    match kind {
        0 => drop(entries.remove(which)),
        1 => entries.insert(which, entries[which].clone()),
        2 => entries.swap(which, 0),
        3 => entry[..4].copy_from_slice(&u.choose(&Tag::ALL)?.bytes()),
        4 => entry[4..8].copy_from_slice(&u.arbitrary::<u32>()?.to_le_bytes()),
        5 => entry.truncate(HEAD + u.choose_index(entry.len() - HEAD + 1)?),
        6 => entry.extend_from_slice(u.bytes(u.len().min(9))?),
        // Changes mostly the numbers before the pixels.
        _ => {
            let end = if u.ratio(3, 4)? { entry.len().min(HEAD + 40) } else { entry.len() };
            let at = HEAD + u.choose_index((end - HEAD).max(1))?;
            let any = u.arbitrary()?;
            let bytes: [u8; 2] = *u.choose(&[[0, 0], [255, 255], any])?;
            entry.iter_mut().skip(at).zip(bytes).for_each(|(old, new)| *old = new);
        }
    }
    Ok(())
}

/// Numbers the entries anew, from 0 at each `Begin`.
fn number(entries: &mut [Entry]) {
    let mut number = 0_u32;
    for entry in entries {
        if entry[..4] == Tag::Begin.bytes() {
            number = 0;
        }
        entry[4..8].copy_from_slice(&number.to_le_bytes());
        number += 1;
    }
}

fn log(record: &[u8]) -> Vec<u8> {
    let line = |bytes: &[u8]| {
        let numbers: Vec<_> = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        format!("INFO smr-record [{}]\n", numbers.join(", "))
    };
    record.chunks(64).map(line).collect::<String>().into_bytes()
}
