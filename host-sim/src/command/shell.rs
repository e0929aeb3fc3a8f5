//! Quoting of command-line words for a shell.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Prefixes `./` to a path that could be parsed as an option.
pub fn file(path: &Path) -> PathBuf {
    let is_option = path.as_os_str().as_encoded_bytes().starts_with(b"-") && path != Path::new("-");
    if is_option { Path::new(".").join(path) } else { path.to_owned() }
}

/// Quotes a word if necessary. Control characters and bytes outside UTF-8 are escaped: `$'\xff'`.
pub fn word(word: &OsStr) -> String {
    let text = word.to_str().filter(|text| !text.chars().any(char::is_control));
    if let Some(Ok(quoted)) = text.map(shlex::try_quote) {
        return quoted.into_owned();
    }
    let written = |&byte: &u8| match byte {
        b'\'' | b'\\' => format!("\\{}", char::from(byte)),
        b' '..=b'~' => char::from(byte).to_string(),
        _ => format!("\\x{byte:02x}"),
    };
    format!("$'{}'", word.as_encoded_bytes().iter().map(written).collect::<String>())
}

pub fn line<'a>(words: impl IntoIterator<Item = &'a OsStr>) -> String {
    words.into_iter().map(word).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
#[path = "../../../tests/missing.rs"]
mod missing;

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn every_name_comes_back_from_a_shell() {
        if !missing::has("every_name_comes_back_from_a_shell", "bash", &["--version"]) {
            return;
        }
        use std::os::unix::ffi::OsStrExt;
        for name in
            [&b"a.mp4"[..], b"a b$(x)'\".y4m", b"bad\xff1.y4m", b"new\nline", b"it's \\ \x1b[31m", "ümläut".as_bytes()]
        {
            let typed = word(OsStr::from_bytes(name));
            assert!(typed.chars().all(|letter| !letter.is_control()), "{typed}");
            let mut shell = std::process::Command::new("bash");
            let said = shell.args(["-c", &format!("printf %s {typed}")]).output().unwrap();
            assert_eq!(said.stdout, name, "{typed}");
        }
        assert_eq!(line([OsStr::new("track"), file(Path::new("-x y.mp4")).as_os_str()]), "track './-x y.mp4'");
        assert_eq!((file(Path::new("-")), file(Path::new("a"))), ("-".into(), "a".into()));
    }
}
