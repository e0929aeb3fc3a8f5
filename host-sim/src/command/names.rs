//! Names of several recordings in one table, page or folder.

/// Appends a number to each name that an earlier recording has, so that all names differ: `a`, `a (2)`. Capital letters
/// make no difference, because in some systems two files differ in more.
pub fn apart(names: Vec<String>) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for name in names {
        let is_free = |name: &str| all.iter().all(|other| other.to_lowercase() != name.to_lowercase());
        let numbered = (2..).map(|number| format!("{name} ({number})"));
        let free = std::iter::once(name.clone()).chain(numbered).find(|name| is_free(name));
        all.extend(free);
    }
    all
}

#[cfg(test)]
mod tests {
    #[test]
    fn no_two_names_are_the_same() {
        let names = ["a", "b", "a", "a (2)", "A", "a"].map(str::to_owned).to_vec();
        assert_eq!(super::apart(names), ["a", "b", "a (2)", "a (2) (2)", "A (3)", "a (4)"]);
    }
}
