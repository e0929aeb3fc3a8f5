//! The cycles of a block of code on a processor: by `llvm-mca`, with what its models leave out.
//!
//! LLVM's models leave out four things, which are added here:
//! - the words after the first that one instruction loads or stores,
//! - a branch that is taken,
//! - a division on the Cortex-M4, M33 and M55, which takes 2 to 12 cycles,
//! - the cycle that a Cortex-M4 loses between two loads that step the same address on.
//!
//! The model of the Cortex-M33 is that of the M4. The Cortex-M0+ has no model; its manual states every cycle.

use super::program::llvm;
use super::trace::Block;
use super::{Cost, Costs, PARTS};
use crate::emulator::qemu::Machine;
use anyhow::{Context, Result};
use serde::Deserialize;
use smr_recordings::output::Exchange;
use std::fs;

/// A processor, and what its instructions cost in cycles.
#[derive(Debug)]
pub struct Processor {
    pub name: &'static str,
    /// What runs its firmware.
    machine: Machine,
    /// LLVM has a model of it.
    modelled: bool,
    /// A branch that is taken, beyond one that is not.
    taken: u64,
    /// Each word after the first that one instruction loads or stores, in parts of a cycle.
    word: u64,
    /// A division, beyond the model.
    division: u64,
    /// A load that steps its address on, right behind another one by the same address.
    stepped: u64,
    /// Chips with it, and their clocks in megahertz.
    chips: &'static [(&'static str, u32)],
}

/// A branch that is taken costs 1 + P cycles by Arm's manual, where P is 1 to 3.
const M4: Processor = Processor {
    name: "cortex-m4",
    machine: Machine::Mps2An386,
    modelled: true,
    taken: 2,
    word: PARTS,
    division: 6,
    stepped: 1,
    chips: &[("STM32F407", 168)],
};

/// It predicts branches, and moves two words in a cycle.
const M7: Processor = Processor {
    name: "cortex-m7",
    machine: Machine::Mps2An500,
    modelled: true,
    taken: 1,
    word: PARTS / 2,
    division: 0,
    stepped: 0,
    chips: &[("STM32H743", 480)],
};

const PROCESSORS: [Processor; 6] = [
    Processor {
        name: "cortex-m0plus",
        machine: Machine::Mps2An385,
        modelled: false,
        taken: 1,
        chips: &[("RP2040", 133)],
        ..M4
    },
    M4,
    Processor { name: "cortex-m33", chips: &[("RP2350", 150), ("nRF5340", 128)], ..M4 },
    M7,
    Processor {
        name: "cortex-m55",
        machine: Machine::Mps3An547,
        word: PARTS / 2,
        stepped: 0,
        chips: &[("STM32N6", 800), ("Alif E7", 400)],
        ..M4
    },
    Processor { name: "cortex-m85", machine: Machine::Mps3An547, chips: &[("RA8M1", 480)], ..M7 },
];

impl Processor {
    /// Those that firmware for this machine runs on.
    pub fn of(machine: Machine) -> impl Iterator<Item = &'static Self> {
        const { &PROCESSORS }.iter().filter(move |processor| processor.machine == machine)
    }

    pub fn chips(&self) -> impl Iterator<Item = (&'static str, u32)> {
        self.chips.iter().copied()
    }

    /// What each block takes.
    /// Errors: there is no `llvm-mca`, or it refuses.
    pub fn costs(&self, codes: &[(Block, Vec<&str>)]) -> Result<Costs> {
        if !self.modelled {
            return Ok(codes.iter().map(|(block, code)| (*block, self.by_manual(code))).collect());
        }
        let modelled = self.model(codes)?;
        Ok(codes.iter().zip(modelled).map(|((block, code), known)| (*block, self.cost(code, known))).collect())
    }

    /// The cost of a block: of so many of its instructions LLVM knows the cycles, in parts.
    fn cost(&self, code: &[&str], (known, parts): (usize, u64)) -> Cost {
        let count = |number: usize| number as u64;
        let loop_ends = code.iter().filter(|text| is_loop_end(text)).count();
        let unknown = count(code.len().saturating_sub(loop_ends + known));
        let stepped =
            code.windows(2).filter(|pair| steps(pair[0]).is_some() && steps(pair[0]) == steps(pair[1])).count();
        let added: u64 = code.iter().map(|text| self.added(text)).sum();
        let taken = if code.last().is_some_and(|text| is_loop_end(text)) { 0 } else { self.taken };
        let parts = parts + added + PARTS * (unknown + self.stepped * count(stepped));
        Cost { instructions: count(code.len()), unknown, parts, taken: PARTS * taken }
    }

    /// The cost of a block by the manual of the Cortex-M0+, with a multiplier of one cycle.
    fn by_manual(&self, code: &[&str]) -> Cost {
        let cycles: usize = code.iter().map(|text| cycles_by_manual(text)).sum();
        Cost { instructions: code.len() as u64, unknown: 0, parts: PARTS * cycles as u64, taken: PARTS * self.taken }
    }

    /// How many instructions of each block LLVM's model knows, and the parts of cycles that they take.
    fn model(&self, codes: &[(Block, Vec<&str>)]) -> Result<Vec<(usize, u64)>> {
        let folder = Exchange::create()?;
        let file = folder.path().join("blocks.s");
        fs::write(&file, assembly(codes)).with_context(|| format!("cannot write {}", file.display()))?;
        let (processor, iterations) = (format!("-mcpu={}", self.name), format!("-iterations={PARTS}"));
        let mut arguments = [
            "-mtriple=thumb-none-eabihf",
            &processor,
            // The condition of an instruction is enough: an IT block may lie in two blocks of the trace.
            "-arm-implicit-it=always",
            "-call-latency=1",
            "-skip-unsupported-instructions=any",
            &iterations,
            "-all-views=false",
            "-summary-view",
            "-json",
        ]
        .map(str::to_owned)
        .to_vec();
        arguments.push(file.display().to_string());
        let output = llvm("llvm-mca", &arguments)?;
        let said: Said =
            serde_json::from_slice(&output.stdout).context("llvm-mca says something else than expected")?;
        let mut known = vec![(0, 0); codes.len()];
        let rounds = usize::try_from(PARTS)?;
        for region in said.regions {
            let Summary { instructions, cycles } = region.summary;
            if let Some(place) = region.name.parse().ok().and_then(|number: usize| known.get_mut(number)) {
                *place = (instructions / rounds, cycles);
            }
        }
        Ok(known)
    }

    /// What an instruction takes beyond LLVM's model, in parts of a cycle.
    fn added(&self, text: &str) -> u64 {
        let more_words = words(text).saturating_sub(1) as u64;
        let divides = text.starts_with("sdiv") || text.starts_with("udiv");
        more_words * self.word + u64::from(divides) * PARTS * self.division
    }
}

