"""Estimates the cycles of firmware from a trace of QEMU, for `smr-qemu --cycles`: python3 cycles.py ELF MACHINE CALIBRATIONS < TRACE

QEMU's trace gives the blocks of code that run between two calls of smr_ticks. llvm-mca estimates the cycles of each block, as if it ran in a
loop. Taken branches cost more, as often as in the trace. The estimate leaves out waits for memory, caches, mispredicted branches, and stalls
from one block into the next.

PROCESSORS adds the costs that LLVM's models lack. The Cortex-M33 uses the M4's model. The Cortex-M0+ has none: its manual states every cycle.
"""

import bisect
import json
import re
import subprocess
import sys
import tempfile
from collections import Counter

# Costs are counted in 1/PARTS cycle: llvm-mca simulates PARTS iterations of each block.
PARTS = 50
MODELLED = True
# For each processor: name; True if LLVM has a model; four costs to add: cycles of a taken branch (it takes 1 + P on the
# M4 by Arm's manual, P is 1 to 3), 1/PARTS cycles of each word after the first that an instruction loads or stores,
# cycles of a division (it takes 2 to 12), cycles of a post-increment load right after one that increments the same
# register; chips, with clocks in MHz.
PROCESSORS = {
    "mps2-an385": [("cortex-m0plus", not MODELLED, 1, 0, 0, 0, {"RP2040": 133})],
    "mps2-an386": [
        ("cortex-m4", MODELLED, 2, 50, 6, 1, {"STM32F407": 168}),
        ("cortex-m33", MODELLED, 2, 50, 6, 1, {"RP2350": 150, "nRF5340": 128}),
    ],
    "mps2-an500": [("cortex-m7", MODELLED, 1, 25, 0, 0, {"STM32H743": 480})],
    "mps3-an547": [
        ("cortex-m55", MODELLED, 2, 25, 6, 0, {"STM32N6": 800, "Alif E7": 400}),
        ("cortex-m85", MODELLED, 1, 25, 0, 0, {"RA8M1": 480}),
    ],
}


def llvm(name, *arguments):
    """Runs an LLVM tool and returns its output. Debian's tools have the version in their names."""
    for version in ("-19", "-20", "-21", "-18", ""):
        try:
            done = subprocess.run([name + version, *arguments], capture_output=True, text=True, check=False)
        except FileNotFoundError:
            continue
        if done.returncode != 0:
            raise ValueError(f"{name}{version} fails: {(done.stderr.splitlines() or [''])[0]}")
        return done.stdout
    raise ValueError(f"there is no {name}: --cycles needs LLVM 18 or later (Debian: llvm-19)")


def program(elf, processor):
    """Disassembles firmware: the names of functions, and the instructions, by address."""
    functions, code = {}, {}
    for line in llvm("llvm-objdump", "-d", "--demangle", "--no-show-raw-insn", f"--mcpu={processor}", elf).splitlines():
        if found := re.fullmatch(r"([0-9a-f]+) <(.*)>:", line):
            functions[int(found[1], 16)] = found[2]
        elif found := re.match(r"\s*([0-9a-f]+):([^@<]*)", line):
            code[int(found[1], 16)] = found[2].strip().replace("\t", " ")
    return functions, code


