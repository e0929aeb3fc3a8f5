//! A layer of a small network by the DSP extension: `smlad` adds two products of 16-bit numbers.
//!
//! Four bytes become two pairs of 16-bit numbers: bytes 0 and 2, and bytes 1 and 3. The inputs of two patches are
//! unpacked once for all outputs. Two outputs of two patches are computed at a time, so each weight is unpacked once
//! for two products. A single patch is unpacked again for every two outputs, without scratch memory.

use crate::kernels::plain::dense as plain;
use crate::kernels::plain::dense::Layer;
use core::arch::asm;
use core::ptr;

/// Outputs that are computed at a time.
const OUTPUTS: usize = 2;

pub(crate) fn outputs(layer: Layer<'_>, patches: &[i8], spare: &mut [i8], out: &mut [i8]) {
    let Layer { inputs, weights, biases, shift } = layer;
    let count = biases.len();
    let rows = |length: usize, of: usize| length.checked_div(of).unwrap_or(0);
    let number = rows(patches.len(), inputs);
    let whole = inputs.is_multiple_of(4) && number * inputs == patches.len() && count >= OUTPUTS;
    if !whole || rows(weights.len(), inputs) < count || rows(out.len(), count) < number {
        return plain::outputs(layer, patches, spare, out);
    }
    // Room for two unpacked patches: an element of four words holds four inputs of the first and of the second patch.
    // SAFETY: all bit patterns are valid words.
    let (_, room, _) = unsafe { spare.align_to_mut::<[u32; 4]>() };
    let (mut from, mut to, mut left) = (patches.as_ptr(), out.as_mut_ptr(), number);
    while left > 0 {
        let last = to.wrapping_add(count - OUTPUTS);
        let mut run = RemainingOutputs { biases: biases.as_ptr(), from, apart: 0, out: to, shift, last };
        if left > 1 && inputs <= 4 * room.len() {
            // SAFETY: two patches of `inputs` bytes are left, a multiple of 4. `room` has at least `inputs` aligned
            // words.
            unsafe { unpack(from, inputs, room.as_mut_ptr().cast()) };
            (run.from, run.apart) = (room.as_ptr().cast(), count);
        }
        // SAFETY: `left` patches begin at `from`, and `left` times `count` outputs at `to`. There are `count` biases,
        // and `inputs` weights for each of them. If `apart` is not 0, two patches are unpacked.
        unsafe { run.all(weights.as_ptr(), inputs) };
        let done = if run.apart == 0 { 1 } else { 2 };
        from = from.wrapping_add(done * inputs);
        to = to.wrapping_add(done * count);
        left -= done;
    }
}

/// Unpacks two successive patches of `inputs` bytes to 16-bit numbers, four inputs of each in turn.
///
/// # Safety
/// `2 * inputs` bytes can be read at `patches`, and `inputs` words written at `room`, which is aligned. `inputs` is a
/// multiple of 4 and not 0.
#[inline(always)]
unsafe fn unpack(patches: *const i8, inputs: usize, room: *mut u32) {
    // SAFETY: each round reads four bytes of both patches and writes four words, until `inputs` words are written.
    unsafe {
        asm!(
            "2:",
            "ldr r3, [{from}, {inputs}]",
            "ldr r1, [{from}], #4",
            "sxtb16 r2, r3",
            "sxtb16 r3, r3, ror #8",
            "sxtb16 r0, r1",
            "sxtb16 r1, r1, ror #8",
            "stm {to}!, {{r0, r1, r2, r3}}",
            "cmp {from}, {end}",
            "bne 2b",
            from = inout(reg) patches => _,
            to = inout(reg) room => _,
            end = in(reg) patches.wrapping_add(inputs),
            inputs = in(reg) inputs,
            out("r0") _, out("r1") _, out("r2") _, out("r3") _,
            options(nostack),
        );
    }
}

/// State of the loop over the outputs of one patch, or of two at once. The assembly reads and updates it.
#[repr(C)]
struct RemainingOutputs {
    biases: *const [u8; 4],
    /// Two unpacked patches, or one patch of bytes.
    from: *const i8,
    /// Bytes from an output of the first patch to the same output of the second patch; 0 for one patch.
    apart: usize,
    /// The next output of the first patch.
    out: *mut i8,
    shift: u32,
    /// The last two outputs of the first patch.
    last: *mut i8,
}

