//! Estimated cycles, as people read them.

use crate::emulator::cycles::{Chip, Estimate, Share};
use std::io::{self, Write};

pub fn describe(estimates: &[Estimate], out: &mut impl Write) -> io::Result<()> {
    let million = |cycles: u64| cycles as f64 / 1e6;
    writeln!(
        out,
        "  estimated cycles, in millions; waits for memory, caches and branches predicted wrongly are not counted:"
    )?;
    for Estimate { processor, lock, update, per_instruction, unknown, chips, .. } in estimates {
        let [median, max] = [update.median, update.max].map(million);
        write!(out, "    {processor}: lock {:.2}, update median {median:.3}, at most {max:.3}; ", million(*lock))?;
        write!(out, "{per_instruction:.2} an instruction")?;
        if *unknown > 0.0 {
            write!(out, ", {:.1} % of which are not in LLVM's model and count as one cycle", 100.0 * unknown)?;
        }
        writeln!(out)?;
        for Chip { chip, megahertz, updates_a_second, at_least } in chips {
            writeln!(
                out,
                "      {chip} at {megahertz} MHz: {updates_a_second:.0} updates a second, at least {at_least:.0}"
            )?;
        }
    }
    let Some(Estimate { processor, functions, .. }) = estimates.first() else { return Ok(()) };
    writeln!(out, "  where the cycles of the updates go on the {processor}, and the cycles of an instruction there:")?;
    for Share { function, cycles, per_instruction } in functions {
        writeln!(out, "    {:4.1} %  {per_instruction:.2}  {function}", 100.0 * cycles)?;
    }
    Ok(())
}
