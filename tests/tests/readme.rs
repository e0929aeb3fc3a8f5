//! The project's README can be read in five minutes.

#[test]
fn the_readme_has_at_most_900_words() {
    // The same count as `wc -w`.
    let words = include_str!("../../README.md").split_whitespace().count();
    assert!(words <= 900, "README.md has {words} words");
}