/// Multiplies four inputs of each of two patches by the weights of two outputs. Adds the products to the sums of the
/// two outputs: r0 and r1 for the first patch, r2 and r3 for the second.
macro_rules! turn {
    () => {
        "ldr r6, [r11, r12]
        ldm r10!, {{r4, r5, r8, r9}}
        sxtb16 r7, r6
        sxtb16 r6, r6, ror #8
        smlad r1, r4, r7, r1
        smlad r3, r8, r7, r3
        ldr r7, [r11], #4
        smlad r1, r5, r6, r1
        smlad r3, r9, r6, r3
        sxtb16 r6, r7
        sxtb16 r7, r7, ror #8
        smlad r0, r4, r6, r0
        smlad r2, r8, r6, r2
        smlad r0, r5, r7, r0
        smlad r2, r9, r7, r2"
    };
}

impl RemainingOutputs {
    /// Computes all outputs, two at a time. If their number is odd, the last but one is computed twice.
    ///
    /// # Safety
    /// There are at least two outputs. For each of them `inputs` weights and a bias can be read, and an output can be
    /// written, also `apart` bytes later. `inputs` is a multiple of 4 and not 0. At `from` there are `inputs` unpacked
    /// inputs of two patches, or those of one patch if `apart` is 0.
    #[inline(always)]
    unsafe fn all(&mut self, weights: *const i8, inputs: usize) {
        // SAFETY: each round reads weights of two outputs and the inputs under them, and the last one ends with the
        // weights. r6 and r7, which `asm!` may not name, are saved on the stack, and so is the address of `self`.
        unsafe {
            asm!(
                "push {{r6, r7, r10}}",
                "1:",
                "ldr r6, [sp, #8]",
                "ldr r7, [r6]",
                "ldr r0, [r7], #4",
                "ldr r1, [r7], #4",
                "str r7, [r6]",
                "mov r2, r0",
                "mov r3, r1",
                "ldrd r10, r4, [r6, #4]",
                "add lr, r11, r12",
                "cbnz r4, 3f",
                // One patch, so r2 and r3 hold no sums.
                "2:",
                "ldr r4, [r10], #4",
                "ldr r6, [r11, r12]",
                "ldr r7, [r11], #4",
                "sxtb16 r5, r4",
                "sxtb16 r4, r4, ror #8",
                "sxtb16 r8, r6",
                "sxtb16 r6, r6, ror #8",
                "smlad r1, r5, r8, r1",
                "smlad r1, r4, r6, r1",
                "sxtb16 r8, r7",
                "sxtb16 r7, r7, ror #8",
                "smlad r0, r5, r8, r0",
                "smlad r0, r4, r7, r0",
                "cmp r11, lr",
                "bne 2b",
                "b 6f",
                // Two patches, eight inputs of each in a round. If `inputs / 4` is odd, the first round takes four.
                "3:",
                "lsls r4, r12, #29",
                "bmi 5f",
                "4:",
                turn!(),
                "5:",
                turn!(),
                "cmp r11, lr",
                "bne 4b",
                // Shifts, clamps and stores r0 to r3. For one patch (`apart` 0), r0 overwrites r2 in memory, and r1
                // overwrites r3.
                "6:",
                "ldr r6, [sp, #8]",
                "add r11, r11, r12",
                "ldrd r8, r9, [r6, #8]",
                "ldrd r5, r10, [r6, #16]",
                "asrs r2, r5",
                "usat r2, #7, r2",
                "strb r2, [r9, r8]",
                "asrs r0, r5",
                "usat r0, #7, r0",
                "strb r0, [r9], #1",
                "asrs r3, r5",
                "usat r3, #7, r3",
                "strb r3, [r9, r8]",
                "asrs r1, r5",
                "usat r1, #7, r1",
                "strb r1, [r9], #1",
                "str r9, [r6, #12]",
                "subs r4, r9, r10",
                "ble 1b",
                "cmp r4, #2",
                "beq 7f",
                // One output is left: goes back by one, and computes the last two outputs of the patch together.
                "ldr r7, [r6]",
                "subs r7, #4",
                "str r7, [r6]",
                "str r10, [r6, #12]",
                "sub r11, r11, r12",
                "b 1b",
                "7:",
                "pop {{r6, r7, r10}}",
                out("r0") _, out("r1") _, out("r2") _, out("r3") _, out("r4") _, out("r5") _, out("r8") _,
                out("r9") _,
                in("r10") ptr::from_mut(self),
                inout("r11") weights => _,
                in("r12") inputs,
                out("lr") _,
            );
        }
    }
}
