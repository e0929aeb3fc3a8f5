//! A layer of a small network by Helium: `vmladava` adds 16 products to a register.
//!
//! Three outputs of two patches are computed at a time, so five loads serve six sums. In a loop from `dlstp` to `letp`
//! the last round uses and loads one lane for each remaining input.

use crate::kernels::plain::dense as plain;
use crate::kernels::plain::dense::Layer;
use core::arch::asm;
use core::ptr;

/// Outputs that are computed at a time.
const OUTPUTS: usize = 3;

pub(crate) fn outputs(layer: Layer<'_>, patches: &[i8], spare: &mut [i8], out: &mut [i8]) {
    let Layer { inputs, weights, biases, shift } = layer;
    let count = biases.len();
    let rows = |length: usize, of: usize| length.checked_div(of).unwrap_or(0);
    let number = rows(patches.len(), inputs);
    let whole = number * inputs == patches.len() && count >= OUTPUTS;
    if !whole || rows(weights.len(), inputs) < count || rows(out.len(), count) < number {
        return plain::outputs(layer, patches, spare, out);
    }
    let (mut from, mut to, mut left) = (patches.as_ptr(), out.as_mut_ptr(), number);
    while left > 0 {
        // Without a second patch the first one is computed twice.
        let second = usize::from(left > 1);
        let mut run = RemainingOutputs {
            biases: biases.as_ptr(),
            inputs,
            patches: [from, from.wrapping_add(second * inputs)],
            shift,
            out: to,
            apart: second * count,
            last: to.wrapping_add(count - OUTPUTS),
        };
        // SAFETY: `left` patches begin at `from`, and `left` times `count` outputs at `to`. There are `count` biases,
        // and `inputs` weights for each of them.
        unsafe { run.all(weights.as_ptr()) };
        from = from.wrapping_add(2 * inputs);
        to = to.wrapping_add(2 * count);
        left = left.saturating_sub(2);
    }
}

#[inline(always)]
pub(crate) fn copy(from: &[i8], to: &mut [i8]) {
    // SAFETY: only the first `count` numbers of each are read or written.
    unsafe {
        asm!(
            "wlstp.8 lr, {count}, 3f",
            "2:",
            "vldrb.u8 q0, [{from}], #16",
            "vstrb.8 q0, [{to}], #16",
            "letp lr, 2b",
            "3:",
            from = inout(reg) from.as_ptr() => _,
            to = inout(reg) to.as_mut_ptr() => _,
            count = in(reg) from.len().min(to.len()),
            out("lr") _, out("q0") _,
            options(nostack),
        );
    }
}

/// Remaining outputs of two patches. The assembly reads and updates this.
#[repr(C)]
struct RemainingOutputs {
    biases: *const [u8; 4],
    inputs: usize,
    patches: [*const i8; 2],
    shift: u32,
    /// The next output of the first patch.
    out: *mut i8,
    /// Bytes from an output of the first patch to the same output of the second patch; 0 if both are one patch.
    apart: usize,
    /// The last three outputs of the first patch.
    last: *mut i8,
}

impl RemainingOutputs {
    /// Computes all outputs, three at a time. If 3 does not divide their number, one or two are computed twice.
    ///
    /// # Safety
    /// There are at least three outputs. For each of them `inputs` weights and a bias can be read, and an output can be
    /// written, also `apart` bytes later. `inputs` bytes of each patch can be read. `inputs` is not 0.
    #[inline(always)]
    unsafe fn all(&mut self, weights: *const i8) {
        // SAFETY: each round reads `inputs` weights of three outputs, and the last one ends with the weights. r6 and r7,
        // which `asm!` may not name, are saved on the stack. The assembly moves the address of `self` to r6.
        unsafe {
            asm!(
                "push {{r6, r7}}",
                "mov r6, r11",
                "2:",
                "ldrd r7, lr, [r6]",
                "ldr r0, [r7], #4",
                "ldr r2, [r7], #4",
                "ldr r4, [r7], #4",
                "str r7, [r6]",
                "mov r8, r0",
                "mov r10, r2",
                "mov r12, r4",
                "ldrd r1, r3, [r6, #8]",
                "add r9, r5, lr",
                "add r11, r9, lr",
                "add r7, r11, lr",
                "dlstp.8 lr, lr",
                "3:",
                "vldrb.u8 q0, [r1], #16",
                "vldrb.u8 q2, [r5], #16",
                "vmladava.s8 r0, q0, q2",
                "vldrb.u8 q1, [r3], #16",
                "vmladava.s8 r8, q1, q2",
                "vldrb.u8 q2, [r9], #16",
                "vmladava.s8 r2, q0, q2",
                "vmladava.s8 r10, q1, q2",
                "vldrb.u8 q2, [r11], #16",
                "vmladava.s8 r4, q0, q2",
                "vmladava.s8 r12, q1, q2",
                "letp lr, 3b",
                "mov r5, r7",
                "ldrd r1, r3, [r6, #16]",
                "ldrd r9, r11, [r6, #24]",
                "asrs r0, r1",
                "usat r0, #7, r0",
                "asrs r2, r1",
                "usat r2, #7, r2",
                "asrs r4, r1",
                "usat r4, #7, r4",
                "asr r8, r8, r1",
                "usat r8, #7, r8",
                "asr r10, r10, r1",
                "usat r10, #7, r10",
                "asr r12, r12, r1",
                "usat r12, #7, r12",
                "strb r8, [r3, r9]",
                "strb r0, [r3], #1",
                "strb r10, [r3, r9]",
                "strb r2, [r3], #1",
                "strb r12, [r3, r9]",
                "strb r4, [r3], #1",
                "str r3, [r6, #20]",
                "subs r9, r3, r11",
                "ble 2b",
                "cmp r9, #3",
                "beq 4f",
                // One or two outputs of a patch are left: goes back to compute its last three outputs together.
                "ldrd r7, lr, [r6]",
                "sub r7, r7, r9, lsl #2",
                "str r7, [r6]",
                "mls r5, r9, lr, r5",
                "str r11, [r6, #20]",
                "b 2b",
                "4:",
                "pop {{r6, r7}}",
                inout("r11") ptr::from_mut(self) => _,
                inout("r5") weights => _,
                out("r0") _, out("r1") _, out("r2") _, out("r3") _, out("r4") _, out("r8") _, out("r9") _,
                out("r10") _, out("r12") _, out("lr") _, out("q0") _, out("q1") _, out("q2") _,
            );
        }
    }
}
