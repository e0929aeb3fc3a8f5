//! An update or a lock under way belongs to its target, wherever target and workspace are.
//!
//! Targets and workspaces change places, are replaced, restored into each other and left in the middle of updates and
//! locks. A model knows from the targets' saved bytes which update or lock is under way. After every call, and for
//! every target in every workspace, `resume` must succeed if and only if the model says so. Each result must equal that
//! of a twin that ran without steps.

use super::{SIZE, TARGET, picture, saved, whole};
use crate::{Paper, Rect, Robust, Target};
use proptest::prelude::*;
use proptest::sample::Index;
use std::{vec, vec::Vec};

const PLACES: [Rect; 3] = [TARGET, Rect::new(131, 90, 27, 2), Rect::new(20, 3, 12, 57)];

/// A target whose learning during a lock can be read.
pub(super) trait Learning: Target {
    /// The weights that a lock under way has learned so far.
    fn learned(&self) -> Vec<i32>;
    /// Another configuration: a target saved with it cannot be restored with the first one.
    fn other(config: Self::Config) -> Self::Config;
}

impl<const PIXELS: usize, const SPAN: usize> Learning for Paper<PIXELS, SPAN> {
    fn learned(&self) -> Vec<i32> {
        vec![]
    }

    fn other(mut config: Self::Config) -> Self::Config {
        config.least_threshold += 1;
        config
    }
}

impl Learning for Robust {
    fn learned(&self) -> Vec<i32> {
        self.weights().to_vec()
    }

    fn other(mut config: Self::Config) -> Self::Config {
        config.patience += 1;
        config
    }
}

#[derive(Clone, Debug)]
enum Call {
    SwapTargets(Index, Index),
    SwapWorkspaces(Index, Index),
    /// Drops a target or a workspace and makes a new one.
    NewTarget(Index, bool),
    NewWorkspace(Index),
    Begin(Index, Index, Index, u32),
    BeginLock(Index, Index, Index, Index, u32),
    /// `Step` continues the update or lock under way in the workspace, on a target that can; `Finish` finishes it.
    Step(Index, Index, u32),
    Finish(Index, Index),
    Update(Index, Index, Index),
    Moved(Index, i32, i32),
    /// Saves a target and restores it into another one.
    Copy(Index, Index),
}

fn calls() -> impl Strategy<Value = Vec<Call>> {
    let at = any::<Index>;
    let work = || prop_oneof![Just(1), 1000u32..200_000, Just(3_000_000), Just(u32::MAX)];
    let turn = || prop_oneof![Just(0), -2000..2000i32];
    let call = prop_oneof![
        3 => (at(), at()).prop_map(|(a, b)| Call::SwapTargets(a, b)),
        3 => (at(), at()).prop_map(|(a, b)| Call::SwapWorkspaces(a, b)),
        1 => (at(), any::<bool>()).prop_map(|(a, other)| Call::NewTarget(a, other)),
        1 => at().prop_map(Call::NewWorkspace),
        6 => (at(), at(), at(), work()).prop_map(|(a, b, c, work)| Call::Begin(a, b, c, work)),
        4 => (at(), at(), at(), at(), work()).prop_map(|(a, b, c, d, work)| Call::BeginLock(a, b, c, d, work)),
        6 => (at(), at(), work()).prop_map(|(a, b, work)| Call::Step(a, b, work)),
        4 => (at(), at()).prop_map(|(a, b)| Call::Finish(a, b)),
        2 => (at(), at(), at()).prop_map(|(a, b, c)| Call::Update(a, b, c)),
        1 => (at(), turn(), turn()).prop_map(|(a, right, down)| Call::Moved(a, right, down)),
        2 => (at(), at()).prop_map(|(a, b)| Call::Copy(a, b)),
    ];
    prop::collection::vec(call, 1..40)
}

/// The state of a target, as the model sees it.
#[derive(Clone, PartialEq)]
enum State {
    Empty,
    Following(Vec<u8>),
    Locking(Rect, Vec<i32>),
}

