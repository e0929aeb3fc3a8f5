//! Tests that targets which share workspaces never continue the update or lock of another one.

use super::*;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

/// A target that is called in steps in any workspace, and a tracker that does the same at once.
struct Pair<T: Target> {
    target: T,
    plain: Box<Tracker<T>>,
    /// The picture of the next call. Each pair begins with another one.
    next: usize,
}

/// Boxes of which each pair locks one.
const BOXES: [Rect; 3] = [TARGET, Rect::new(20, 30, 24, 20), Rect::new(100, 70, 20, 24)];

#[derive(Clone, Copy, Debug)]
enum Op {
    /// A step of this pair in this workspace, with 1/16 of the work of a usual update for each unit of the number.
    Step(usize, usize, u32),
    /// A whole update.
    Update(usize, usize),
    /// A step of a lock.
    Lock(usize, usize, u32),
    /// The targets of two pairs change places in memory.
    Swap(usize, usize),
    /// The workspaces change places in memory.
    SwapWorkspaces,
    /// The workspace is replaced by a new one.
    Reset(usize),
    Moved(usize),
    Restore(usize),
    Cancel(usize),
    /// Calls that are refused.
    Refused(usize, usize),
}

/// Not the calls that replace workspaces: see the limit that `Ticket` has.
fn op() -> impl Strategy<Value = Op> {
    let (pair, workspace) = (|| 0..BOXES.len(), || 0..2_usize);
    prop_oneof![
        12 => (pair(), workspace(), 0..24_u32).prop_map(|(pair, workspace, part)| Op::Step(pair, workspace, part)),
        1 => (pair(), workspace()).prop_map(|(pair, workspace)| Op::Update(pair, workspace)),
        3 => (pair(), workspace(), 0..24_u32).prop_map(|(pair, workspace, part)| Op::Lock(pair, workspace, part)),
        3 => (pair(), pair()).prop_map(|(pair, other)| Op::Swap(pair, other)),
        1 => pair().prop_map(Op::Moved),
        1 => pair().prop_map(Op::Restore),
        1 => pair().prop_map(Op::Cancel),
        2 => (pair(), workspace()).prop_map(|(pair, workspace)| Op::Refused(pair, workspace)),
    ]
}

fn usual<T: Target>(config: T::Config) -> [u32; 2] {
    let mut tracker = of_scene::<T>(config);
    let lock = tracker.work();
    tracker.update(&whole(&picture(TARGET.x + 3, TARGET.y + 2))).unwrap();
    [tracker.work(), lock]
}

struct Shared<T: Target> {
    pairs: Vec<Pair<T>>,
    workspaces: [Box<T::Workspace>; 2],
    pictures: Vec<Vec<u8>>,
    /// The work of a usual update and of a lock.
    usual: [u32; 2],
    done: usize,
}

impl<T: Target> Shared<T> {
    fn new(config: T::Config) -> Self {
        let pictures = frames();
        let pairs = BOXES.iter().enumerate().map(|(next, &bbox)| {
            let mut target = T::with(config).unwrap();
            target.lock(&mut T::Workspace::default(), &whole(&pictures[next]), bbox).unwrap();
            Pair { target, plain: locked(config, &whole(&pictures[next]), bbox), next }
        });
        let pairs = pairs.collect();
        Self { pairs, workspaces: Default::default(), pictures, usual: usual::<T>(config), done: 0 }
    }

