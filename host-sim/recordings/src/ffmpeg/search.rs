//! Searches the last whole picture of a damaged recording.
//!
//! A decoder that fails ends some pictures early or late, differently in each run and each version of ffmpeg. So the
//! search decodes copies of the first packets alone, and looks for the largest number that decodes without a doubt.

use super::facts::Video;
use super::packets::{DISCARDED, KEY, Packet, Packets};
use super::pictures::{End, FROM_ZERO, Part, Pictures, Use};
use anyhow::Result;

/// Number of packets by which the search first goes on behind those that certainly decode.
const STEP: usize = 16;

/// Returns the number of pictures that decode without a doubt; near `guess`, the search is short.
pub(super) fn whole_pictures(video: &Video, guess: usize) -> Result<usize> {
    let packets = listed(video)?;
    let guess = guess.min(packets.len());
    let (mut good, mut pictures) = (0, 0);
    let mut bad = packets.len() + 1;
    let mut step = STEP;
    let mut next = guess;
    while good + 1 < bad {
        match decoded(video, next)? {
            Some(count) => {
                (good, pictures) = (next, count);
                next = (good + step).min(packets.len());
                step *= 2;
            }
            None => bad = next,
        }
        if next >= bad || next == good {
            next = good.midpoint(bad);
        }
    }
    Ok(pictures.min(in_order(&packets, good)))
}

/// Returns the packets from the first key frame on.
fn listed(video: &Video) -> Result<Vec<Packet>> {
    let stream = format!("0:V:{}", video.facts.stream);
    let mut packets = Packets::of(&video.input, &FROM_ZERO, &["-map", &stream])?;
    let mut all = Vec::new();
    while let Some(packet) = packets.next()? {
        if !all.is_empty() || packet.flags & KEY != 0 {
            all.push(packet);
        }
    }
    Ok(all)
}

/// Decodes the first packets alone. Returns the number of pictures, or `None` if a doubt arises.
fn decoded(video: &Video, packets: usize) -> Result<Option<usize>> {
    if packets == 0 {
        return Ok(Some(0));
    }
    let mut pictures = Pictures::start(video, Use::Times, Part::Packets(packets))?;
    while pictures.next()?.is_some() {}
    Ok((pictures.end() == Some(&End::Whole)).then(|| pictures.decoded()))
}

/// Returns how many of the first packets are shown before every later packet.
fn in_order(packets: &[Packet], first: usize) -> usize {
    let (head, tail) = packets.split_at(first);
    let next = tail.iter().filter_map(|packet| packet.shown).min().unwrap_or(i64::MAX);
    head.iter().filter(|packet| packet.flags & DISCARDED == 0 && packet.shown.is_none_or(|shown| shown < next)).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_that_is_shown_after_a_missing_one_does_not_count() {
        let packet = |shown| Packet { stream: 0, sent: None, shown: Some(shown), size: 1, flags: 0 };
        let packets = [0, 3, 1, 2, 6, 4, 5].map(packet);
        let counts: Vec<usize> = (0..=7).map(|first| in_order(&packets, first)).collect();
        assert_eq!(counts, [0, 1, 1, 2, 4, 4, 5, 7]);
        let cut = Packet { flags: DISCARDED, ..packet(0) };
        assert_eq!(in_order(&[cut, packet(1), packet(2)], 2), 1);
    }
}
