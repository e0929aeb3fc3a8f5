//! QEMU's trace: which blocks of code ran between two calls of the firmware's `smr_ticks`.

use anyhow::{Context, Result};
use std::collections::HashMap;
use std::io::{BufRead, BufReader, Read};

/// The function that the firmware calls before and after what it measures.
pub const MARK: &str = "smr_ticks";

/// What makes QEMU write the trace: each block when it is translated, and each time that it runs.
pub const OPTIONS: [&str; 4] = ["-d", "exec,nochain,in_asm", "-D", "/dev/stdout"];

/// Code that runs from its start to its end: address and size in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Block {
    pub start: u32,
    pub size: u32,
}

/// How often a block ran, and how often something else than the code behind it ran next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Runs {
    pub all: u64,
    pub taken: u64,
}

/// What ran in one measurement.
pub type Span = HashMap<Block, Runs>;

/// Reads a trace to its end; `mark` is the address of [`MARK`].
/// Errors: those of the stream, and lines that are no trace of QEMU.
pub fn spans(trace: impl Read, mark: u32) -> Result<Vec<Span>> {
    let mut reader = BufReader::with_capacity(1 << 16, trace);
    let mut spans = Spans { mark, ..Spans::default() };
    let mut line = Vec::new();
    loop {
        line.clear();
        if reader.read_until(b'\n', &mut line).context("cannot read QEMU's trace")? == 0 {
            return Ok(spans.ended);
        }
        spans.line(line.trim_ascii_end())?;
    }
}

/// A block is translated for an address, and for a number of instructions if that is limited: QEMU's last field has it.
type Translated = (u32, u32);

#[derive(Default)]
struct Spans {
    mark: u32,
    sizes: HashMap<Translated, u32>,
    /// The block that is printed just now.
    printed: Option<Block>,
    /// The block that ran last.
    last: Option<Block>,
    current: Option<Span>,
    ended: Vec<Span>,
}

impl Spans {
    fn line(&mut self, line: &[u8]) -> Result<()> {
        if line.starts_with(b"Trace ") {
            self.ran(translated(line).with_context(|| unknown(line))?);
        } else if line.starts_with(b"0x") {
            let (address, size) = printed(line).with_context(|| unknown(line))?;
            let start = self.printed.map_or(address, |block| block.start);
            self.printed = Some(Block { start, size: address - start + size });
        } else if line.starts_with(b"Stopped execution") {
            // Of the block before: it had not begun.
            if let (Some(span), Some(last)) = (&mut self.current, self.last.take()) {
                span.entry(last).and_modify(|runs| runs.all -= 1);
            }
        } else if line.starts_with(b"IN:") {
            self.printed = None;
        }
        Ok(())
    }

    fn ran(&mut self, translated: Translated) {
        if let Some(block) = self.printed.take_if(|block| block.start == translated.0) {
            self.sizes.insert(translated, block.size);
        }
        let block = Block { start: translated.0, size: self.sizes.get(&translated).copied().unwrap_or(0) };
        let last = self.last.replace(block);
        let Some(span) = &mut self.current else {
            self.current = (block.start == self.mark).then(Span::new);
            return;
        };
        if let Some(last) = last.filter(|last| last.start + last.size != block.start) {
            // The mark that began the span is not part of it.
            span.entry(last).and_modify(|runs| runs.taken += 1);
        }
        if block.start == self.mark {
            self.ended.extend(self.current.take());
        } else {
            span.entry(block).or_default().all += 1;
        }
    }
}

fn unknown(line: &[u8]) -> String {
    format!("QEMU's trace has a line that is not known here: {}", String::from_utf8_lossy(line))
}

/// `Trace 0: 0x7f59 [base/address/state/limit] name`
fn translated(line: &[u8]) -> Option<Translated> {
    let mut fields = std::str::from_utf8(line).ok()?.split_once('[')?.1.split_once(']')?.0.split('/');
    let address = number(fields.nth(1)?)?;
    Some((address, number(fields.nth(1)?)? & 0x1ff))
}

/// `0x00000404:  f04f 32cc  what it does`: the address, and the bytes of the instruction.
fn printed(line: &[u8]) -> Option<(u32, u32)> {
    let (address, rest) = std::str::from_utf8(line).ok()?.strip_prefix("0x")?.split_once(':')?;
    let code = rest.trim_start().split("  ").next()?;
    let digits = code.bytes().filter(u8::is_ascii_hexdigit).count();
    Some((number(address)?, u32::try_from(digits / 2).ok()?))
}

fn number(text: &str) -> Option<u32> {
    u32::from_str_radix(text, 16).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEFORE: &str =
        "IN: a\n0x00000100:  4812       ldr      r0, [pc, #0x48]\n0x00000102:  f04f 32cc  mov.w    r2, #1\n\n";

    fn ran(address: &str, limit: &str) -> String {
        format!("Trace 0: 0x7f [00800408/{address}/00000110/{limit}] name\n")
    }

    fn of(text: &str) -> Vec<Span> {
        spans(text.as_bytes(), 0x200).unwrap()
    }

    fn block(start: u32, size: u32) -> Block {
        Block { start, size }
    }

    #[test]
    fn what_runs_between_two_marks_is_a_span() {
        let mark = ran("00000200", "ff020200");
        let a = ran("00000100", "ff020200");
        let next = ran("00000106", "ff020200");
        let text = format!("{BEFORE}{a}{mark}{a}{next}{a}{a}{mark}{a}{mark}{mark}");
        let spans = of(&text);
        assert_eq!(spans.len(), 2);
        assert_eq!(spans[0][&block(0x100, 6)], Runs { all: 3, taken: 2 });
        assert_eq!(spans[0][&block(0x106, 0)], Runs { all: 1, taken: 1 });
        assert!(spans[1].is_empty());
    }

    #[test]
    fn a_block_with_a_limit_is_another_one() {
        let (mark, a) = (ran("00000200", "ff020200"), ran("00000100", "ff020200"));
        let short = "IN: a\n0x00000100:  4812       ldr      r0, [pc, #0x48]\n\n";
        let text = format!(
            "{BEFORE}{a}{short}{}{mark}{a}{}{a}{mark}",
            ran("00000100", "ff028201"),
            ran("00000100", "ff028201")
        );
        let spans = of(&text);
        assert_eq!((spans[0][&block(0x100, 6)].all, spans[0][&block(0x100, 2)].all), (2, 1));
    }

    #[test]
    fn a_block_that_was_stopped_did_not_run() {
        let (mark, a) = (ran("00000200", "ff020200"), ran("00000100", "ff020200"));
        let text =
            format!("{BEFORE}{a}{mark}{a}{a}Stopped execution of TB chain before 0x7f [00000100] name\n{a}{mark}");
        assert_eq!(of(&text)[0][&block(0x100, 6)].all, 2);
    }

    #[test]
    fn another_line_is_an_error() {
        let error = spans(&b"Trace 0: nonsense\n"[..], 0).unwrap_err();
        assert!(format!("{error:#}").contains("not known here: Trace 0: nonsense"));
    }
}
