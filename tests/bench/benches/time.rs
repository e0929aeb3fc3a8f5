//! Time of the most expensive functions, for every backend of this machine: `cargo bench -p smr-bench --bench time`.

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use smr_bench::{self as scene, Prepared};
use smr_core::similarity::{Backend, Table};
use smr_core::unstable::{CutTable, Scorer};
use smr_core::{Image, Rect};
use std::hint::black_box;

/// A typical threshold in gray levels: a quarter (the paper's k) of the largest change of a pixel from one template to
/// the next.
const THRESHOLD: u16 = 30;

fn score(criterion: &mut Criterion) {
    let patch = scene::patch();
    let f = patch.frame.frame().patch(patch.target).expect("the box lies in the frame");
    let Rect { width, height, .. } = patch.target;
    let g = Image::new(&patch.template.pixels, width, height).expect("it is whole");
    let mut group = criterion.benchmark_group("score 64x64");
    let table = CutTable::new(&Table::PAPER, THRESHOLD);
    for backend in Backend::available() {
        let scorer = Scorer::new(backend, &table);
        group.bench_function(format!("{backend:?}"), |bencher| {
            bencher.iter(|| scorer.score(black_box(f), black_box(g)));
        });
    }
}

fn update(criterion: &mut Criterion) {
    for (width, height) in [(64, 64), (24, 28)] {
        let mut group = criterion.benchmark_group(format!("update {width}x{height}, +-16"));
        for backend in Backend::available() {
            for (name, pruning) in [("pruned", true), ("exhaustive", false)] {
                let prepare = || Prepared::new(backend, pruning, scene::target(width, height));
                group.bench_function(format!("{backend:?}, {name}"), |bencher| {
                    bencher.iter_batched_ref(prepare, Prepared::update, BatchSize::LargeInput);
                });
            }
        }
    }
}

criterion_group!(benches, score, update);
criterion_main!(benches);