    fn apply(&mut self, op: Op) {
        let Self { pairs, workspaces, pictures, usual, done } = self;
        let count = pictures.len();
        match op {
            Op::Step(pair, workspace, part) => {
                let Pair { target, plain, next } = &mut pairs[pair];
                let frame = whole(&pictures[*next % count]);
                if target.state().is_none() {
                    // A lock was discarded, or has not ended.
                    assert_eq!(target.update_step(&mut workspaces[workspace], &frame, 1), Err(UpdateError::NotLocked));
                    return;
                }
                let step = target.update_step(&mut workspaces[workspace], &frame, usual[0] / 16 * part);
                if let Some(answer) = step.unwrap() {
                    assert_eq!(plain.update(&frame), Ok(answer));
                    assert!(saved(target) == saved(plain.target()));
                    (*next, *done) = (*next + 1, *done + 1);
                }
            }
            Op::Update(pair, workspace) => {
                let Pair { target, plain, next } = &mut pairs[pair];
                let frame = whole(&pictures[*next % count]);
                if target.state().is_some() {
                    assert_eq!(target.update(&mut workspaces[workspace], &frame), plain.update(&frame));
                    *next += 1;
                }
            }
            Op::Lock(pair, workspace, part) => {
                let Pair { target, plain, next } = &mut pairs[pair];
                let frame = whole(&pictures[*next % count]);
                let bbox = BOXES[(*next + pair) % BOXES.len()];
                let step = target.lock_step(&mut workspaces[workspace], &frame, bbox, usual[1] / 16 * part);
                if let Some(quality) = step.unwrap() {
                    assert_eq!(plain.lock(&frame, bbox), Ok(quality));
                    assert!(saved(target) == saved(plain.target()));
                    (*next, *done) = (*next + 1, *done + 1);
                }
            }
            Op::Swap(pair, other) => pairs.swap(pair, other),
            Op::SwapWorkspaces => {
                let [first, second] = workspaces;
                core::mem::swap(&mut **first, &mut **second);
            }
            Op::Reset(workspace) => *workspaces[workspace] = T::Workspace::default(),
            Op::Moved(pair) => {
                let Pair { target, plain, .. } = &mut pairs[pair];
                if target.state().is_some() {
                    target.moved(300, -200);
                    plain.moved(300, -200);
                }
            }
            Op::Restore(pair) => {
                let Pair { target, plain, .. } = &mut pairs[pair];
                if target.state().is_some() {
                    target.restore(&saved(plain.target())).unwrap();
                }
            }
            Op::Cancel(pair) => pairs[pair].target.cancel(),
            Op::Refused(pair, workspace) => {
                let (target, workspace) = (&mut pairs[pair].target, &mut workspaces[workspace]);
                let (work, corner) = (T::work(workspace), cut(&whole(&pictures[0]), Rect::new(0, 0, 1, 1)));
                assert!(target.update_step(workspace, &corner, 9).is_err());
                assert!(target.update_step_until(workspace, &corner, || false).is_err());
                assert!(target.lock_step(workspace, &corner, TARGET, 9).is_err());
                assert_eq!(T::work(workspace), work);
            }
        }
    }
}

pub(super) fn no_target_continues_the_call_of_another<T: Target>(config: T::Config) {
    let numbers = ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(24) };
    let numbers = ProptestConfig { max_shrink_time: 20_000, ..numbers };
    let done = core::cell::Cell::new(0);
    let ran = TestRunner::new(numbers).run(&prop::collection::vec(op(), 1..120), |ops| {
        let mut shared = Shared::<T>::new(config);
        ops.into_iter().for_each(|op| shared.apply(op));
        done.set(done.get() + shared.done);
        Ok(())
    });
    ran.unwrap();
    assert!(done.get() > 100, "only {} calls were done in steps", done.get());
    // In each of these, the targets and workspaces have the same history, so that their calls have the same count.
    let [first, second] = [(0, 0), (1, 1)].map(|(pair, workspace)| Op::Step(pair, workspace, 3));
    let [first_lock, second_lock] = [(0, 0), (1, 1)].map(|(pair, workspace)| Op::Lock(pair, workspace, 3));
    let [end, other_end] = [0, 1].map(|workspace| Op::Step(0, workspace, 40));
    for ops in [
        // Targets or workspaces that change places in the middle of their calls.
        &[first, second, Op::Swap(0, 1), end, Op::Step(1, 1, 40)][..],
        &[first, second, Op::SwapWorkspaces, end, Op::Step(1, 1, 40)],
        &[first_lock, second_lock, Op::Swap(0, 1), Op::Lock(0, 0, 40), Op::Lock(1, 1, 40)],
        // Targets that change places twice, between updates in two workspaces.
        &[first, Op::Swap(0, 1), Op::Step(0, 1, 3), Op::Swap(0, 1), other_end],
        // A new workspace at the same place for each frame, and targets that are sorted between two frames.
        &[first, Op::Swap(0, 1), Op::Reset(0), first, Op::Step(1, 0, 40)],
        // An update in another workspace in the middle of one.
        &[first, other_end, end],
        &[first, Op::Update(0, 1), end],
        &[first, Op::Moved(0), end],
        &[first, Op::Restore(0), Op::Cancel(0), end],
    ] {
        let mut shared = Shared::<T>::new(config);
        ops.iter().for_each(|&op| shared.apply(op));
    }
}

