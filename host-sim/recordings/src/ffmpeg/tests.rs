use crate::built_in::synthetic;
use crate::checked_frames::Damaged;
use crate::fixtures::{ffmpeg, folder, open_plain, read, reads};
use crate::missing::has_ffmpeg;
use crate::open::OpenOptions;
use std::fs;

/// Requires exact gray levels: a conversion to limited range would lose some.
#[test]
fn a_lossless_video_gives_the_same_pixels_up_to_its_damage() {
    if !has_ffmpeg("a_lossless_video_gives_the_same_pixels_up_to_its_damage") {
        return;
    }
    let folder = folder("");
    let (raw, video) = (folder.path().join("pixels"), folder.path().join("a: colon.mkv"));
    fs::write(&raw, synthetic::frames().take(30).flat_map(|frame| frame.pixels).collect::<Vec<_>>()).unwrap();
    let size = format!("{}x{}", synthetic::WIDTH, synthetic::HEIGHT);
    assert!(ffmpeg(&format!("-f rawvideo -pix_fmt gray -s {size} -i {} -c:v ffv1", raw.display()), &video));
    for path in [&video, folder.path()] {
        let (frames, error) = read(path, &OpenOptions::default());
        assert_eq!(error, "");
        assert!(frames.into_iter().eq(synthetic::frames().take(30)));
    }
    let mut half_read = open_plain(&video).unwrap();
    assert!(half_read.frames.next().unwrap().is_ok());
    drop(half_read); // would wait for ever if ffmpeg were not ended

    let bytes = fs::read(&video).unwrap();
    fs::write(&video, &bytes[..bytes.len() * 2 / 3]).unwrap();
    let (frames, error) = read(&video, &OpenOptions::default());
    assert!((5..30).contains(&frames.len()), "{}", frames.len());
    assert!(error.starts_with("@/a: colon.mkv is damaged, says ffmpeg: "), "{error}");
    let damage = open_plain(&video).unwrap().frames.find_map(Result::err).unwrap();
    let part = damage.downcast_ref::<Damaged>().and_then(Damaged::whole_part).unwrap();
    let part = open_plain(&video).unwrap().part(part.parse().unwrap(), 1, "--frames").frames;
    let part: Vec<_> = part.map(|frame| frame.unwrap().gray).collect();
    assert!(part.len() >= 5 && frames.starts_with(&part), "the frames before it can be read alone");
}

#[test]
fn what_is_no_video_and_frames_of_another_size_are_errors() {
    if !has_ffmpeg("what_is_no_video_and_frames_of_another_size_are_errors") {
        return;
    }
    let said = "Invalid data found when processing input: expected a whole video, or else pictures, Y4M or a raw dump (--size)";
    reads("a.mp4", None, b"no video at all", &[], &format!("ffmpeg cannot decode @/a.mp4: ...{said}"));
    let folder = folder("");
    let parts = ["160x120", "96x64"].map(|size| {
        let part = folder.path().join(size);
        let options = format!("-f lavfi -i testsrc=size={size}:duration=1:rate=25 -c:v mpeg1video -f mpegts");
        assert!(ffmpeg(&options, &part));
        fs::read(part).unwrap()
    });
    let file = folder.path().join("a.ts");
    fs::write(&file, parts.concat()).unwrap();
    // The last frame in front of the change is decoded or not, as the version of ffmpeg has it.
    let error = read(&file, &OpenOptions::default()).1;
    assert!(error.ends_with("it is 96x64: expected 160x120, the size of the first"), "{error}");
}
