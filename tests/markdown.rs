//! Finds code and links in documents. The build script and the test programs that check documents include this file.

#![allow(dead_code, reason = "no program needs all of it")]

/// Returns the text of each fenced block whose first line is "```" and `language`, whatever follows.
pub fn blocks(text: &str, language: &str) -> Vec<String> {
    let mut blocks: Vec<String> = Vec::new();
    let (mut is_block, mut is_wanted) = (false, false);
    for line in text.lines() {
        if let Some(info) = line.strip_prefix("```") {
            is_block = !is_block;
            is_wanted = is_block && info.split(',').next() == Some(language);
            if is_wanted {
                blocks.push(String::new());
            }
        } else if is_wanted && let Some(block) = blocks.last_mut() {
            block.push_str(line);
            block.push('\n');
        }
    }
    blocks
}

/// Returns the lines of a block of commands without comments.
pub fn commands(block: &str) -> impl Iterator<Item = &str> {
    block.lines().map(|line| line.split(" #").next().unwrap_or(line).trim()).filter(|line| !line.is_empty())
}

/// Returns each line of code, fenced or indented, and each piece of code in a sentence.
pub fn code(text: &str) -> impl Iterator<Item = &str> {
    let mut is_block = false;
    text.lines().flat_map(move |line| {
        is_block ^= line.starts_with("```");
        let whole = (is_block || line.starts_with("    ")).then_some(line);
        line.split('`').skip(1).step_by(2).chain(whole)
    })
}

/// Returns the target of each link and image.
pub fn links(text: &str) -> impl Iterator<Item = &str> {
    let inline = text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(link, _)| link);
    let named = text.lines().filter(|line| line.starts_with('[')).filter_map(|line| Some(line.split_once("]: ")?.1));
    inline.chain(named)
}