struct Slot<T> {
    target: T,
    other: bool,
    /// The box of the lock that is under way.
    locking: Option<Rect>,
}

impl<T: Learning> Slot<T> {
    fn new(config: T::Config, other: bool) -> Self {
        let config = if other { T::other(config) } else { config };
        Self { target: T::new(config).unwrap(), other, locking: None }
    }

    fn state(&self) -> State {
        match self.locking {
            Some(place) => State::Locking(place, self.target.learned()),
            None if self.target.state().is_some() => State::Following(saved(&self.target)),
            None => State::Empty,
        }
    }
}

/// The update or lock under way in a workspace: its targets and its frame.
#[derive(Clone)]
struct Job {
    other: bool,
    state: State,
    frame: usize,
}

struct Scene<T: Learning> {
    config: T::Config,
    frames: Vec<Vec<u8>>,
    targets: Vec<Slot<T>>,
    workspaces: Vec<(T::Workspace, Option<Job>)>,
}

impl<T: Learning> Scene<T> {
    /// Two different targets, a copy of the first, one with another configuration, and an empty one.
    fn new(config: T::Config) -> Self {
        let frames: Vec<_> = [(60, 45), (62, 42), (66, 47)].map(|(x, y)| picture(x, y)).into();
        let mut targets: Vec<Slot<T>> =
            [false, false, false, true, false].map(|other| Slot::new(config, other)).into_iter().collect();
        let mut workspace = T::Workspace::default();
        for (slot, place) in targets.iter_mut().zip([PLACES[0], PLACES[1], PLACES[0], PLACES[0]]) {
            slot.target.lock(&mut workspace, &whole(&frames[0]), place).unwrap();
        }
        let workspaces = vec![(workspace, None), (T::Workspace::default(), None)];
        Self { config, frames, targets, workspaces }
    }

    /// The first target, from these numbers on, that can continue the job of a workspace, and that workspace; those
    /// with these numbers if there is none.
    fn pair(&self, target: Index, workspace: Index) -> (usize, usize) {
        let (targets, workspaces) = (self.targets.len(), self.workspaces.len());
        let (first, second) = (target.index(targets), workspace.index(workspaces));
        let pairs = (0..targets * workspaces)
            .map(|number| ((first + number / workspaces) % targets, (second + number % workspaces) % workspaces));
        pairs.clone().find(|&(a, b)| self.belongs(a, b)).unwrap_or((first, second))
    }

    fn belongs(&self, target: usize, workspace: usize) -> bool {
        let slot = &self.targets[target];
        self.workspaces[workspace].1.as_ref().is_some_and(|job| job.other == slot.other && job.state == slot.state())
    }

    /// Compares the model with `resume`, for every target in every workspace.
    fn check(&mut self) {
        for slot in &mut self.targets {
            let state = slot.state();
            for (memory, job) in &mut self.workspaces {
                let job = job.as_ref().filter(|job| job.other == slot.other && job.state == state);
                let frame = whole(&self.frames[job.map_or(0, |job| job.frame)]);
                let locks = job.is_some_and(|job| matches!(job.state, State::Locking(..)));
                assert_eq!(slot.target.resume(memory, &frame).is_ok(), job.is_some() && !locks);
                assert_eq!(slot.target.resume_lock(memory, &frame).is_ok(), locks);
            }
        }
    }

