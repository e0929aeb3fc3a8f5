//! Instructions of the most expensive functions, counted by valgrind. `.ci/run instructions` compares them with the
//! recorded counts. The benches name their backends, so that the counts do not depend on the machine.

#![allow(unused_qualifications)] // in what the macros write

use gungraun::{library_benchmark, library_benchmark_group, main};
use smr_bench::{self as scene, Patch, Prepared, Small};
use smr_core::similarity::{Backend, Table};
use smr_core::unstable::{CutTable, Scorer};
use smr_core::{Answer, Image, Rect};
use std::hint::black_box;

/// A typical threshold in gray levels: a quarter (the paper's k) of the largest change of a pixel from one template to
/// the next.
const THRESHOLD: u16 = 30;

fn scorer(backend: Backend) -> (Scorer<'static>, Patch) {
    let table = Box::leak(Box::new(CutTable::new(&Table::PAPER, THRESHOLD)));
    (Scorer::new(backend, table), scene::patch())
}

fn pictures(patch: &Patch) -> (Image<'_>, Image<'_>) {
    let whole = |frame: &Rect| Rect::new(0, 0, frame.width, frame.height);
    let template = patch.template.frame().patch(whole(&patch.target)).expect("it is whole");
    (patch.frame.frame().patch(patch.target).expect("the box lies in the frame"), template)
}

#[library_benchmark(setup = scorer)]
#[bench::scalar(Backend::Scalar)]
#[bench::avx2(Backend::Avx2)]
fn score_64x64((scorer, patch): (Scorer<'static>, Patch)) -> (Option<u32>, Scorer<'static>, Patch) {
    let (f, g) = pictures(&patch);
    (black_box(scorer.score(f, g)), scorer, patch)
}

#[library_benchmark(setup = scorer)]
#[bench::scalar(Backend::Scalar)]
#[bench::avx2(Backend::Avx2)]
fn distance_64x64((scorer, patch): (Scorer<'static>, Patch)) -> (Option<u32>, Scorer<'static>, Patch) {
    let (f, g) = pictures(&patch);
    (black_box(scorer.distance(f, g, u32::MAX)), scorer, patch)
}

fn pruned(backend: Backend, width: u16, height: u16) -> Prepared {
    Prepared::new(backend, true, scene::target(width, height))
}

#[library_benchmark(setup = pruned)]
#[bench::scalar_64x64(Backend::Scalar, 64, 64)]
#[bench::avx2_64x64(Backend::Avx2, 64, 64)]
#[bench::scalar_24x28(Backend::Scalar, 24, 28)]
#[bench::avx2_24x28(Backend::Avx2, 24, 28)]
fn update_pruned(mut prepared: Prepared) -> (Answer, Prepared) {
    (black_box(prepared.update()), prepared)
}

fn exhaustive(backend: Backend, width: u16, height: u16) -> Prepared {
    Prepared::new(backend, false, scene::target(width, height))
}

#[library_benchmark(setup = exhaustive)]
#[bench::scalar_24x28(Backend::Scalar, 24, 28)]
#[bench::avx2_24x28(Backend::Avx2, 24, 28)]
#[bench::avx2_64x64(Backend::Avx2, 64, 64)]
fn update_exhaustive(mut prepared: Prepared) -> (Answer, Prepared) {
    (black_box(prepared.update()), prepared)
}

fn unlocked() -> (Box<Small>, Patch) {
    (scene::tracker(Backend::Scalar, true), scene::patch())
}

#[library_benchmark(setup = unlocked)]
fn lock_64x64((mut tracker, patch): (Box<Small>, Patch)) -> (Box<Small>, Patch) {
    tracker.lock(&patch.frame.frame(), patch.target).expect("the box lies in the frame");
    (black_box(tracker), patch)
}

library_benchmark_group!(
    name = cases,
    benchmarks = [score_64x64, distance_64x64, update_pruned, update_exhaustive, lock_64x64]
);

main!(library_benchmark_groups = cases);
