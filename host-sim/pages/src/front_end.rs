//! The modules of the front end, from core/web/page, for the pages of host-sim.
//!
//! `view` serves each module under its own address ([`module`]). A page that is one file carries those that it needs in an import map
//! ([`import_map`]) and begins with `import "smr/NAME.js"`.

use crate::encode::base64;
use std::fmt::Write;

macro_rules! modules {
    ($($name:literal)*) => {
        /// File name and text of each.
        pub const MODULES: &[(&str, &str)] = &[$(($name, include_str!(concat!(env!("SMR_FRONT_END"), "/", $name)))),*];
    };
}

modules! {
    "answers.js"
    "application.js"
    "command-lines.js"
    "command.js"
    "connection.js"
    "cost.js"
    "curves.js"
    "detail.js"
    "dom.js"
    "download.js"
    "drag.js"
    "edits.js"
    "events.js"
    "exports.js"
    "figures.js"
    "graph.js"
    "legend.js"
    "list.js"
    "methods.js"
    "palette.js"
    "playback.js"
    "preview.js"
    "report-compared.js"
    "report-tables.js"
    "report.js"
    "stage.js"
    "timeline.js"
    "tracker-settings.js"
    "trail.js"
    "viewport.js"
    "window-pictures.js"
    "window.js"
}

const WINDOW: &str = include_str!(concat!(env!("SMR_FRONT_END"), "/window.html"));
/// Explanations of the words on pages, for a list.
pub const WORDS: &str = include_str!(concat!(env!("SMR_FRONT_END"), "/words.html"));
/// The style of every page.
pub const STYLES: [&str; 2] =
    [include_str!("report/base.css"), include_str!(concat!(env!("SMR_FRONT_END"), "/page.css"))];
const WINDOW_STYLE: &str = include_str!(concat!(env!("SMR_FRONT_END"), "/window.css"));

/// The page of the window, which ends with these elements.
pub fn window(scripts: &str) -> String {
    WINDOW.replace("{{style}}", &(STYLES.concat() + WINDOW_STYLE)).replace("{{scripts}}", scripts)
}

/// The text of the module with this file name.
pub fn module(name: &str) -> Option<&'static str> {
    MODULES.iter().find(|(module, _)| *module == name).map(|(_, text)| *text)
}

fn imports(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter_map(|line| line.split_once("from \"./")?.1.split('"').next())
}

/// The element `<script type="importmap">` for a page that is one file and begins with the module `first`. Modules import one another by
/// `./NAME.js`, which has no meaning in a page without an address, so each gets the name `smr/NAME.js`.
pub fn import_map(first: &str) -> String {
    let mut needed = vec![first];
    let mut map = String::from("<script type=\"importmap\">{\"imports\":{");
    let mut index = 0;
    while let Some(&name) = needed.get(index) {
        let text = module(name).unwrap_or_default();
        needed.extend(imports(text).filter(|other| !needed.contains(other)).collect::<Vec<_>>());
        let comma = if index == 0 { "" } else { "," };
        let text = base64(text.replace("from \"./", "from \"smr/").as_bytes());
        let _ = write!(map, "{comma}\"smr/{name}\":\"data:text/javascript;base64,{text}\"");
        index += 1;
    }
    map + "}}</script>"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_module_imports_is_there() {
        for (name, text) in MODULES {
            assert_eq!(text.matches("from \"").count(), imports(text).count(), "{name}");
            for import in imports(text) {
                assert!(
                    module(import).is_some(),
                    "{name} imports {import}: expected a module of the list in front_end.rs"
                );
            }
        }
        let map = import_map("report.js");
        assert!(map.contains("\"smr/dom.js\":\"data:text/javascript;base64,") && !map.contains("smr/window.js"));
        assert_eq!(map.matches("\"smr/").count(), map.matches("data:").count(), "each once");
    }
}
