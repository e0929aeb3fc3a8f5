//! HTML, CSS and JavaScript of the front end (core/web/page), embedded in the program. `build.rs` lists the modules.
//!
//! `host-sim view` serves each module at its own address ([`module`]). The report is a single HTML file: it contains
//! its modules in an import map ([`import_map`]) and begins with `import "smr/report.js"`.

use crate::encode::base64;

/// JavaScript modules as (file name, text): index 0 for the viewer (page of `host-sim view`), index 1 for the report.
const MODULES: [&[(&str, &str)]; 2] = include!(concat!(env!("OUT_DIR"), "/modules.rs"));
const VIEWER: &str = include_str!(concat!(env!("SMR_FRONT_END"), "/viewer.html"));
/// A glossary of the terms on the pages, as the items of an HTML list.
pub const WORDS: &str = include_str!(concat!(env!("SMR_FRONT_END"), "/words.html"));
pub const STYLES: [&str; 3] = [
    include_str!(concat!(env!("SMR_FRONT_END"), "/colors.css")),
    include_str!("report/base.css"),
    include_str!(concat!(env!("SMR_FRONT_END"), "/page.css")),
];
const VIEWER_STYLE: &str = include_str!(concat!(env!("SMR_FRONT_END"), "/viewer.css"));

/// Returns the HTML page of `host-sim view`, with `scripts` as its last elements.
pub fn viewer(scripts: &str) -> String {
    let style = STYLES.concat() + VIEWER_STYLE;
    VIEWER.replace("{{style}}", &style).replace("{{words}}", WORDS).replace("{{scripts}}", scripts)
}

pub fn module(name: &str) -> Option<&'static str> {
    MODULES[0].iter().find(|(module, _)| *module == name).map(|(_, text)| *text)
}

/// Returns the report's `<script type="importmap">`: a single file has no `./NAME.js`, so modules import `smr/NAME.js`.
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
        assert!(map.contains("\"smr/dom.js\":\"data:text/javascript;base64,") && !map.contains("smr/viewer.js"));
        assert_eq!(map.matches("\"smr/").count(), map.matches("data:").count());
    }
}
