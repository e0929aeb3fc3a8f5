//! Compares the lists of settings in the stubs and READMEs with the settings of smr-core.
//!
//! Write them with `SMR_RECORD=1 cargo test -p smr-api`.

use smr_core::{Setting, Settings, Shape, paper, robust};
use std::path::Path;

/// Asserts that the text between `start` and `end` in the file is `now`; if `SMR_RECORD` is set, writes `now` there.
fn is_recorded(file: &str, start: &str, end: &str, now: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(file);
    let text = std::fs::read_to_string(&path).expect("the file is there");
    let from = text.find(start).unwrap_or_else(|| panic!("{file}: no {start}")) + start.len();
    let to = from + text[from..].find(end).unwrap_or_else(|| panic!("{file}: no {end} after {start}"));
    if std::env::var_os("SMR_RECORD").is_some() {
        std::fs::write(&path, format!("{}{now}{}", &text[..from], &text[to..])).expect("the file can be written");
    } else {
        assert_eq!(&text[from..to], now, "{file}: SMR_RECORD=1 cargo test -p smr-api");
    }
}

/// Returns one line for each setting: `line` gets the setting, its text and its range in words.
fn lines<C: Settings>(line: impl Fn(&Setting, &str, &str) -> String) -> String {
    let line = |(setting, text): (&Setting, &&str)| {
        let range = match setting.shape {
            Shape::Switch => String::new(),
            _ => format!("{} to {}", setting.lowest, setting.highest),
        };
        line(setting, text, &range)
    };
    C::SETTINGS.iter().zip(C::TEXTS).map(line).collect()
}

fn camel(name: &str) -> String {
    let mut words = name.split('_');
    let first = words.next().unwrap_or_default().to_owned();
    words.fold(first, |all, word| all + &word[..1].to_uppercase() + &word[1..])
}

#[test]
fn the_types_of_javascript_have_the_settings() {
    fn options<C: Settings>() -> String {
        lines::<C>(|setting, text, range| {
            let kind = match setting.shape {
                Shape::Number => "number",
                Shape::Switch => "boolean",
                Shape::Fraction | Shape::Radius => "Pair",
                Shape::Margins => "[number, number, number, number]",
            };
            let range = if range.is_empty() { String::new() } else { format!(" {range}.") };
            format!("  /** {text}{range} */\n  {}?: {kind};\n", camel(setting.name()))
        })
    }
    let file = "core/web/smr.d.ts";
    is_recorded(file, "  preset?: \"camera\" | \"paper\";\n", "  plainLoop?", &options::<paper::Config>());
    let preset = "  preset?: \"refined\" | \"robust\" | \"small\" | \"smallRefined\";\n";
    is_recorded(file, preset, "  plainLoop?", &options::<robust::Config>());
}

#[test]
fn the_stubs_of_python_have_the_settings() {
    fn options<C: Settings>() -> String {
        lines::<C>(|setting, _, _| {
            let kind = match setting.shape {
                Shape::Number => "int",
                Shape::Switch => "bool",
                Shape::Fraction | Shape::Radius => "_Pair",
                Shape::Margins => "tuple[int, int, int, int]",
            };
            format!("        {}: {kind} = ...,\n", setting.name())
        })
    }
    let file = "core/python/package/smr/_smr.pyi";
    is_recorded(file, "] = \"camera\",\n        *,\n", "    )", &options::<paper::Config>());
    is_recorded(file, "] = \"refined\",\n        *,\n", "    )", &options::<robust::Config>());
}

#[test]
fn the_readme_has_the_settings() {
    fn table<C: Settings + Default>(config: &str) -> String {
        let rows = lines::<C>(|setting, text, range| {
            let values = C::default().get(setting.name()).unwrap_or_default().map(|value| value.to_string());
            let separator = if setting.shape == Shape::Fraction { " / " } else { ", " };
            let values = values[..setting.shape.count()].join(separator);
            let range = if range.is_empty() { "0 or 1" } else { range };
            format!("| `{}` | {range} | {values} | {text} |\n", setting.name())
        });
        format!("| `{config}` | range | value | |\n|---|---|---|---|\n{rows}\n")
    }
    let tables = table::<paper::Config>("paper::Config") + &table::<robust::Config>("robust::Config");
    is_recorded("core/README.md", "`reach is 4 to 8, not 100`.\n\n", "## Pan and tilt", &tables);
}
