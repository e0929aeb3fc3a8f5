//! Names of several recordings in one table, page or folder.

use std::collections::{HashMap, HashSet};

/// Appends a number to each name that an earlier recording has, so that all names differ: `a`, `a (2)`. Capital letters
/// make no difference, because in some systems two files differ in more.
pub fn apart(names: Vec<String>) -> Vec<String> {
    let mut taken = HashSet::new();
    // The first number of each name that was not tried.
    let mut untried: HashMap<String, usize> = HashMap::new();
    let free = |name: String| {
        let number = untried.entry(name.to_lowercase()).or_insert(1);
        loop {
            let numbered = if *number == 1 { name.clone() } else { format!("{name} ({number})") };
            *number += 1;
            if taken.insert(numbered.to_lowercase()) {
                return numbered;
            }
        }
    };
    names.into_iter().map(free).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn no_two_names_are_the_same() {
        let names = ["a", "b", "a", "a (2)", "A", "a"].map(str::to_owned).to_vec();
        assert_eq!(super::apart(names), ["a", "b", "a (2)", "a (2) (2)", "A (3)", "a (4)"]);
        // More names would take minutes if each were compared with all others.
        let many = super::apart(vec!["a".to_owned(); 20_000]);
        assert_eq!(many.last().unwrap(), "a (20000)");
    }
}
