/// Breaks `text` into lines of at most `width` characters, each with the prefix `before`.
#[must_use]
pub fn wrapped(text: &str, before: &str, width: usize) -> String {
    let (mut lines, mut line) = (String::new(), String::new());
    for word in text.split(' ') {
        if before.len() + line.len() + word.len() > width {
            lines += &format!("{before}{}\n", line.trim_end());
            line.clear();
        }
        line += word;
        line.push(' ');
    }
    lines + &format!("{before}{}\n", line.trim_end())
}