    /// Continues the update or lock under way, if it belongs to the target.
    fn go_on(&mut self, target: usize, workspace: usize, work: Option<u32>) {
        if !self.belongs(target, workspace) {
            return;
        }
        let slot = &mut self.targets[target];
        let (memory, under_way) = &mut self.workspaces[workspace];
        let Some(job) = under_way else { return };
        let frame = whole(&self.frames[job.frame]);
        let mut twin = Slot::<T>::new(self.config, slot.other).target;
        let mut own = T::Workspace::default();
        match (&mut job.state, work) {
            (State::Locking(..), Some(work)) => {
                slot.target.resume_lock(memory, &frame).unwrap().step(work);
                job.state = slot.state();
            }
            (State::Locking(place, _), None) => {
                let quality = slot.target.resume_lock(memory, &frame).unwrap().finish();
                assert_eq!(quality, twin.lock(&mut own, &frame, *place).unwrap());
                (slot.locking, *under_way) = (None, None);
                assert!(saved(&slot.target) == saved(&twin));
            }
            (_, Some(work)) => {
                slot.target.resume(memory, &frame).unwrap().step(work);
            }
            (State::Following(bytes), None) => {
                let answer = slot.target.resume(memory, &frame).unwrap().finish();
                twin.restore(bytes).unwrap();
                assert_eq!(answer, twin.update(&mut own, &frame).unwrap());
                *under_way = None;
                assert!(saved(&slot.target) == saved(&twin));
            }
            (State::Empty, None) => unreachable!("nothing begins on an empty target"),
        }
    }

    fn call(&mut self, call: &Call) {
        let (targets, workspaces, frames) = (self.targets.len(), self.workspaces.len(), self.frames.len());
        match *call {
            Call::SwapTargets(a, b) => self.targets.swap(a.index(targets), b.index(targets)),
            Call::SwapWorkspaces(a, b) => self.workspaces.swap(a.index(workspaces), b.index(workspaces)),
            Call::NewTarget(a, other) => self.targets[a.index(targets)] = Slot::new(self.config, other),
            Call::NewWorkspace(a) => self.workspaces[a.index(workspaces)] = (T::Workspace::default(), None),
            Call::Begin(a, b, frame, work) => {
                let (slot, frame) = (&mut self.targets[a.index(targets)], frame.index(frames));
                let state = slot.state();
                let (memory, job) = &mut self.workspaces[b.index(workspaces)];
                if let Ok(mut update) = slot.target.begin(memory, &whole(&self.frames[frame])) {
                    update.step(work);
                    *job = Some(Job { other: slot.other, state, frame });
                }
            }
            Call::BeginLock(a, b, frame, place, work) => {
                let (slot, frame, place) =
                    (&mut self.targets[a.index(targets)], frame.index(frames), place.get(&PLACES));
                let (memory, job) = &mut self.workspaces[b.index(workspaces)];
                slot.target.begin_lock(memory, &whole(&self.frames[frame]), *place).unwrap().step(work);
                slot.locking = Some(*place);
                *job = Some(Job { other: slot.other, state: slot.state(), frame });
            }
            Call::Step(a, b, work) => {
                let (target, workspace) = self.pair(a, b);
                self.go_on(target, workspace, Some(work));
            }
            Call::Finish(a, b) => {
                let (target, workspace) = self.pair(a, b);
                self.go_on(target, workspace, None);
            }
            Call::Update(a, b, frame) => {
                let slot = &mut self.targets[a.index(targets)];
                let (memory, job) = &mut self.workspaces[b.index(workspaces)];
                if slot.target.update(memory, &whole(&self.frames[frame.index(frames)])).is_ok() {
                    *job = None;
                }
            }
            Call::Moved(a, right, down) => {
                let slot = &mut self.targets[a.index(targets)];
                slot.target.moved(right, down);
                slot.locking = None;
            }
            Call::Copy(a, b) => {
                if let State::Following(bytes) = self.targets[a.index(targets)].state() {
                    let slot = &mut self.targets[b.index(targets)];
                    if slot.target.restore(&bytes).is_ok() {
                        slot.locking = None;
                    }
                }
            }
        }
    }
}

pub(super) fn whoever_moves_whatever_is_under_way_goes_on_with_its_own_target<T: Learning>(config: T::Config) {
    assert!(PLACES.iter().all(|&place| Rect::new(0, 0, SIZE.0, SIZE.1).contains(place)));
    let cases = ProptestConfig { cases: 32, failure_persistence: None, ..ProptestConfig::default() };
    proptest!(cases, |(calls in calls())| {
        let mut scene = Scene::<T>::new(config);
        for call in &calls {
            scene.call(call);
            scene.check();
        }
    });
}
