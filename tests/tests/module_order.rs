//! Checks by the `use` declarations and paths of the sources that smr-core keeps the order of modules that
//! CONTRIBUTING.md states, and that no files of a crate, and none of the pages, import each other in a circle.
//!
//! A path leads to the file that defines its first name below the modules, through `pub use`. A `pub use` does not count
//! as an import of its file, and files of tests are left out.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The modules of smr-core: a file imports from its own module and from those before it.
const ORDER: &[&str] = &[
    "error_enums",
    "image",
    "kernels",
    "similarity",
    "track",
    "track/paper",
    "track/robust",
    "track/robust/features",
    "track/robust/filter",
    "track/robust/verification",
    "track/robust/refiner",
    "track/robust/decision",
    "track/robust/run",
    "track/robust/target",
    "pursuit",
    "unstable",
    "error",
    "",
];

const CRATES: [&str; 10] = [
    "core",
    "core/c",
    "core/python",
    "host-sim",
    "host-sim/files",
    "host-sim/scene",
    "host-sim/recordings",
    "host-sim/reference",
    "host-sim/evaluation",
    "host-sim/pages",
];

/// The names of files, and for each the names of those it imports. The name of `a/mod.rs` is `a`, of `lib.rs` empty.
type Imports = BTreeMap<String, BTreeSet<String>>;

/// The paths that a file imports, and those that it passes on, without the name `as` something.
struct Source {
    imports: Vec<String>,
    exports: Vec<String>,
}

impl Source {
    fn new(text: &str) -> Self {
        let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
        let code: String =
            text.lines().map(|line| line.split("//").next().unwrap_or_default().to_owned() + "\n").collect();
        let (mut imports, mut exports, mut rest) = (Vec::new(), Vec::new(), String::new());
        for statement in code.split_inclusive(';') {
            // Declarations inside of functions are indented, and their paths are found below.
            let declaration = statement.split_once("\nuse ").map(|(before, tree)| (before, tree, &mut imports));
            let passed_on = ["\npub use ", "\npub(crate) use ", "\npub(super) use "];
            let passed_on = passed_on.iter().find_map(|words| statement.split_once(words));
            match declaration.or(passed_on.map(|(before, tree)| (before, tree, &mut exports))) {
                Some((before, tree, paths)) => {
                    rest += before;
                    expand("", tree.trim_end_matches(';'), paths);
                }
                None => rest += statement,
            }
        }
        let words = rest.split(|c: char| !c.is_alphanumeric() && c != '_' && c != ':');
        imports.extend(
            words.filter(|word| ["crate::", "super::"].iter().any(|to| word.starts_with(to))).map(str::to_owned),
        );
        Self { imports, exports }
    }
}

/// Writes a `use` tree as single paths.
fn expand(before: &str, tree: &str, paths: &mut Vec<String>) {
    let tree = tree.trim();
    let Some((head, list)) = tree.split_once('{') else {
        let path = tree.split(" as ").next().unwrap_or_default().trim_end_matches("::self");
        paths.extend((!path.is_empty()).then(|| format!("{before}{path}")));
        return;
    };
    let list = list.strip_suffix('}').unwrap_or(list).to_owned() + ",";
    let (mut depth, mut start) = (0, 0);
    for (at, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                expand(&format!("{before}{head}"), &list[start..at], paths);
                start = at + 1;
            }
            _ => {}
        }
    }
}

fn project() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The files below `folder` with this extension, by their names.
fn files(folder: &Path, extension: &str) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(&next).unwrap_or_else(|error| panic!("{}: {error}", next.display())) {
            let path = entry.expect("an entry of a folder").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|of| of == extension) {
                let name = path.strip_prefix(folder).expect("a file of the folder").with_extension("");
                let name = name.to_str().expect("a name in UTF-8").replace('\\', "/");
                let name = name.strip_suffix("/mod").unwrap_or(if name == "lib" { "" } else { &name }).to_owned();
                found.insert(name, fs::read_to_string(&path).expect("a text"));
            }
        }
    }
    found
}

/// `path` from the crate's root, with `/` between names, if it begins with `crate`, `super`, `self` or a child of `file`.
fn from_root(sources: &BTreeMap<String, Source>, file: &str, path: &str) -> Option<String> {
    let mut names: Vec<&str> = file.split('/').filter(|name| !name.is_empty()).collect();
    let child = [file, path.split("::").next()?].join("/");
    let mut is_ours = sources.contains_key(child.trim_start_matches('/'));
    for name in path.split("::").filter(|name| !name.is_empty()) {
        match name {
            "crate" => names.clear(),
            "super" => _ = names.pop(),
            "self" => {}
            name => {
                names.push(name);
                continue;
            }
        }
        is_ours = true;
    }
    is_ours.then(|| names.join("/"))
}

