//! Checks that sizes in `include/smr.h` equal those of the library. `tests/api` checks that the header is current.

use crate::missing;
use smr::{
    ALIGNMENT, PAPER_SAVED_SIZE, PAPER_TARGET_SIZE, PAPER_WORKSPACE_SIZE, PIXELS, REFINER, ROBUST_SAVED_SIZE,
    ROBUST_SMALL_SAVED_SIZE, ROBUST_SMALL_TARGET_SIZE, ROBUST_SMALL_WORKSPACE_SIZE, ROBUST_TARGET_SIZE,
    ROBUST_WORKSPACE_SIZE, SPAN,
};
use std::path::Path;
use std::process::Command;

fn claim(what: &str, value: usize) -> String {
    format!("{{ char claim[{what} == {value} ? 1 : -1]; (void)claim; }}\n")
}

/// A program that compiles if each macro of a size has the library's value.
fn claims() -> String {
    let sizes = [
        ("SMR_ALIGNMENT", ALIGNMENT),
        ("SMR_PAPER_TARGET_SIZE", PAPER_TARGET_SIZE),
        ("SMR_PAPER_WORKSPACE_SIZE", PAPER_WORKSPACE_SIZE),
        ("SMR_PAPER_SAVED_SIZE", PAPER_SAVED_SIZE),
        ("SMR_ROBUST_TARGET_SIZE", ROBUST_TARGET_SIZE),
        ("SMR_ROBUST_WORKSPACE_SIZE", ROBUST_WORKSPACE_SIZE),
        ("SMR_ROBUST_SAVED_SIZE", ROBUST_SAVED_SIZE),
        ("SMR_ROBUST_SMALL_TARGET_SIZE", ROBUST_SMALL_TARGET_SIZE),
        ("SMR_ROBUST_SMALL_WORKSPACE_SIZE", ROBUST_SMALL_WORKSPACE_SIZE),
        ("SMR_ROBUST_SMALL_SAVED_SIZE", ROBUST_SMALL_SAVED_SIZE),
    ];
    let claims: String = sizes.iter().map(|(name, size)| claim(name, *size)).collect();
    format!("int main(void) {{\n{claims}return 0;\n}}\n")
}

