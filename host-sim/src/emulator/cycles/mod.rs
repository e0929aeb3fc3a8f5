//! Estimated cycles of what firmware does in QEMU, which itself counts instructions only.
//!
//! - [`trace`]: QEMU says which blocks of code run, in what order.
//! - [`mod@program`]: the instructions of these blocks, and the functions that they are in.
//! - [`processor`]: the cycles of a block on each processor.
//!
//! Each block counts as if it ran again and again, and the branch at its end as taken or not, as in the trace. What is left out:
//! waits for memory, caches, branches that a processor predicts wrongly, and stalls from one block into the next.

pub mod processor;
pub mod program;
pub mod trace;

use super::qemu::{Machine, Qemu};
use crate::percentiles::Spread;
use anyhow::{Context, Result, anyhow, bail};
use processor::Processor;
use program::Program;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::thread::{self, JoinHandle};
use trace::{Block, Runs, Span};

/// The functions that are named, those with the most cycles first.
const FUNCTIONS: usize = 10;

/// The parts of a cycle in which costs are counted: LLVM runs each block so often.
const PARTS: u64 = 50;

/// The cycles on one processor.
#[derive(Clone, Debug, Serialize)]
pub struct Estimate {
    pub processor: &'static str,
    pub lock: u64,
    /// Cycles of an update.
    pub update: Spread<u64>,
    /// Instructions of an update in the trace. QEMU's own count is `instructions` of the report.
    pub traced: Spread<u64>,
    /// Cycles of an instruction, on average over all updates.
    pub per_instruction: f64,
    /// Instructions that the model does not know, as a fraction: they count as one cycle.
    pub unknown: f64,
    pub chips: Vec<Chip>,
    /// Where the cycles of the updates go.
    pub functions: Vec<Share>,
}

/// How many updates a second a chip makes at its usual clock.
#[derive(Clone, Debug, Serialize)]
pub struct Chip {
    pub chip: &'static str,
    pub megahertz: u32,
    /// By the median of an update, and by the most expensive one.
    pub updates_a_second: f64,
    pub at_least: f64,
}

/// What one function takes of all updates, without the functions that it calls.
#[derive(Clone, Debug, Serialize)]
pub struct Share {
    pub function: String,
    /// As a fraction of all cycles.
    pub cycles: f64,
    pub per_instruction: f64,
}

/// Reads the program that is to be traced.
/// Errors: no processor of this machine has a model, or there is no LLVM.
pub fn program(machine: Machine, elf: &Path) -> Result<Program> {
    let Some(processor) = Processor::of(machine).next() else {
        bail!("--cycles: {} has a processor without a model: expected a Cortex-M", machine.name())
    };
    Program::of(elf, processor.name)
}

/// Reads the trace of a running QEMU in a thread of its own, to its end.
/// Errors: the program does not measure.
pub fn reader(qemu: &mut Qemu, program: &Program) -> Result<Reader> {
    let (mark, trace) = (program.mark()?, qemu.log().context("QEMU's trace is piped")?);
    Ok(Reader(thread::spawn(move || trace::spans(trace, mark))))
}

/// A thread that reads a trace.
pub struct Reader(JoinHandle<Result<Vec<Span>>>);

impl Reader {
    /// All measurements, once QEMU has ended.
    pub fn spans(self) -> Result<Vec<Span>> {
        self.0.join().map_err(|_| anyhow!("QEMU's trace cannot be read"))?
    }
}

