//! Text as HTML and SVG can hold it.

/// `text` with the characters replaced that would end it or begin a tag.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
