//! The modules of the front end, from core/web/page, for the pages of host-sim.
//!
//! `view` serves each module under its own address ([`module`]). A page that is one file carries them all in an import map
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
    "detail.js"
    "dom.js"
    "download.js"
    "drag.js"
    "edits.js"
    "events.js"
    "exports.js"
    "figures.js"
    "graph.js"
    "history.js"
    "list.js"
    "methods.js"
    "palette.js"
    "playback.js"
    "preview.js"
    "rows.js"
    "timeline.js"
    "tracker-settings.js"
    "trail.js"
    "view.js"
    "viewport.js"
    "window-pictures.js"
    "window-stage.js"
    "window.js"
}

const WINDOW: &str = include_str!(concat!(env!("SMR_FRONT_END"), "/window.html"));
const STYLES: [&str; 3] = [
    include_str!("report/base.css"),
    include_str!(concat!(env!("SMR_FRONT_END"), "/page.css")),
    include_str!(concat!(env!("SMR_FRONT_END"), "/window.css")),
];

/// The page of the window, which ends with these elements.
pub fn window(scripts: &str) -> String {
    WINDOW.replace("{{style}}", &STYLES.concat()).replace("{{scripts}}", scripts)
}

/// The text of the module with this file name.
pub fn module(name: &str) -> Option<&'static str> {
    MODULES.iter().find(|(module, _)| *module == name).map(|(_, text)| *text)
}

/// The element `<script type="importmap">` for a page that is one file. Modules import one another by `./NAME.js`, which has no
/// meaning in a page without an address, so each gets the name `smr/NAME.js`.
pub fn import_map() -> String {
    let mut map = String::from("<script type=\"importmap\">{\"imports\":{");
    for (index, (name, text)) in MODULES.iter().enumerate() {
        let comma = if index == 0 { "" } else { "," };
        let text = base64(text.replace("from \"./", "from \"smr/").as_bytes());
        let _ = write!(map, "{comma}\"smr/{name}\":\"data:text/javascript;base64,{text}\"");
    }
    map + "}}</script>"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_module_imports_is_there() {
        for (name, text) in MODULES {
            for import in text.lines().filter_map(|line| line.split_once("from \"")?.1.split('"').next()) {
                let found = import.strip_prefix("./").and_then(module);
                assert!(found.is_some(), "{name} imports {import}: expected a module of the list in front_end.rs");
            }
        }
        assert!(import_map().contains("\"smr/dom.js\":\"data:text/javascript;base64,"));
    }
}
