//! Sorts images by their names: numbers compare by value, also decimal ones such as time stamps.

use std::cmp::Ordering;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Sorts `img2` before `img10`. Decimal numbers of one series (`Decimal::are_one_series`) sort by value: `1.25`, `1.5`.
pub(crate) fn sort(files: &mut [PathBuf]) {
    let decimals: Option<Vec<_>> = files.iter().map(|file| Decimal::of(&stem(file))).collect();
    let are_decimals = decimals.is_some_and(|all| Decimal::are_one_series(&all));
    // Names that differ only in white space are equal in natural order: their paths decide, not the order on disk.
    files.sort_by(|a, b| {
        let (first, second) = (stem(a), stem(b));
        let decimals = Decimal::of(&first).zip(Decimal::of(&second)).filter(|_| are_decimals);
        let by_number = decimals.map_or(Ordering::Equal, |(first, second)| first.cmp(&second));
        by_number.then_with(|| natord::compare(&a.to_string_lossy(), &b.to_string_lossy())).then_with(|| a.cmp(b))
    });
}

pub(crate) fn has_extension(file: &Path, extensions: &[&str]) -> bool {
    let extension = file.extension().and_then(|extension| extension.to_str());
    extension.is_some_and(|extension| extensions.iter().any(|known| known.eq_ignore_ascii_case(extension)))
}

fn stem(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// A name that ends in a decimal number. The derived order compares fields in turn, exact for numbers of any length.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Decimal {
    /// Digits before the point, without leading zeros: their count, then the digits.
    whole: (usize, String),
    /// Digits behind the point, without trailing zeros.
    fraction: String,
    has_zero_at_the_end: bool,
    prefix: String,
}

impl Decimal {
    fn of(stem: &str) -> Option<Self> {
        let split = |text: &str| {
            let before = text.trim_end_matches(|letter: char| letter.is_ascii_digit()).len();
            (text[..before].to_owned(), text[before..].to_owned())
        };
        let (before, digits) = split(stem);
        let with_point = before.strip_suffix(['.', ',']).map(split).filter(|(_, whole)| !whole.is_empty());
        let (prefix, whole, fraction) = match with_point {
            Some((prefix, whole)) => (prefix, whole, digits),
            None => (before, digits, String::new()),
        };
        let whole = Some(whole).filter(|whole| !whole.is_empty())?.trim_start_matches('0').to_owned();
        Some(Self {
            whole: (whole.len(), whole),
            has_zero_at_the_end: fraction.len() > 1 && fraction.ends_with('0'),
            fraction: fraction.trim_end_matches('0').to_owned(),
            prefix,
        })
    }

    /// True if all names have the same prefix. After a prefix, no fraction of two or more digits may end in 0: `a1.10`
    /// is taken for a counter, not a decimal number.
    fn are_one_series(all: &[Self]) -> bool {
        let prefix = all.first().map(|first| &first.prefix);
        all.iter().all(|one| Some(&one.prefix) == prefix && (one.prefix.is_empty() || !one.has_zero_at_the_end))
    }
}

/// Finds two images with one number, such as `7.png` and `7_mask.png`, which cannot both be frames of a recording.
pub(crate) fn twins(files: &[PathBuf]) -> Option<[&Path; 2]> {
    let mut of_numbers = HashMap::new();
    files.iter().find_map(|file| {
        let stem = stem(file);
        let is_digit = |letter: char| letter.is_ascii_digit();
        let numbers = stem.split(|letter| !is_digit(letter)).filter(|number| !number.is_empty());
        let numbers: Vec<String> = numbers.map(|number| number.trim_start_matches('0').to_owned()).collect();
        let letters: Vec<String> = stem.split(is_digit).filter(|part| !part.is_empty()).map(str::to_owned).collect();
        let (other, other_letters) = of_numbers.entry(numbers.clone()).or_insert_with(|| (file, letters.clone()));
        (!numbers.is_empty() && *other_letters != letters).then_some([other.as_path(), file.as_path()])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_in_their_order() {
        for names in [
            &["img1.png", "img2.png", "img10.png"][..],
            &["1712345678.png", "1712345678.0625.png", "1712345678.125.png", "1712345678.5.png", "1712345679.0.png"],
            &["0.5.png", "1.png", "9.25.png", "9.5.png", "10.png", "1712345678123456789.1.png"],
            &["t0.5.jpg", "t1.25.jpg", "t1.5.jpg", "t10.0.jpg"],
            &["1712345678.123456788.png", "1712345678.123456789.png", "1712345678.2.png"],
            &["shot1.9.png", "shot1.10.png", "shot2.1.png"],
            &["2024-01-05_12.30.59.png", "2024-01-05_12.31.1.png"],
            &["1.9.png", "1.90.png", "1.95.png"],
            &["1712345678,25.png", "1712345678,5.png"],
        ] {
            let files: Vec<PathBuf> = names.iter().map(PathBuf::from).collect();
            let mut sorted: Vec<PathBuf> = files.iter().rev().cloned().collect();
            sort(&mut sorted);
            assert_eq!(sorted, files);
        }
    }

    #[test]
    fn two_images_of_one_number() {
        let has = |names: &[&str]| twins(&names.iter().map(PathBuf::from).collect::<Vec<_>>()).is_some();
        assert!(has(&["1.png", "2.png", "2_mask.png"]) && has(&["left_007.png", "right_07.png"]));
        for names in [
            &["a.png", "b.png"][..],
            &["img1.png", "img01.png", "img2.PNG"],
            &["1712345678.png", "1712345678.5.png", "1712345678.25.png"],
            &["IMG_1.jpg", "IMG_1(1).jpg", "title.jpg"],
        ] {
            assert!(!has(names), "{names:?}");
        }
    }
}
