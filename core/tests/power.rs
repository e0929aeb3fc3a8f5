//! Tests a loss of power at any time during an update or a write. `restore` either continues with identical answers or
//! refuses the bytes. A mixture of two saved targets is always refused.

use smr_core::{Answer, Frame, Image, Paper, Rect, Robust, Target, Tracker, paper, robust};

type SmallPaper = Paper<1024, 65>;

const SIZE: (u16, u16) = (120, 90);
const TARGET: Rect = Rect::new(40, 30, 20, 18);

fn small_paper() -> paper::Config {
    let mut config = paper::Config::camera();
    config.window = paper::Radius { x: 12, y: 12 };
    config.window_limit = paper::Radius { x: 32, y: 32 };
    config
}

/// A target of tiles on a background of weaker tiles. It moves in each frame and is hidden from frame 8 on.
fn picture(number: usize) -> Vec<u8> {
    let number = i32::try_from(number).unwrap();
    let hash =
        |x: i32, y: i32| (x.wrapping_mul(7_368_787) ^ y.wrapping_mul(19_349_663)).wrapping_mul(73_856_093) >> 16 & 0xFF;
    let (left, top) = (40 + 2 * number, 30 + number);
    let pixel = |x: i32, y: i32| {
        let inside = number < 8 && (left..left + 20).contains(&x) && (top..top + 18).contains(&y);
        let level = if inside { hash((x - left) / 4, (y - top) / 3) } else { 80 + hash(x / 7, y / 7 + 90) / 6 };
        u8::try_from(level).unwrap()
    };
    (0..i32::from(SIZE.1)).flat_map(|y| (0..i32::from(SIZE.0)).map(move |x| pixel(x, y))).collect()
}

fn frame(pixels: &[u8]) -> Frame<'_> {
    Frame::whole(Image::new(pixels, SIZE.0, SIZE.1).unwrap())
}

fn saved<T: Target>(tracker: &Tracker<T>) -> Vec<u8> {
    let mut bytes = vec![0; T::SAVED_SIZE];
    let length = tracker.save(&mut bytes).unwrap();
    bytes.truncate(length);
    bytes
}

fn locked<T: Target>(config: T::Config) -> Box<Tracker<T>> {
    let mut tracker = Box::new(Tracker::<T>::new(config).unwrap());
    tracker.lock(&frame(&picture(0)), TARGET).unwrap();
    tracker
}

/// The saved target before the first and after each of `frames` frames, and the answers.
fn history<T: Target>(config: T::Config, frames: usize) -> (Vec<Vec<u8>>, Vec<Answer>) {
    let mut tracker = locked::<T>(config);
    let mut all = vec![saved(&tracker)];
    let mut answers = Vec::new();
    for number in 1..=frames {
        answers.push(tracker.update(&frame(&picture(number))).unwrap());
        all.push(saved(&tracker));
    }
    (all, answers)
}