fn compiles(compiler: &str, standard: &str, source: &str) -> (bool, String) {
    let folder = tempfile::tempdir().expect("a folder can be made");
    let file = folder.path().join(if standard.starts_with("c++") { "source.cpp" } else { "source.c" });
    std::fs::write(&file, source).expect("the folder can be written");
    let output = Command::new(compiler)
        .args(["-pedantic", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", &format!("-std={standard}"), "-I"])
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("include"))
        .arg(&file)
        .output();
    let output = output.expect("the compiler runs");
    (output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// The sizes that smr.h states are those of the library. If an earlier header leaves `#pragma pack` in force, types would
/// have other sizes, so smr.h must not compile.
#[test]
fn the_header_compiles_with_the_sizes_of_the_library_and_not_in_a_packing() {
    const TEST: &str = "the_header_compiles_with_the_sizes_of_the_library_and_not_in_a_packing";
    if !missing::has_c_compiler(TEST) {
        return;
    }
    let has = |compiler| Command::new(compiler).arg("--version").output().is_ok();
    for (compiler, standard) in [("cc", "c99"), ("cc", "c2x"), ("c++", "c++11"), ("c++", "c++20")] {
        if !has(compiler) {
            println!("skipped: {TEST}: no {compiler}");
            continue;
        }
        for (packing, expected) in [("pack(1)", false), ("pack(2)", false), ("pack(4)", false), ("pack(16)", true)] {
            let refiner = REFINER / 1056;
            let capacity =
                format!("#define SMR_PIXELS {PIXELS}\n#define SMR_SPAN {SPAN}\n#define SMR_REFINER {refiner}\n");
            let head = format!("{capacity}#pragma {packing}\n");
            let source = head + "#include \"smr.h\"\n#include \"smr.h\"\n" + &claims();
            let (compiled, words) = compiles(compiler, standard, &source);
            assert_eq!(compiled, expected, "{compiler}, {standard}, {packing}: {words}");
            assert!(
                expected || words.contains("must_not_be_packed") || words.contains("must not be packed"),
                "{words}"
            );
        }
    }
}

/// Converts `size`, the value of macro `name` in this build, to the macro's value in a 32-bit build where SMR_PIXELS is
/// `pixels` and SMR_SPAN is `span`.
fn on_32_bits(size: usize, name: &str, pixels: usize, span: usize) -> usize {
    let header = include_str!("../../include/smr.h");
    let definition = header.split_once(&format!("#define {name} ")).expect("the header defines it").1;
    let words = definition.split_once(" * sizeof(size_t)").expect("it counts words").0.split(' ').next_back();
    let words: usize = words.unwrap().trim_start_matches('(').parse().expect("a number of words");
    let eights = |number: usize| number.next_multiple_of(8);
    let own = if name.starts_with("SMR_PAPER") { eights(PIXELS) } else { eights(pixels) };
    let offsets = |span: usize| if name == "SMR_PAPER_WORKSPACE_SIZE" { eights(20 * span) } else { 0 };
    size - words * (size_of::<usize>() - 4) - own + eights(pixels) - offsets(SPAN) + offsets(span)
}

#[test]
fn the_readmes_state_the_sizes_of_the_header() {
    let target = |pixels| on_32_bits(PAPER_TARGET_SIZE, "SMR_PAPER_TARGET_SIZE", pixels, 0);
    let workspace = |pixels, span| on_32_bits(PAPER_WORKSPACE_SIZE, "SMR_PAPER_WORKSPACE_SIZE", pixels, span);
    let robust = on_32_bits(ROBUST_TARGET_SIZE, "SMR_ROBUST_TARGET_SIZE", 0, 0) - REFINER;
    let scratch = on_32_bits(ROBUST_WORKSPACE_SIZE, "SMR_ROBUST_WORKSPACE_SIZE", 0, 0);
    let small = on_32_bits(ROBUST_SMALL_TARGET_SIZE, "SMR_ROBUST_SMALL_TARGET_SIZE", 0, 0) - REFINER;
    let small_scratch = on_32_bits(ROBUST_SMALL_WORKSPACE_SIZE, "SMR_ROBUST_SMALL_WORKSPACE_SIZE", 0, 0);
    let (usual, room) = (target(4096), workspace(4096, 161));
    let row = |pixels, span| format!("| {} bytes | {} bytes |\n", target(pixels), workspace(pixels, span));
    let readme = include_str!("../../README.md");
    for words in [
        format!("from frame to frame: {usual} bytes"),
        format!("any number of these trackers: {room} bytes"),
        format!("`smr_paper_target`, {usual} | `smr_robust_target`, {robust} |"),
        format!("`smr_robust_small_target` ({small} bytes)"),
        format!("`smr_robust_small_workspace` ({small_scratch} bytes)"),
        format!("`smr_paper_workspace`, {room} | `smr_robust_workspace`, {scratch} |"),
        format!("161 (+-80), the default: the paper's {}", row(4096, 161)),
        format!("| 4096 (64x64) | 33 (+-16) {}", row(4096, 33)),
        format!("| 1024 (32x32) | 33 (+-16) {}", row(1024, 33)),
    ] {
        assert!(readme.contains(&words), "core/c/README.md: expected {words}");
    }
    let kb = |bytes: usize| format!("{}.{}", (bytes + 50) / 1000, (bytes + 50) % 1000 / 100);
    let heap = format!(
        "A `Paper` takes {} KB and a `Robust` {} KB. The first tracker of each kind also takes a\nworkspace ({} KB, {} KB)",
        kb(usual),
        kb(robust),
        kb(room),
        kb(scratch)
    );
    assert!(
        include_str!("../../../micropython/README.md").contains(&heap),
        "core/micropython/README.md: expected {heap}"
    );
    let largest =
        format!("{} KB for a robust tracker, {} KB for the paper's", kb(robust + 1056), target(65536).div_ceil(1000));
    assert!(include_str!("../../../web/README.md").contains(&largest), "core/web/README.md: expected {largest}");
}