/// Targets that are stepped to the end one after the other take as many steps as alone, in place of each other, and
/// wherever their tracker is moved.
pub(super) fn a_shared_workspace_costs_no_step<T: Target>(config: T::Config) {
    let (first, second) = (picture(TARGET.x, TARGET.y), picture(TARGET.x + 3, TARGET.y + 2));
    let grant = usual::<T>(config)[0] / 20;
    let mut alone = locked::<T>(config, &whole(&first), TARGET);
    let mut steps = vec![alone.update_step(&whole(&second), grant).unwrap()];
    while steps.last() == Some(&None) {
        let mut moved = Box::new(Tracker::<T>::with(config).unwrap());
        core::mem::swap(&mut *moved, &mut *alone);
        alone = moved; // the whole tracker is elsewhere
        steps.push(alone.update_step(&whole(&second), grant).unwrap());
    }
    assert!(steps.len() > 2);
    let mut workspace = T::Workspace::default();
    let mut targets = [(); 3].map(|()| T::with(config).unwrap());
    for target in &mut targets {
        target.lock(&mut workspace, &whole(&first), TARGET).unwrap();
    }
    for target in &mut targets {
        let taken: Vec<_> =
            steps.iter().map(|_| target.update_step(&mut workspace, &whole(&second), grant).unwrap()).collect();
        assert_eq!(taken, steps);
    }
    // A step of another target discards the update under way, and a call that fails does not.
    let [one, other, _] = &mut targets;
    let third = picture(TARGET.x + 5, TARGET.y + 4);
    let mut expected = locked::<T>(config, &whole(&first), TARGET);
    expected.update(&whole(&second)).unwrap();
    let answer = expected.update(&whole(&third)).unwrap();
    assert_eq!(one.update_step(&mut workspace, &whole(&third), 1), Ok(None));
    let work = T::work(&workspace);
    assert_eq!(other.update_step(&mut workspace, &cut(&whole(&third), Rect::new(0, 0, 1, 1)), 1).ok(), None);
    assert_eq!(one.update_step(&mut workspace, &whole(&third), 1), Ok(None));
    assert!(T::work(&workspace) > work, "a call that fails discards nothing");
    assert_eq!(other.update_step(&mut workspace, &whole(&third), 1), Ok(None));
    assert_eq!(one.update_step_until(&mut workspace, &whole(&third), || false), Ok(Some(answer)));
    assert_eq!(other.update_step_until(&mut workspace, &whole(&third), || false), Ok(Some(answer)));
    // After a discarded lock there is no target.
    assert_eq!(one.update_step(&mut workspace, &whole(&third), 1), Ok(None));
    one.cancel();
    assert_eq!(one.bbox(), Some(answer.fine));
    if one.lock_step(&mut workspace, &whole(&third), TARGET, 1) == Ok(None) {
        one.cancel();
        assert_eq!(one.update_step(&mut workspace, &whole(&third), 1), Err(UpdateError::NotLocked));
    }
}