/// The file that defines what stands at `path`, a path from the root.
fn defining(sources: &BTreeMap<String, Source>, path: &str) -> String {
    let mut ends = path.match_indices('/').map(|(at, _)| at).chain([path.len()]).rev();
    let module = ends.find_map(|end| sources.get_key_value(&path[..end])).or_else(|| sources.get_key_value(""));
    let (module, source) = module.expect("a crate has a root");
    let mut rest = path[module.len()..].trim_start_matches('/').splitn(2, '/');
    let name = rest.next().unwrap_or_default();
    let passed_on = source.exports.iter().find(|path| !name.is_empty() && path.rsplit("::").next() == Some(name));
    let Some(target) = passed_on.and_then(|path| from_root(sources, module, path)) else { return module.clone() };
    if target == path {
        return module.clone();
    }
    defining(sources, &rest.next().map_or(target.clone(), |rest| format!("{target}/{rest}")))
}

fn is_of_tests(name: &str) -> bool {
    name.split('/').any(|part| part == "tests")
}

fn imports_of_crate(folder: &str) -> Imports {
    let files = files(&project().join(folder).join("src"), "rs");
    let sources: BTreeMap<String, Source> =
        files.iter().map(|(name, text)| (name.clone(), Source::new(text))).collect();
    let imports_of = |name: &String| {
        let paths = sources[name].imports.iter().filter_map(|path| from_root(&sources, name, path));
        paths.map(|path| defining(&sources, &path)).filter(|other| other != name).collect()
    };
    sources.keys().filter(|name| !is_of_tests(name)).map(|name| (name.clone(), imports_of(name))).collect()
}

fn imports_of_pages() -> Imports {
    let files = files(&project().join("core/web/page"), "js");
    let imports_of = |text: &String| {
        let paths = text.split("from \"./").skip(1).filter_map(|rest| rest.split_once(".js\""));
        paths.map(|(name, _)| name.to_owned()).collect()
    };
    files.iter().map(|(name, text)| (name.clone(), imports_of(text))).collect()
}

fn reached<'a>(imports: &'a Imports, from: &str) -> BTreeSet<&'a str> {
    let mut reached = BTreeSet::new();
    let mut next: Vec<&str> = imports.get(from).into_iter().flatten().map(String::as_str).collect();
    while let Some(name) = next.pop() {
        if reached.insert(name) {
            next.extend(imports.get(name).into_iter().flatten().map(String::as_str));
        }
    }
    reached
}

/// The sets of files of which each reaches all others by imports.
fn circles(imports: &Imports) -> BTreeSet<Vec<&str>> {
    let reach: BTreeMap<&str, BTreeSet<&str>> =
        imports.keys().map(|name| (name.as_str(), reached(imports, name))).collect();
    let meets = |name: &str, other: &str| reach.get(other).is_some_and(|reached| reached.contains(name));
    let circle = |name: &str| reach[name].iter().copied().filter(|other| meets(name, other)).collect::<Vec<_>>();
    imports.keys().map(|name| circle(name)).filter(|circle| !circle.is_empty()).collect()
}

#[test]
fn a_circle_is_found() {
    let imports_of = |names: &str| names.chars().map(String::from).collect();
    let imports = [("a", "b"), ("b", "c"), ("c", "bd"), ("d", "")];
    let imports: Imports = imports.map(|(name, names)| (name.to_owned(), imports_of(names))).into();
    assert_eq!(circles(&imports), BTreeSet::from([vec!["b", "c"]]));
    let source = Source::new("//! A head.\n\nuse super::other::{self, Name};\npub use crate::third::Name;\n");
    assert_eq!((source.imports.len(), source.exports.len()), (2, 1), "{:?} {:?}", source.imports, source.exports);
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    for folder in CRATES {
        let imports = imports_of_crate(folder);
        assert!(imports.values().any(|imports| !imports.is_empty()) || imports.len() < 3, "{folder}: no imports found");
        assert_eq!(circles(&imports), BTreeSet::new(), "{folder}: these import each other");
    }
    assert_eq!(circles(&imports_of_pages()), BTreeSet::new(), "core/web/page");
}

#[test]
fn smr_core_keeps_the_order_of_its_modules() {
    let rank = |name: &str| {
        let is_within =
            |module: &&str| name.strip_prefix(module).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'));
        let module = ORDER.iter().filter(|module| is_within(module)).max_by_key(|module| module.len());
        let module = module.unwrap_or_else(|| panic!("core/src/{name}: a module without a place in `ORDER`"));
        ORDER.iter().position(|other| other == module)
    };
    let apart = |name: &str, other: &str| name.starts_with("track/robust") && other.starts_with("track/paper");
    for (name, imports) in imports_of_crate("core") {
        for other in imports {
            assert!(rank(&other) <= rank(&name), "core/src/{name} imports from the later {other}");
            assert!(!apart(&name, &other), "core/src/{name} imports from {other}");
        }
    }
}
