//! Searches the last whole image of a damaged recording.
//!
//! A decoder that fails ends some images early or late, differently in each run and each version of ffmpeg. So the
//! search decodes copies of the first packets alone, and looks for the largest number that decodes without a doubt.

use super::decoder::{Decoder, MAX_TIME_JUMP, Part, Use};
use super::facts::Video;
use super::packets::{CORRUPT, DISCARDED, KEY, Packet};
use anyhow::Result;

/// Number of packets by which the search first goes on behind those that certainly decode. ffmpeg's threads are fewer
/// packets apart.
const STEP: usize = 16;

/// Largest number of packets between a packet that is marked as damaged and a join that is the reason for the mark.
const JOIN: usize = 2;

/// Packets of a video from the first key frame on, and what is doubtful about them before they are decoded.
pub(super) struct List {
    packets: Vec<Packet>,
    /// Number of packets before the first that the container marks as damaged, except at a join.
    corrupt: Option<usize>,
    /// Number of packets before ffmpeg complains about the file, or ends too early.
    complaint: Option<usize>,
}

impl List {
    pub fn of(video: &Video) -> Result<Self> {
        let facts = &video.facts;
        let mut rows = video.packets()?;
        let (mut packets, mut complaint) = (Vec::new(), None);
        while let Some(packet) = rows.next()? {
            if rows.ffmpeg.complaints > facts.notes {
                complaint.get_or_insert(packets.len());
            }
            if !packets.is_empty() || packet.flags & KEY != 0 {
                packets.push(packet);
            }
        }
        if !rows.ffmpeg.succeeded()? || rows.ffmpeg.complaints > facts.notes {
            complaint.get_or_insert(packets.len());
        }
        let corrupt = corrupt(&packets, facts.base);
        Ok(Self { packets, corrupt, complaint })
    }

    /// True if copies of the packets show the images that the file shows, and nothing is doubtful about them.
    pub fn is_plain(&self) -> bool {
        let is_cut = |packet: &Packet| packet.flags & DISCARDED != 0;
        self.doubt().is_none() && !self.packets.iter().any(is_cut)
    }

    /// Returns the number of packets before the first doubt.
    pub fn doubt(&self) -> Option<usize> {
        [self.corrupt, self.complaint].into_iter().flatten().min()
    }

    /// True if ffmpeg complains about the end of the file alone.
    fn ends_too_early(&self) -> bool {
        self.complaint.is_some_and(|complaint| complaint + STEP >= self.packets.len())
    }
}

/// Number of whole images of a damaged recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Whole {
    pub images: usize,
    /// Number of images by which another run may find fewer.
    pub spread: usize,
}

impl Whole {
    /// Number of whole images where nothing tells the damaged packet: `decoded` in one run. ffmpeg's threads are up to
    /// two queues of eight packets apart when it ends at an error.
    pub const fn unknown(decoded: usize) -> Self {
        Self { images: decoded, spread: STEP }
    }
}

/// Searches the images that decode without a doubt. In the run that has failed, `decoded` did.
pub(super) fn whole(video: &Video, decoded: usize) -> Result<Whole> {
    let list = List::of(video)?;
    let complaint = list.complaint.filter(|_| !list.ends_too_early());
    let end = list.corrupt.into_iter().chain(complaint).min().unwrap_or(list.packets.len());
    let (packets, images) = most_packets(video, decoded.min(end), end)?;
    let images = images.min(in_order(&list.packets, packets));
    Ok(if complaint.is_some_and(|complaint| complaint == packets) {
        // ffmpeg may complain some packets early.
        Whole::unknown(images)
    } else if packets < list.packets.len() {
        Whole { images, spread: 1 }
    } else if list.ends_too_early() || video.input.end.is_some() {
        // The last packets before the end of a cut file come through or not.
        Whole { images, spread: 4 }
    } else {
        Whole::unknown(images.min(decoded))
    })
}

/// Returns the largest number of packets, at most `end`, that decode without a doubt, and their number of images.
fn most_packets(video: &Video, guess: usize, end: usize) -> Result<(usize, usize)> {
    let (mut good, mut images, mut bad) = (0, 0, end + 1);
    let (mut next, mut step) = (guess, STEP);
    while good + 1 < bad {
        if next <= good || next >= bad {
            next = good.midpoint(bad);
        }
        match decoded(video, next)? {
            Some(count) => {
                (good, images) = (next, count);
                next = (good + step).min(end);
                step *= 2;
            }
            None => bad = next,
        }
    }
    Ok((good, images))
}

/// Returns the number of packets before the first one that the container marks as damaged, except at a join.
fn corrupt(packets: &[Packet], base: Option<(u32, u32)>) -> Option<usize> {
    let jump = base.map_or(i64::MAX, |(unit, second)| i64::from(MAX_TIME_JUMP) * i64::from(second) / i64::from(unit));
    let is_join = |pair: &[Packet]| {
        let times = pair[0].sent.zip(pair[1].sent);
        times.is_some_and(|(last, now)| now <= last || now.saturating_sub(last) > jump)
    };
    let is_marked = |&at: &usize| {
        let behind = &packets[at..packets.len().min(at + JOIN + 1)];
        packets[at].flags & CORRUPT != 0 && !behind.windows(2).any(is_join)
    };
    (0..packets.len()).find(is_marked)
}

/// Decodes the first packets alone. Returns the number of images, or `None` if a doubt arises.
fn decoded(video: &Video, packets: usize) -> Result<Option<usize>> {
    if packets == 0 {
        return Ok(Some(0));
    }
    let mut decoder = Decoder::start(video, Use::Times, Part::Packets(packets))?;
    while decoder.next()?.is_some() {}
    Ok(decoder.is_whole().then(|| decoder.decoded()))
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
    fn an_image_that_is_shown_after_a_missing_one_does_not_count() {
        let packet = |shown| Packet { stream: 0, sent: None, shown: Some(shown), size: 1, flags: 0 };
        let packets = [0, 3, 1, 2, 6, 4, 5].map(packet);
        let counts: Vec<usize> = (0..=7).map(|first| in_order(&packets, first)).collect();
        assert_eq!(counts, [0, 1, 1, 2, 4, 4, 5, 7]);
        let cut = Packet { flags: DISCARDED, ..packet(0) };
        assert_eq!(in_order(&[cut, packet(1), packet(2)], 2), 1);
    }

    #[test]
    fn a_mark_at_a_join_is_no_damage() {
        let packet = |sent, flags| Packet { stream: 0, sent: Some(sent), shown: None, size: 1, flags };
        let packets = |times: [i64; 6]| {
            let mut packets = times.map(|time| packet(time, 0));
            packets[2].flags = CORRUPT;
            packets
        };
        let found = |times| corrupt(&packets(times), Some((1, 10)));
        assert_eq!(found([0, 1, 2, 3, 4, 5]), Some(2));
        assert_eq!((found([0, 1, 2, 3, 0, 1]), found([0, 1, 2, 3, 3, 3])), (None, None));
        assert_eq!((found([0, 1, 2, 3, 4, 0]), found([0, 1, 2, 500_000, 500_001, 500_002])), (Some(2), None));
        assert_eq!(corrupt(&packets([0, 1, 2, 3, 4, 5])[..3], None), Some(2));
    }
}