/// SplitMix64.
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mixed = (*state ^ (*state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    mixed ^ (mixed >> 31)
}

/// The power fails between two steps of an update. After the restart the update is repeated from the saved target.
fn saved_between_steps<T: Target>(config: T::Config, work: u32) {
    let (all, answers) = history::<T>(config, 12);
    for number in [1, 2, 7, 8, 9, 12] {
        let pixels = picture(number);
        let mut tracker = Box::new(Tracker::<T>::new(config).unwrap());
        tracker.restore(&all[number - 1]).unwrap();
        let mut done = tracker.begin(&frame(&pixels)).unwrap().step(work);
        let mut instants = 0;
        loop {
            // The power fails here.
            assert_eq!(saved(&tracker), all[number - 1], "an unfinished update changes nothing");
            if instants % 50 == 0 || done {
                let mut again = Box::new(Tracker::<T>::new(config).unwrap());
                again.restore(&saved(&tracker)).unwrap();
                for (later, expected) in (number..=12).zip(&answers[number - 1..]).take(3) {
                    assert_eq!(&again.update(&frame(&picture(later))).unwrap(), expected, "frame {later}");
                }
            }
            if done {
                break;
            }
            instants += 1;
            done = tracker.resume(&frame(&pixels)).unwrap().step(work);
        }
        assert!(instants > 5, "{instants} instants");
        assert_eq!(tracker.resume(&frame(&pixels)).unwrap().finish(), answers[number - 1]);
        assert_eq!(saved(&tracker), all[number], "same as after a whole update");
    }
}

/// With all that is built in.
fn robust_config() -> robust::Config {
    let mut config = robust::Config::robust();
    config.refiner = cfg!(feature = "refiner");
    config
}

#[test]
fn the_papers_target_saved_between_steps() {
    saved_between_steps::<SmallPaper>(small_paper(), 2000);
}

#[test]
fn the_robust_target_saved_between_steps() {
    saved_between_steps::<Robust>(robust_config(), 20_000);
}

/// Restores from the bytes in memory after a write was interrupted.
struct Restart<T: Target> {
    tracker: Box<Tracker<T>>,
    untouched: Vec<u8>,
    refused: u32,
}

impl<T: Target> Restart<T> {
    fn new(config: T::Config) -> Self {
        let tracker = locked::<T>(config);
        Self { untouched: saved(&tracker), tracker, refused: 0 }
    }

    /// Checks that `restore` takes `bytes` if they are all of `old` or `new`, and otherwise refuses them and changes
    /// nothing.
    fn meets(&mut self, bytes: &[u8], (old, new): (&[u8], &[u8]), what: &str) {
        let whole = [old, new].into_iter().find(|saved| bytes.starts_with(saved));
        match (self.tracker.restore(bytes), whole) {
            (Ok(()), Some(saved_before)) => {
                assert_eq!(saved(&self.tracker), saved_before, "{what}");
                let untouched = self.untouched.clone();
                self.tracker.restore(&untouched).unwrap();
            }
            (Ok(()), None) => panic!("a mixture was restored: {what}"),
            (Err(_), None) => self.refused += 1,
            (Err(error), Some(_)) => panic!("a whole target is refused: {error:?}, {what}"),
        }
    }
}

fn mixed<T: Target>(config: T::Config, every: usize) {
    let (all, _) = history::<T>(config, 12);
    let mut restart = Restart::<T>::new(config);
    let mut state = 1;
    let pairs = [(0, 1), (1, 2), (6, 7), (7, 8), (8, 9), (11, 12), (12, 1)];
    for (old, new) in pairs.map(|(old, new)| (&all[old], &all[new])) {
        let both = (old.as_slice(), new.as_slice());
        let length = new.len();
        assert_eq!(old.len(), length);
        // All cuts near both ends, and every `every` bytes.
        let cuts = (0..64).chain((64..length).step_by(every)).chain(length - 8..=length);
        for cut in cuts {
            let in_place = [&new[..cut], &old[cut..]].concat();
            restart.meets(&in_place, both, &format!("the first {cut} bytes are new"));
            let backwards = [&old[..cut], &new[cut..]].concat();
            restart.meets(&backwards, both, &format!("all but the first {cut} bytes are new"));
            restart.meets(&new[..cut], both, &format!("only {cut} bytes are there"));
            let erased = [&new[..cut], &vec![0xFF; length - cut][..]].concat();
            restart.meets(&erased, both, &format!("{cut} bytes on erased flash"));
            let zeroed = [&new[..cut], &vec![0; length - cut][..]].concat();
            restart.meets(&zeroed, both, &format!("{cut} bytes on zeroes"));
        }
        // Units written in any order: bytes, words of 4 and 8, lines of 32, pages of 256.
        for unit in [1, 4, 8, 32, 256] {
            for _ in 0..24 {
                let mut bytes = old.clone();
                for (to, from) in bytes.chunks_mut(unit).zip(new.chunks(unit)) {
                    if random(&mut state) & 1 == 0 {
                        to.copy_from_slice(from);
                    }
                }
                restart.meets(&bytes, both, &format!("units of {unit} bytes, some old, some new"));
            }
        }
        // A single byte that was not written.
        for at in (0..length).step_by(every) {
            let mut bytes = new.clone();
            bytes[at] = old[at];
            restart.meets(&bytes, both, &format!("byte {at} is old"));
        }
    }
    assert!(restart.refused > 1000, "{} were refused", restart.refused);
}

#[test]
fn the_papers_target_and_an_older_copy_mixed() {
    mixed::<SmallPaper>(small_paper(), 1);
}

#[test]
fn the_robust_target_and_an_older_copy_mixed() {
    mixed::<Robust>(robust_config(), 37);
}

/// What is in flash when the power fails, of a new copy, the older one in its place, and the bytes written.
type Torn = fn(&[u8], &[u8], usize) -> Vec<u8>;

/// Over the older copy as it is, over erased flash, and from its end on.
const OVER_THE_OLDER: Torn = |new, old, written| [&new[..written], &old[written..]].concat();
const OVER_ERASED: Torn = |new, _, written| [&new[..written], &vec![0xFF; new.len() - written]].concat();
const FROM_THE_END: Torn = |new, old, written| {
    let (front, back) = (&old[..new.len() - written], &new[new.len() - written..]);
    [front, back].concat()
};

/// Two copies in flash, one of them half written: the other one is found, or, if all bytes were written, this one.
fn one_copy_survives<T: Target>(config: T::Config, torn: Torn) {
    use smr_core::copies;
    let mut tracker = locked::<T>(config);
    let mut flash = [vec![0xFF; copies::size(T::SAVED_SIZE)], vec![0xFF; copies::size(T::SAVED_SIZE)]];
    assert_eq!((copies::newest(&flash[0], &flash[1]), copies::next(&flash[0], &flash[1])), (None, (0, 1)));
    for number in 1..=4 {
        let older = flash.clone();
        let (place, next) = copies::next(&flash[0], &flash[1]);
        assert_eq!((place, next), ((number - 1) % 2, u32::try_from(number).unwrap()));
        let length = copies::write(tracker.target(), next, &mut flash[place]).unwrap();
        assert_eq!(length, copies::size(tracker.target().saved_size().unwrap()));
        let survivor = copies::newest(&older[0], &older[1]);
        for written in 0..=length {
            let (new, old) = (&flash[place][..length], &older[place][..length]);
            let mut now = older.clone();
            now[place][..length].copy_from_slice(&torn(new, old, written));
            let found = copies::newest(&now[0], &now[1]).map(|copy| (copy.number, copy.saved));
            let whole = now[place][..length] == *new;
            let expected =
                if whole { Some((next, &new[..length - 8])) } else { survivor.map(|copy| (copy.number, copy.saved)) };
            assert_eq!(found, expected, "{written} of {length} bytes of copy {next}");
        }
        let newest = copies::newest(&flash[0], &flash[1]).unwrap();
        let mut restored = Tracker::<T>::new(config).unwrap();
        restored.restore(newest.saved).unwrap();
        let next = picture(number);
        assert_eq!(restored.update(&frame(&next)).unwrap(), tracker.update(&frame(&next)).unwrap());
    }
}

/// Three tests, so that they run at once.
#[test]
fn one_of_two_copies_survives_a_loss_of_power_over_the_older() {
    one_copy_survives::<SmallPaper>(small_paper(), OVER_THE_OLDER);
    one_copy_survives::<Robust>(robust_config(), OVER_THE_OLDER);
}

#[test]
fn one_of_two_copies_survives_a_loss_of_power_over_erased_flash() {
    one_copy_survives::<SmallPaper>(small_paper(), OVER_ERASED);
    one_copy_survives::<Robust>(robust_config(), OVER_ERASED);
}

#[test]
fn one_of_two_copies_survives_a_loss_of_power_from_the_end_on() {
    one_copy_survives::<SmallPaper>(small_paper(), FROM_THE_END);
    one_copy_survives::<Robust>(robust_config(), FROM_THE_END);
}

#[test]
fn the_newer_copy_is_told_also_when_numbers_start_again() {
    use smr_core::copies;
    let tracker = locked::<SmallPaper>(small_paper());
    let copy = |number| {
        let mut bytes = vec![0; copies::size(SmallPaper::SAVED_SIZE)];
        copies::write(tracker.target(), number, &mut bytes).unwrap();
        bytes
    };
    for (first, second, newest) in [(1, 2, 1), (2, 1, 0), (u32::MAX, 0, 1), (0, u32::MAX, 0), (7, 7, 0)] {
        let (first, second) = (copy(first), copy(second));
        assert_eq!(copies::newest(&first, &second).unwrap().place, newest);
        assert_eq!(copies::next(&first, &second).0, 1 - newest);
    }
    assert_eq!(copies::next(&copy(u32::MAX), &[]), (1, 0));
    let mut damaged = copy(5);
    for at in 0..copies::size(tracker.target().saved_size().unwrap()) {
        damaged[at] ^= 1;
        assert_eq!(copies::newest(&damaged, &[]), None, "byte {at}");
        damaged[at] ^= 1;
    }
    assert_eq!(copies::newest(&[], &damaged).unwrap().place, 1);
    assert!(copies::write(tracker.target(), 1, &mut [0; 20]).is_err());
}
