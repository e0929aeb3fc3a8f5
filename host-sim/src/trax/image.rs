//! An image of the protocol as a frame: `file:///path`, `image:WIDTH;HEIGHT;FORMAT;BASE64` or `data:image/png;BASE64`.

use anyhow::{Context, Result, anyhow, bail, ensure};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use smr_recordings::GrayFrame;
use std::path::Path;

/// Reads or decodes the image.
pub(super) fn frame(text: &str) -> Result<GrayFrame> {
    if let Some(memory) = text.strip_prefix("image:") {
        return pixels(memory).context("an image in memory");
    }
    if let Some(buffer) = text.strip_prefix("data:") {
        return picture(buffer).context("an image in a buffer");
    }
    let path = match text.strip_prefix("file:") {
        Some(path) => path.strip_prefix("//").unwrap_or(path),
        // A path alone was the form of the first version. A letter and a colon are a drive.
        None => match text.split_once(':') {
            Some((scheme, _)) if scheme.len() > 1 && scheme.bytes().all(|byte| byte.is_ascii_lowercase()) => {
                bail!("an image by {scheme}: expected a path, or an image in memory or a buffer")
            }
            _ => text,
        },
    };
    smr_recordings::read_picture(Path::new(path))
}

fn pixels(text: &str) -> Result<GrayFrame> {
    let mut fields = text.splitn(4, ';');
    let mut field = || fields.next().context("expected WIDTH;HEIGHT;FORMAT;BASE64");
    let (width, height, format, data) = (side(field()?)?, side(field()?)?, field()?, field()?);
    let bytes_each = match format.to_ascii_lowercase().as_str() {
        "gray8" => 1,
        "gray16" => 2,
        "rgb" => 3,
        _ => bail!("the format {format:?}: expected gray8, gray16 or rgb"),
    };
    let data = decoded(data)?;
    let expected = usize::from(width) * usize::from(height) * bytes_each;
    ensure!(data.len() == expected, "{width}x{height} {format} in {} bytes: expected {expected}", data.len());
    let pixels = match bytes_each {
        1 => data,
        // The low byte is first, as on the machines that such clients run on.
        2 => data.chunks_exact(2).map(|pixel| pixel[1]).collect(),
        _ => data.as_chunks().0.iter().map(|&rgb| smr_recordings::luma(rgb)).collect(),
    };
    Ok(GrayFrame { width, height, pixels })
}

fn side(text: &str) -> Result<u16> {
    let side = text.parse().ok().filter(|&side| side > 0);
    side.with_context(|| format!("the side {text:?}: expected 1 to 65535"))
}

fn picture(text: &str) -> Result<GrayFrame> {
    let (_, data) = text.split_once(';').context("expected image/png or image/jpeg, a semicolon and BASE64")?;
    // As it is written in general, not in this protocol.
    smr_recordings::decode_picture(&decoded(data.strip_prefix("base64,").unwrap_or(data))?)
}

fn decoded(text: &str) -> Result<Vec<u8>> {
    STANDARD.decode(text).map_err(|_| anyhow!("its data are not base 64: expected BASE64"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn small() -> GrayFrame {
        GrayFrame { width: 4, height: 3, pixels: (0..12).map(|value| value * 20).collect() }
    }

    fn png() -> Vec<u8> {
        smr_pages::export::png(&small()).unwrap()
    }

    #[test]
    fn each_way_gives_the_same_pixels() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a b.png");
        std::fs::write(&file, png()).unwrap();
        let gray = small().pixels;
        let wide: Vec<u8> = gray.iter().flat_map(|&pixel| [77, pixel]).collect();
        let rgb: Vec<u8> = gray.iter().flat_map(|&pixel| [pixel; 3]).collect();
        let path = file.to_str().unwrap();
        for text in [
            path.to_owned(),
            format!("file://{path}"),
            format!("data:image/png;{}", STANDARD.encode(png())),
            format!("data:image/png;base64,{}", STANDARD.encode(png())),
            format!("image:4;3;gray8;{}", STANDARD.encode(&gray)),
            format!("image:4;3;gray16;{}", STANDARD.encode(&wide)),
            format!("image:4;3;rgb;{}", STANDARD.encode(&rgb)),
        ] {
            assert_eq!(frame(&text).unwrap(), small(), "{text}");
        }
    }

    #[test]
    fn what_is_no_image_is_refused_in_words() {
        for (text, expected) in [
            ("file:///no/such.png", "cannot read /no/such.png: "),
            ("http://example.com/1.png", "an image by http: "),
            ("image:4;3;gray8", "an image in memory: expected WIDTH;HEIGHT;FORMAT;BASE64"),
            ("image:0;3;gray8;AA==", "an image in memory: the side \"0\": expected 1 to 65535"),
            ("image:4;3;bgr;AA==", "an image in memory: the format \"bgr\": "),
            ("image:65535;65535;rgb;AA==", "an image in memory: 65535x65535 rgb in 1 bytes: expected 12884508675"),
            ("image:4;3;gray8;!", "an image in memory: its data are not base 64: expected BASE64"),
            ("data:image/png;AAAA", "an image in a buffer: expected a PNG, JPEG"),
            ("data:AAAA", "an image in a buffer: expected image/png"),
        ] {
            let error = format!("{:#}", frame(text).unwrap_err());
            assert!(error.starts_with(expected), "{text}: {error}");
        }
    }

    proptest! {
        #[test]
        fn any_text_is_decoded_or_refused(text in "(image:|data:|image:[1-9];[1-9];(gray8|gray16|rgb);)[A-Za-z0-9+/=;:,]{0,60}") {
            let _ = frame(&text);
        }
    }
}