def spans(trace, mark):
    """For each measurement: {(address, size) of a block: (runs, taken branches at its end)}."""
    ended, blocks, pairs, last, printed = [], {}, None, None, (0, 0)
    for line in trace:
        if line.startswith(b"Trace "):
            # A line for each run of a block: Trace 0: 0x7f59 [base/address/state/limit] name
            block = blocks.get(line)
            if block is None or printed[0] == block[0]:
                start = int(line.split(b"/")[1], 16)
                block = blocks[line] = printed if printed[0] == start else (start, 0)
                printed = (0, 0)
            if pairs is not None:
                pairs[last, block] += 1
            if block[0] == mark:
                ended += [pairs] if pairs is not None else []
                pairs = Counter() if pairs is None else None
            last = block
        elif line.startswith(b"0x"):
            # A line of a block's disassembly: 0x00000404:  f04f 32cc  instruction
            address, code = int(line[:10], 16), line[11:].strip().split(b"  ")[0].replace(b" ", b"")
            start = printed[0] or address
            printed = (start, address - start + len(code) // 2)
        elif line.startswith(b"IN:"):
            printed = (0, 0)
        elif line.startswith(b"Stopped execution") and pairs is not None and last is not None:
            # Subtracts one run of the last block: QEMU stopped before the block ran.
            pairs[None, last] -= 1
            last = None
    for pairs in ended:
        ran, taken = Counter(), Counter()
        for (before, block), count in pairs.items():
            ran[block] += count
            if before is not None and sum(before) != block[0]:
                taken[before] += count
        yield {block: (count, taken[block]) for block, count in ran.items() if block[0] != mark}


def is_loop_end(text):
    """True for the end of a hardware loop, which costs no cycle after the first iteration."""
    return text.split(" ")[0] in ("le", "letp")


def words(text):
    """Number of words that an instruction loads or stores."""
    if text.startswith(("ldrd", "strd")):
        return 2
    registers = re.match(r"v?(?:ldm|stm|push|pop).*\{(.*?)(?:\}|$)", text)
    if registers:
        return (registers[1].count(",") + 1) * (2 if registers[1].startswith("d") else 1)
    return int(text.startswith(("ldr", "str")))


def steps(text):
    """The address register of a load with post-increment; None for other instructions."""
    found = re.match(r"ldr[^\[]*\[([^\]]*)\],", text)
    return found and found[1]


def cycles_by_manual(text):
    """Cycles by the Cortex-M0+ manual: one, plus one for each loaded or stored word, a call, and a return from the stack."""
    name = text.split(" ")[0]
    if name in ("mrs", "msr", "dsb", "dmb", "isb"):
        return 3
    return 2 if name == "bl" else 1 + words(text) + (name == "pop" and "pc" in text)


def model(name, codes):
    """For each block: the number of instructions that LLVM's model covers, and their time in 1/PARTS cycle."""
    with tempfile.NamedTemporaryFile("w", suffix=".s") as file:
        for number, code in enumerate(codes):
            # Gives branches a near target: the assembler refuses one that is out of range.
            lines = [re.sub(r" 0x\S*$", " #4", text) for text in code if not is_loop_end(text)]
            file.write("\n".join([f"# LLVM-MCA-BEGIN {number}", *lines, "# LLVM-MCA-END\n"]))
        file.flush()
        # `implicit-it` inserts missing IT instructions: a block's instructions may have theirs in another block.
        options = ["-mtriple=thumb-none-eabihf", f"-mcpu={name}", "-arm-implicit-it=always", "-call-latency=1", f"-iterations={PARTS}"]
        options += ["-skip-unsupported-instructions=any", "-all-views=false", "-summary-view", "-json"]
        regions = json.loads(llvm("llvm-mca", *options, file.name))["CodeRegions"]
    known = {int(region["Name"]): region["SummaryView"] for region in regions}
    none = {"Instructions": 0, "TotalCycles": 0}
    return [(of["Instructions"] // PARTS, of["TotalCycles"]) for of in (known.get(number, none) for number in range(len(codes)))]


def costs(processor, codes):
    """For each block: instructions, instructions unknown to LLVM, 1/PARTS cycles, and 1/PARTS cycles of a taken branch."""
    name, modelled, taken, word, division, stepped, _ = processor
    if not modelled:
        return [(len(code), 0, PARTS * sum(map(cycles_by_manual, code)), PARTS * taken) for code in codes]
    found = []
    for code, (known, parts) in zip(codes, model(name, codes)):
        unknown = max(0, len(code) - sum(map(is_loop_end, code)) - known)
        again = sum(steps(one) is not None and steps(one) == steps(other) for one, other in zip(code, code[1:]))
        divisions = sum(text.startswith(("sdiv", "udiv")) for text in code)
        parts += word * sum(max(0, words(text) - 1) for text in code) + PARTS * (unknown + stepped * again + division * divisions)
        found.append((len(code), unknown, parts, 0 if code and is_loop_end(code[-1]) else PARTS * taken))
    return found


def total(cost, spans):
    """Sums of instructions, of instructions unknown to LLVM, and of 1/PARTS cycles."""
    sums = [0, 0, 0]
    for block, (ran, taken) in (item for span in spans for item in span.items()):
        each, unknown, parts, more = cost[block]
        sums = [sums[0] + each * ran, sums[1] + unknown * ran, sums[2] + parts * ran + more * taken]
    return sums


def shares(functions, cost, updates):
    """Yields the ten functions with the most cycles of their own, without their callees."""
    starts, spans = sorted(functions), {}
    for block, runs in (item for update in updates for item in update.items()):
        at = starts[bisect.bisect(starts, block[0]) - 1]
        spans.setdefault(functions[at], []).append({block: runs})
    sums = {name: total(cost, spans) for name, spans in spans.items()}
    parts = max(1, sum(of[2] for of in sums.values()))
    for name, of in sorted(sums.items(), key=lambda share: -share[1][2])[:10]:
        yield f"    {100 * of[2] / parts:4.1f} %  {of[2] / PARTS / max(1, of[0]):.2f}  {name}"


def median(numbers):
    """The larger of two middle values."""
    return sorted(numbers)[len(numbers) // 2]


def main(elf, machine, calibrations):
    if machine not in PROCESSORS:
        raise ValueError(f"--cycles: {machine} has a processor without a model: expected a Cortex-M")
    functions, code = program(elf, PROCESSORS[machine][0][0])
    mark = next((address for address, name in functions.items() if name == "smr_ticks"), None)
    if mark is None:
        raise ValueError("the firmware has no function smr_ticks")
    lock, *updates = list(spans(sys.stdin.buffer, mark))[int(calibrations) :] or [{}]
    if not updates:
        raise ValueError("the firmware measured nothing: expected two calls of smr_ticks around the lock, and around each update; "
                         "if it refuses the recording, it says so without --cycles")  # fmt: skip
    blocks = sorted({block for span in (lock, *updates) for block in span})
    codes = [[code[at] for at in range(start, start + size) if at in code] for start, size in blocks]
    cost = [dict(zip(blocks, costs(processor, codes))) for processor in PROCESSORS[machine]]
    print("  instructions of an update in the trace:", median([total(cost[0], [update])[0] for update in updates]))
    print("  estimated cycles, in millions; waits for memory, caches and branches predicted wrongly are not counted:")
    for processor, cost_of in zip(PROCESSORS[machine], cost):
        cycles = [total(cost_of, [update])[2] // PARTS for update in updates]
        usual, most, lock_takes = median(cycles), max(cycles), total(cost_of, [lock])[2] // PARTS
        each, unknown, parts = total(cost_of, updates)
        print(f"    {processor[0]}: lock {lock_takes / 1e6:.2f}, update median {usual / 1e6:.3f}, at most {most / 1e6:.3f}; "
              f"{parts / PARTS / max(1, each):.2f} an instruction"
              + (f", {100 * unknown / each:.1f} % of which are not in LLVM's model and count as one cycle" if unknown else ""))  # fmt: skip
        for chip, megahertz in processor[-1].items():
            print(f"      {chip} at {megahertz} MHz: {megahertz * 1e6 / max(1, usual):.0f} updates a second, at least {megahertz * 1e6 / max(1, most):.0f}")
    print(f"  where the cycles of the updates go on the {PROCESSORS[machine][0][0]}, and the cycles of an instruction there:")
    print("\n".join(shares(functions, cost[0], updates)))


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    except ValueError as error:
        sys.exit(str(error))
