//! Compares `core/c/include/smr.h` with the header that cbindgen generates from the source.
//!
//! Write it with `SMR_RECORD=1 cargo test -p smr-api`.

use smr::{
    STATUSES, smr_answer, smr_config, smr_entry, smr_fine_rect, smr_fraction, smr_frame, smr_image, smr_margins,
    smr_paper_config, smr_part, smr_radius, smr_readout, smr_recorder, smr_rect, smr_robust_config, smr_setting,
    smr_state, smr_status,
};
use smr_api::wrapped;
use smr_core::{Setting, Settings, paper, robust};
use std::collections::BTreeMap;
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
    let mut written = String::from_utf8(written).expect("a header is text");
    document::<paper::Config>(&mut written, "smr_paper_config");
    document::<robust::Config>(&mut written, "smr_robust_config");
    let (types, calls) = written.split_once("\n#ifdef __cplusplus\nextern").expect("types come before calls");
    let written = format!("{types}{}\n#ifdef __cplusplus\nextern{calls}", sizes(types));
    if std::env::var_os("SMR_RECORD").is_some() {
        std::fs::write(&path, &written).expect("the header can be written");
    }
    let current = std::fs::read_to_string(&path).expect("the header is there");
    let names = current.lines().filter_map(|line| line.trim_start_matches("#ifndef ").trim().strip_prefix("#define "));
    let foreign: Vec<&str> = names.filter(|name| !name.starts_with("SMR_")).collect();
    assert!(foreign.is_empty(), "macros without the library's prefix: {foreign:?}");
    assert!(current == written, "include/smr.h is not current: SMR_RECORD=1 cargo test -p smr-api");
}

/// Inserts a comment before each field of the struct: the text of the field's setting, and its range if it has limits.
fn document<C: Settings>(header: &mut String, name: &str) {
    let start = header.find(&format!("typedef struct {name} {{\n")).expect("the struct is there");
    let start = start + header[start..].find('\n').expect("it has lines") + 1;
    let end = start + header[start..].find('}').expect("it ends");
    let documented = |line: &str| {
        let of_line = |(setting, _): &(&Setting, _)| line.ends_with(&format!(" {};", setting.name()));
        let (setting, text) = C::SETTINGS.iter().zip(C::TEXTS).find(of_line).expect("a field is a setting");
        let range = match (setting.shape, setting.highest) {
            (_, 1) => " 0 or 1.".to_owned(),
            (_, u16::MAX) if setting.lowest == 0 => String::new(),
            _ => format!(" {} to {}.", setting.lowest, setting.highest),
        };
        format!("  /**\n{}   */\n{line}\n", wrapped(&format!("{text}{range}"), "   * ", 118))
    };
    assert_eq!(header[start..end].lines().count(), C::SETTINGS.len(), "{name}");
    let fields: String = header[start..end].lines().map(documented).collect();
    header.replace_range(start..end, &fields);
}

/// Returns the enum of statuses as C. A macro defines the statuses, and cbindgen does not expand macros.
fn statuses() -> String {
    let mut text = String::from(
        "
/**
 * The result of a call. The numbers never change; later versions may add new ones.
 *
 * A call that returns an error changes nothing, except that #smr_init sets `*tracker` to NULL and a read-out notes the line.
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

/// Expands to a map from the name of each type to its size in this library.
macro_rules! sizes {
    ($($type:ident),* $(,)?) => {
        BTreeMap::from([$((stringify!($type), size_of::<$type>())),*])
    };
}

/// Returns C code that compiles only if each struct has the size that it has in this library. The code does not compile
/// if an earlier header leaves a `#pragma pack` on.
fn sizes(types: &str) -> String {
    let mut text = String::from(
        "
/* Each type has the size that it has in the library, with pointers of 4 and of 8 bytes. */
#if defined(__cplusplus) && __cplusplus >= 201103L
#define SMR_UNPACKED(type, holds) static_assert(holds, #type \" must not be packed: a header before smr.h has left #pragma pack on\")
#else
#define SMR_UNPACKED(type, holds) typedef char type##_must_not_be_packed[(holds) ? 1 : -1]
#endif
#define SMR_SIZE(type, on_32_bits, on_64_bits) \\
    SMR_UNPACKED(type, sizeof(type) == (sizeof(void *) == 8 ? on_64_bits : on_32_bits))
",
    );
    let mut here = sizes!(
        smr_answer,
        smr_config,
        smr_entry,
        smr_fine_rect,
        smr_fraction,
        smr_frame,
        smr_image,
        smr_margins,
        smr_paper_config,
        smr_part,
        smr_radius,
        smr_readout,
        smr_recorder,
        smr_rect,
        smr_robust_config,
        smr_setting,
    );
    assert_eq!([size_of::<smr_state>(), size_of::<smr_status>()], [4; 2], "both are int32_t in C");
    for (name, [on_32_bits, on_64_bits]) in layouts(types) {
        let natural = if size_of::<usize>() == 8 { on_64_bits } else { on_32_bits };
        assert_eq!(here.remove(name), Some(natural), "the size of {name} in the library and in C");
        writeln!(text, "SMR_SIZE({name}, {on_32_bits}, {on_64_bits});").expect("a string takes text");
    }
    assert!(here.is_empty(), "not in the header: {here:?}");
    text + "#ifndef __i386__ /* where members of a struct have an alignment of at most 4 */
struct smr_storage {
    char before;
    smr_paper_target storage;
};
SMR_UNPACKED(smr_storage, offsetof(struct smr_storage, storage) == SMR_ALIGNMENT);
#endif
#undef SMR_SIZE
#undef SMR_UNPACKED
"
}

/// Computes the size of each struct of the header, with pointers of 4 and of 8 bytes, by the layout rules of C.
fn layouts(types: &str) -> Vec<(&str, [usize; 2])> {
    let mut known =
        BTreeMap::from([("uint8_t", [[1_usize, 1]; 2]), ("uint16_t", [[2, 2]; 2]), ("size_t", [[4, 4], [8, 8]])]);
    known.extend(["int32_t", "uint32_t", "smr_state", "smr_entry_kind"].map(|name| (name, [[4, 4]; 2])));
    let mut found = Vec::new();
    for block in types.split("typedef struct ").skip(1) {
        // A forward declaration has no fields.
        let Some((name, body)) = block.split_once(" {\n").filter(|(name, _)| !name.contains(';')) else { continue };
        let body = body.split_once("\n}").expect("a struct has an end").0;
        let fields = body.lines().map(str::trim).filter(|line| line.ends_with(';') && !line.starts_with('*'));
        let mut layout = [[0_usize, 1]; 2];
        for field in fields {
            let of =
                field.trim_start_matches("const ").trim_start_matches("struct ").split(' ').next().expect("a type");
            let of = if field.contains('*') { "size_t" } else { of };
            let part = known.get(of).unwrap_or_else(|| panic!("{name}: an unknown type: {field}"));
            let count = field.split_once('[').map_or("1", |(_, count)| count.trim_end_matches("];"));
            let count: usize = count.parse().expect("a number of elements");
            for ([size, alignment], [one, of]) in layout.iter_mut().zip(part) {
                *size = size.next_multiple_of(*of) + count * one;
                *alignment = *of.max(alignment);
            }
        }
        let layout = layout.map(|[size, alignment]: [usize; 2]| [size.next_multiple_of(alignment), alignment]);
        known.insert(name, layout);
        found.push((name, layout.map(|[size, _]| size)));
    }
    found
}