/// The end of a loop in hardware: from its second round on it takes no cycle.
fn is_loop_end(text: &str) -> bool {
    matches!(text.split(' ').next(), Some("le" | "letp"))
}

/// All blocks as input of `llvm-mca`: each is a region by its number.
fn assembly(codes: &[(Block, Vec<&str>)]) -> String {
    let mut text = String::new();
    for (number, (_, code)) in codes.iter().enumerate() {
        let lines: Vec<String> =
            code.iter().filter(|text| !is_loop_end(text)).map(|text| without_target(text)).collect();
        text += &format!("# LLVM-MCA-BEGIN {number}\n{}\n# LLVM-MCA-END\n", lines.join("\n"));
    }
    text
}

/// Gives a branch a target near by: the assembler may find its own out of reach.
fn without_target(text: &str) -> String {
    match text.rsplit_once(' ') {
        Some((rest, target)) if target.starts_with("0x") => format!("{rest} #4"),
        _ => text.to_owned(),
    }
}

/// The words that an instruction loads or stores; 0 if it does neither.
fn words(text: &str) -> usize {
    let operation = text.split(' ').next().unwrap_or_default();
    let moves_two = ["ldrd", "strd"].iter().any(|start| operation.starts_with(start));
    let moves_many = ["ldm", "stm", "push", "pop", "vldm", "vstm", "vpush", "vpop"];
    if moves_two {
        return 2;
    }
    let Some((_, registers)) =
        text.split_once('{').filter(|_| moves_many.iter().any(|start| operation.starts_with(start)))
    else {
        return usize::from(["ldr", "str"].iter().any(|start| operation.starts_with(start)));
    };
    let registers = registers.split('}').next().unwrap_or_default();
    let each = if registers.starts_with('d') { 2 } else { 1 };
    each * registers.split(',').count()
}

/// The register with the address of a load that steps it on.
fn steps(text: &str) -> Option<&str> {
    let (address, step) = text.strip_prefix("ldr")?.split_once('[')?.1.split_once(']')?;
    step.starts_with(',').then_some(address)
}

/// One cycle, and one more for each word that is loaded or stored, for a call, and for a return from the stack. A branch that is taken is
/// counted elsewhere.
fn cycles_by_manual(text: &str) -> usize {
    match text.split(' ').next().unwrap_or_default() {
        "bl" => 2,
        "mrs" | "msr" | "dsb" | "dmb" | "isb" => 3,
        "pop" if text.contains("pc") => 2 + words(text),
        _ => 1 + words(text),
    }
}

#[derive(Deserialize)]
struct Said {
    #[serde(rename = "CodeRegions")]
    regions: Vec<Region>,
}

#[derive(Deserialize)]
struct Region {
    #[serde(rename = "Name")]
    name: String,
    #[serde(rename = "SummaryView")]
    summary: Summary,
}

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Summary {
    instructions: usize,
    #[serde(rename = "TotalCycles")]
    cycles: u64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_that_are_moved() {
        let moved =
            ["push {r4, r5, r6, lr}", "ldrd r0, r1, [r2]", "vpush {d8, d9}", "vldm r0!, {s0, s1, s2}", "ldrb r0, [r1]"];
        assert_eq!(moved.map(words), [4, 2, 4, 3, 1]);
        assert_eq!(["add r0, r1", "pld [r0]"].map(words), [0, 0]);
    }

    #[test]
    fn loads_that_step_on() {
        let loads =
            ["ldr r0, [r1], #4", "ldrb r0, [r1], #1", "ldr r0, [r1, #4]", "ldr r0, [r1, r2]", "str r0, [r1], #4"];
        assert_eq!(loads.map(steps), [Some("r1"), Some("r1"), None, None, None]);
    }

    #[test]
    fn cycles_by_the_manual() {
        let code = ["push {r4, lr}", "ldr r0, [r1]", "adds r0, r0, #1", "bl 0x400", "pop {r4, pc}"];
        assert_eq!(code.map(cycles_by_manual), [3, 2, 1, 2, 4]);
    }

    #[test]
    fn branches_lose_their_targets_and_loops_their_ends() {
        let codes =
            [(Block::default(), vec!["adds r0, #1", "bne.w 0x12340"]), (Block::default(), vec!["nop", "le lr, 0x40"])];
        let expected =
            "# LLVM-MCA-BEGIN 0\nadds r0, #1\nbne.w #4\n# LLVM-MCA-END\n# LLVM-MCA-BEGIN 1\nnop\n# LLVM-MCA-END\n";
        assert_eq!(assembly(&codes), expected);
    }
}
