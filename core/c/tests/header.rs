//! `include/smr.h` is current, and its types are laid out as the library's.

use smr::{
    PIXELS, ROBUST_STORAGE_ALIGN, ROBUST_STORAGE_SIZE, SPAN, STORAGE_ALIGN, STORAGE_SIZE, smr_answer, smr_config,
    smr_fine_rect, smr_fraction, smr_frame, smr_gate, smr_image, smr_margins, smr_peak, smr_radius, smr_rect,
    smr_robust_answer, smr_robust_config, smr_robust_state, smr_state, smr_status, smr_table,
};
use std::fmt::Write as _;
use std::mem::offset_of;
use std::path::Path;
use std::process::Command;

#[test]
fn the_header_is_current() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = here.join("include/smr.h");
    let mut written = Vec::new();
    cbindgen::generate(here).expect("cbindgen reads the source").write(&mut written);
    let written = String::from_utf8(written).expect("a header is text");
    if std::env::var_os("SMR_UPDATE_HEADER").is_some() {
        std::fs::write(&path, &written).expect("the header can be written");
    }
    let current = std::fs::read_to_string(&path).expect("the header is there");
    assert!(current == written, "include/smr.h is not current: SMR_UPDATE_HEADER=1 cargo test -p smr-c --test header");
}

/// Lines of C that compile only if `$type` has this size and its fields lie there.
macro_rules! layout {
    ($type:ident { $($field:ident),* }) => {
        [
            claim(concat!("sizeof(", stringify!($type), ")"), size_of::<$type>()),
            $(claim(concat!("offsetof(", stringify!($type), ", ", stringify!($field), ")"), offset_of!($type, $field)),)*
        ]
        .concat()
    };
}

fn claim(what: &str, value: usize) -> String {
    format!("{{ char claim[{what} == {value} ? 1 : -1]; (void)claim; }}\n")
}

#[test]
fn the_header_and_the_library_agree_on_every_size() {
    let mut source = format!("#define SMR_PIXELS {PIXELS}\n#define SMR_SPAN {SPAN}\n");
    source += "#include \"smr.h\"\nint main(void) {\n";
    source += &claim("SMR_TRACKER_SIZE", STORAGE_SIZE);
    source += &claim("sizeof(smr_storage)", STORAGE_SIZE);
    source += &claim("SMR_TRACKER_ALIGN", STORAGE_ALIGN);
    source += &claim("SMR_ROBUST_TRACKER_SIZE", ROBUST_STORAGE_SIZE);
    source += &claim("sizeof(smr_robust_storage)", ROBUST_STORAGE_SIZE);
    source += &claim("SMR_ROBUST_TRACKER_ALIGN", ROBUST_STORAGE_ALIGN);
    source += &layout!(smr_status {});
    source += &layout!(smr_state {});
    source += &layout!(smr_table { entries });
    source += &layout!(smr_fraction { numerator, denominator });
    source += &layout!(smr_radius { x, y });
    source += &layout!(smr_rect { x, y, width, height });
    source += &layout!(smr_gate { tracking, leaving, returning, lost, lead, least_ratio });
    source += &layout!(smr_margins { left, top, right, bottom });
    source += &layout!(smr_config {
        table,
        k,
        first_threshold,
        least_threshold,
        padding,
        window,
        growth,
        window_limit,
        neighbourhood,
        update_zone,
        gate,
        plain_loop,
        runner_up_always
    });
    source += &layout!(smr_frame { pixels, size, stride, width, height, x, y, full_width, full_height });
    source += &layout!(smr_peak { x, y, score });
    source += &layout!(smr_answer { bbox, state, ratio, runner_up_ratio, alpha, peak, runner_up, has_runner_up });
    source += &layout!(smr_robust_config { velocity, near, size, verification, caution, sweep, plain_loop });
    source += &layout!(smr_robust_state {});
    source += &layout!(smr_fine_rect { x, y, width, height });
    source += &layout!(smr_robust_answer { fine, bbox, state, confidence, ratio, response, scale, work, found_again });
    source += &layout!(smr_image { pixels, width, height });
    writeln!(source, "return 0;\n}}").expect("a string takes text");

    let folder = tempfile::tempdir().expect("a folder can be made");
    let file = folder.path().join("sizes.c");
    std::fs::write(&file, &source).expect("the folder can be written");
    // Linking this test needed a C compiler; so there is one.
    let output = Command::new("cc")
        .args(["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-I"])
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("include"))
        .arg(&file)
        .output()
        .expect("cc runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
