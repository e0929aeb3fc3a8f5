//! `core/c/include/smr.h` is what cbindgen writes from the source.
//!
//! Write it with `SMR_RECORD=1 cargo test -p smr-api`.

use smr::STATUSES;
use std::fmt::Write as _;
use std::path::Path;

#[test]
fn the_header_is_current() {
    let here = &Path::new(env!("CARGO_MANIFEST_DIR")).join("../../core/c");
    let path = here.join("include/smr.h");
    let mut written = Vec::new();
    let mut config = cbindgen::Config::from_root_or_default(here);
    config.after_includes.as_mut().expect("cbindgen.toml has it").push_str(&statuses());
    let source = cbindgen::Builder::new().with_crate(here).with_config(config);
    source.generate().expect("cbindgen reads the source").write(&mut written);
    let written = String::from_utf8(written).expect("a header is text");
    if std::env::var_os("SMR_RECORD").is_some() {
        std::fs::write(&path, &written).expect("the header can be written");
    }
    let current = std::fs::read_to_string(&path).expect("the header is there");
    let names = current.lines().filter_map(|line| line.trim_start_matches("#ifndef ").trim().strip_prefix("#define "));
    let foreign: Vec<&str> = names.filter(|name| !name.starts_with("SMR_")).collect();
    assert!(foreign.is_empty(), "macros without the library's prefix: {foreign:?}");
    assert!(current == written, "include/smr.h is not current: SMR_RECORD=1 cargo test -p smr-api");
}

/// The statuses in the header. A macro defines them, and cbindgen cannot read macros.
fn statuses() -> String {
    let mut text = String::from(
        "
/**
 * How a call ended. The numbers never change; later versions may add new ones.
 *
 * A call that does not return #SMR_OK changes nothing, except that #smr_init sets `*tracker` to NULL.
 */
enum smr_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif
 {
",
    );
    for (status, name, meaning) in STATUSES {
        let (name, meaning) = (name.trim_end_matches('\0'), meaning.trim().replace('\n', "\n   *"));
        writeln!(text, "  /**\n   * {meaning}\n   */\n  {name} = {},", *status as i32).expect("a string takes text");
    }
    text + "};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum smr_status smr_status;
#else
typedef int32_t smr_status;
#endif
#endif
"
}
