//! The modules of the front end, from core/web/page, for the pages of host-sim. `build.rs` finds those that each page imports.
//!
//! `view` serves each module under its own address ([`module`]). A page that is one file carries those that it needs in an import map
//! ([`import_map`]) and begins with `import "smr/report.js"`.

use crate::encode::base64;

/// File name and text of the modules of the window, and of the report.
const MODULES: [&[(&str, &str)]; 2] = include!(concat!(env!("OUT_DIR"), "/modules.rs"));
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

/// The text of the window's module with this file name.
pub fn module(name: &str) -> Option<&'static str> {
    MODULES[0].iter().find(|(module, _)| *module == name).map(|(_, text)| *text)
}

/// The element `<script type="importmap">` for the report, which is one file and begins with its module. Modules import one another by
/// `./NAME.js`, which has no meaning in a page without an address, so each gets the name `smr/NAME.js`.
pub fn import_map() -> String {
    let module = |(name, text): &(&str, &str)| {
        let text = base64(text.replace("from \"./", "from \"smr/").as_bytes());
        format!("\"smr/{name}\":\"data:text/javascript;base64,{text}\"")
    };
    let map: Vec<_> = MODULES[1].iter().map(module).collect();
    format!("<script type=\"importmap\">{{\"imports\":{{{}}}}}</script>", map.join(","))
}

#[cfg(test)]
mod tests {
    #[test]
    fn each_import_of_a_module_is_found_once() {
        for (name, text) in super::MODULES.concat() {
            assert_eq!(text.matches("from \"").count(), text.matches("from \"./").count(), "{name}");
        }
        let map = super::import_map();
        assert!(map.contains("\"smr/dom.js\":\"data:text/javascript;base64,") && !map.contains("smr/window.js"));
        assert_eq!(map.matches("\"smr/").count(), map.matches("data:").count());
    }
}
