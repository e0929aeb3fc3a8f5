//! The orientation of a picture as its Exif data state it: a TIFF header, and tag 0x112 in the first directory.

/// 1 (upright) to 8; 1 if the data do not say.
pub(super) fn orientation(exif: &[u8]) -> u8 {
    let stated = stated(exif).and_then(|stated| u8::try_from(stated).ok());
    stated.filter(|stated| (1..=8).contains(stated)).unwrap_or(1)
}

fn stated(exif: &[u8]) -> Option<u32> {
    // In PNG some writers put the head of JPEG's segment before them.
    let exif = exif.strip_prefix(HEAD).unwrap_or(exif);
    let is_little_endian = match exif.get(..2)? {
        b"II" => true,
        b"MM" => false,
        _ => return None,
    };
    let number = |at: usize, length: usize| {
        let join = |number: u32, &byte: &u8| number << 8 | u32::from(byte);
        let field = exif.get(at..)?.get(..length)?.iter();
        Some(if is_little_endian { field.rev().fold(0, join) } else { field.fold(0, join) })
    };
    let directory = usize::try_from(number(4, 4)?).ok()?;
    let entries = (0..number(directory, 2)? as usize).map(|entry| directory.saturating_add(2 + 12 * entry));
    let entry = entries.into_iter().find(|&entry| number(entry, 2) == Some(0x112))?;
    // A SHORT fills half of the four bytes of a value, a LONG all of them.
    number(entry + 8, if number(entry + 2, 2)? == 4 { 4 } else { 2 })
}

/// The first bytes of Exif data in JPEG.
pub(super) const HEAD: &[u8] = b"Exif\0\0";

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Exif data with another tag before the orientation.
    pub fn exif(is_little_endian: bool, orientation: u16) -> Vec<u8> {
        let short = |number: u16| if is_little_endian { number.to_le_bytes() } else { number.to_be_bytes() };
        let long = |number: u32| if is_little_endian { number.to_le_bytes() } else { number.to_be_bytes() };
        let entry = |tag, value| [&short(tag)[..], &short(3), &long(1), &short(value), &[0; 2]].concat();
        let head = [if is_little_endian { b"II" } else { b"MM" }, &short(42)[..], &long(8), &short(2)].concat();
        [head, entry(0x100, 7), entry(0x112, orientation), vec![0; 4]].concat()
    }

    #[test]
    fn both_orders_of_bytes_and_data_that_end_anywhere() {
        for is_little_endian in [true, false] {
            for (stated, expected) in [(1, 1), (6, 6), (8, 8), (0, 1), (9, 1), (262, 1)] {
                let whole = exif(is_little_endian, stated);
                assert_eq!(orientation(&whole), expected);
                assert_eq!(orientation(&[HEAD, &whole].concat()), expected);
                (0..whole.len()).for_each(|length| assert!((1..=8).contains(&orientation(&whole[..length]))));
            }
        }
        assert_eq!(orientation(b"MM\0*\xFF\xFF\xFF\xFF"), 1);
    }
}