/// What the first measurement, the lock, and the others, the updates, take on each processor of `machine`.
/// Errors: there is none, or no LLVM.
pub fn estimates(machine: Machine, program: &Program, spans: &[Span]) -> Result<Vec<Estimate>> {
    let [lock, updates @ ..] = spans else {
        bail!(
            "the firmware measured nothing: expected two calls of {} around the lock, and around each update",
            trace::MARK
        )
    };
    let blocks: BTreeSet<Block> = spans.iter().flat_map(|span| span.keys().copied()).collect();
    let codes: Vec<(Block, Vec<&str>)> = blocks.into_iter().map(|block| (block, program.code(block))).collect();
    let on = |processor: &'static Processor| -> Result<Estimate> {
        let costs = processor.costs(&codes)?;
        Ok(estimate(processor, program, &costs, lock, updates))
    };
    Processor::of(machine).map(on).collect()
}

fn estimate(
    processor: &'static Processor,
    program: &Program,
    costs: &Costs,
    lock: &Span,
    updates: &[Span],
) -> Estimate {
    let sums: Vec<Sum> = updates.iter().map(|span| Sum::of(span, costs)).collect();
    let cycles: Vec<u64> = sums.iter().map(|sum| sum.cycles()).collect();
    let all = sums.iter().fold(Sum::default(), |all, &sum| all.and(sum));
    let update = Spread::of(&cycles);
    let chips = processor.chips().map(|(chip, megahertz)| {
        let [updates_a_second, at_least] =
            [update.median, update.max].map(|cycles| f64::from(megahertz) * 1e6 / cycles.max(1) as f64);
        Chip { chip, megahertz, updates_a_second, at_least }
    });
    Estimate {
        processor: processor.name,
        lock: Sum::of(lock, costs).cycles(),
        update,
        traced: Spread::of(&sums.iter().map(|sum| sum.instructions).collect::<Vec<_>>()),
        per_instruction: all.per_instruction(),
        unknown: all.unknown as f64 / all.instructions.max(1) as f64,
        chips: chips.collect(),
        functions: shares(program, costs, updates, all.parts),
    }
}

/// By address and size of each block.
pub type Costs = BTreeMap<Block, Cost>;

/// What a block takes each time that it runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    pub instructions: u64,
    /// Of these, those that LLVM's model does not know.
    pub unknown: u64,
    /// In parts of a cycle.
    pub parts: u64,
    /// What comes to it if the branch at its end is taken, in parts of a cycle.
    pub taken: u64,
}

/// What some blocks take together.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    instructions: u64,
    unknown: u64,
    parts: u64,
}

impl Sum {
    fn of(span: &Span, costs: &Costs) -> Self {
        span.iter().fold(Self::default(), |sum, (block, runs)| sum.and(Self::of_block(costs.get(block), *runs)))
    }

    fn of_block(cost: Option<&Cost>, Runs { all, taken }: Runs) -> Self {
        let cost = cost.copied().unwrap_or_default();
        let parts = cost.parts * all + cost.taken * taken;
        Self { instructions: cost.instructions * all, unknown: cost.unknown * all, parts }
    }

    fn and(self, other: Self) -> Self {
        Self {
            instructions: self.instructions + other.instructions,
            unknown: self.unknown + other.unknown,
            parts: self.parts + other.parts,
        }
    }

    fn cycles(self) -> u64 {
        self.parts / PARTS
    }

    fn per_instruction(self) -> f64 {
        self.parts as f64 / (PARTS * self.instructions.max(1)) as f64
    }
}

fn shares(program: &Program, costs: &Costs, updates: &[Span], all: u64) -> Vec<Share> {
    let mut functions = BTreeMap::<&str, Sum>::new();
    for (block, runs) in updates.iter().flatten() {
        let sum = functions.entry(program.function(block.start)).or_default();
        *sum = sum.and(Sum::of_block(costs.get(block), *runs));
    }
    let mut shares: Vec<Share> = functions
        .into_iter()
        .map(|(function, sum)| Share {
            function: function.to_owned(),
            cycles: sum.parts as f64 / all.max(1) as f64,
            per_instruction: sum.per_instruction(),
        })
        .collect();
    shares.sort_by(|a, b| b.cycles.total_cmp(&a.cycles));
    shares.truncate(FUNCTIONS);
    shares
}
