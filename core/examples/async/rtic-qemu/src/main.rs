//! The paper tracker with RTIC in QEMU: an interrupt takes each camera line at once, a low-priority task updates.
//!
//! The task hands the only pixel buffer to the interrupt in an [`Order`] for the next window. The interrupt fills it
//! line by line and hands it back. So the tracker never waits for a lock, and no pixel is copied.

#![no_std]
#![no_main]

mod camera;

use camera::{HEIGHT, PIXELS, WIDTH};
use smr_core::paper;
use smr_core::readout::{Format, Readout};

/// A target with at most 256 template pixels and a search window of at most +-12 pixels (25 offsets per axis).
type Target = smr_core::Paper<256, 25>;
type Workspace = paper::Workspace<256, 25>;

/// The task's request for the next window: a read-out, and a pixel buffer that the interrupt fills.
pub struct Order {
    readout: Readout,
    pixels: &'static mut [u8; PIXELS],
}

impl Order {
    fn new(window: smr_core::Rect, pixels: &'static mut [u8; PIXELS]) -> Option<Self> {
        Some(Self { readout: Readout::new(Format::GRAY8, (WIDTH, HEIGHT), window).ok()?, pixels })
    }
}

#[rtic::app(device = lm3s6965, peripherals = false, dispatchers = [GPIOA])]
mod app {
    use crate::camera::{self, FRAMES, HEIGHT, PIXELS, START, WIDTH};
    use crate::{Order, Target, Workspace};
    use core::arch::asm;
    use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
    use cortex_m::peripheral::{SYST, syst::SystClkSource};
    use semihosting::println;
    use semihosting::process::exit;
    use smr_core::readout::ReadoutError;
    use smr_core::{Answer, Frame, Image, Rect, Target as _};

    /// Core cycles from one line to the next. An update takes as long as several lines.
    const LINE_CYCLES: u32 = 2000;

    type Answers = [Option<Answer>; FRAMES as usize];

    static LINES_WHILE_UPDATING: AtomicU32 = AtomicU32::new(0);
    static LARGEST_DELAY_CYCLES: AtomicU32 = AtomicU32::new(0);
    static IS_UPDATING: AtomicBool = AtomicBool::new(false);

    #[shared]
    struct Shared {
        /// The task's request, while the interrupt fills its buffer.
        order: Option<Order>,
    }

    #[local]
    struct Local {
        // Fields of the interrupt:
        frame: u16,
        y: u16,
        // Fields of the task:
        target: &'static mut Target,
        workspace: &'static mut Workspace,
        whole: Answers,
        updates: u32,
        differ: u32,
        instructions_a_cycle: u32,
    }

    #[init(local = [
        target_place: Target = Target::new(), // a window of +-12, as its capacity says
        workspace_place: Workspace = Workspace::new(),
        pixels: [u8; PIXELS] = [0; PIXELS],
    ])]
    fn init(context: init::Context) -> (Shared, Local) {
        let init::LocalResources { target_place: target, workspace_place: workspace, pixels, .. } = context.local;
        let mut timer = context.core.SYST;
        let instructions_a_cycle = instructions_a_cycle(&mut timer);
        let Some(whole) = whole_frames(target, workspace, pixels) else {
            fail("cannot follow the target in whole frames")
        };
        let order = Order::new(target.lock_window(Rect::new(0, 0, WIDTH, HEIGHT), START), pixels);
        start(&mut timer, LINE_CYCLES);
        timer.enable_interrupt();
        let (frame, y, updates, differ) = (0, 0, 0, 0);
        (Shared { order }, Local { frame, y, target, workspace, whole, updates, differ, instructions_a_cycle })
    }

    /// Takes a line of the camera: here at a timer tick, on a board when the DMA completes a line.
    #[task(binds = SysTick, priority = 2, shared = [order], local = [frame, y])]
    fn line(mut context: line::Context) {
        let late = (LINE_CYCLES - SYST::get_current()) % LINE_CYCLES; // counts down to the interrupt at 0
        LARGEST_DELAY_CYCLES.fetch_max(late, Ordering::Relaxed);
        if IS_UPDATING.load(Ordering::Relaxed) {
            LINES_WHILE_UPDATING.fetch_add(1, Ordering::Relaxed);
        }
        let line::LocalResources { frame, y, .. } = context.local;
        let filled = context.shared.order.lock(|order| {
            let Order { readout, pixels } = order.as_mut()?;
            match readout.push_line(*y, &camera::line(*frame, *y), &mut pixels[..]) {
                // If a window is requested after its first line has passed, the request waits for the next frame.
                Ok(()) | Err(ReadoutError::LineMissing(_)) => {}
                Err(_) => fail("the read-out refuses a line"),
            }
            order.take_if(|order| order.readout.is_complete())
        });
        if let Some(order) = filled
            && update::spawn(*frame, order).is_err()
        {
            fail("an update while one is running");
        }
        *y = (*y + 1) % HEIGHT;
        *frame += u16::from(*y == 0);
    }

    /// Updates the tracker with a complete window. The task owns the pixels until it requests the next window.
    #[task(priority = 1, shared = [order], local = [target, workspace, whole, updates, differ, instructions_a_cycle])]
    async fn update(mut context: update::Context, number: u16, Order { readout, pixels }: Order) {
        let update::LocalResources { target, workspace, whole, updates, differ, instructions_a_cycle, .. } =
            context.local;
        IS_UPDATING.store(true, Ordering::Relaxed);
        let answer = readout.frame(&pixels[..]).ok().and_then(|frame| {
            if number == 0 {
                target.lock(workspace, &frame, START).ok().map(|_| None)
            } else {
                target.update(workspace, &frame).ok().map(Some)
            }
        });
        IS_UPDATING.store(false, Ordering::Relaxed);
        let Some(answer) = answer else { fail("cannot lock on the box or search the frame") };
        // If an update takes too long, the tracker misses a frame, and its answers differ from the expected ones.
        *differ += u32::from(whole.get(usize::from(number)) != Some(&answer));
        *updates += u32::from(number > 0);
        if number + 1 >= FRAMES {
            let instructions = *instructions_a_cycle;
            println!("updates: {updates}");
            println!("answers that differ: {differ}");
            println!("lines while updating: {}", LINES_WHILE_UPDATING.load(Ordering::Relaxed));
            println!("largest delay of a line: {}", LARGEST_DELAY_CYCLES.load(Ordering::Relaxed) * instructions);
            println!("from line to line: {}", LINE_CYCLES * instructions);
            exit(0);
        }
        let Some(order) = target.window().and_then(|window| Order::new(window, pixels)) else { fail("no target") };
        context.shared.order.lock(|next| *next = Some(order));
    }

    /// Computes the expected answers: those for whole frames, without interrupts.
    fn whole_frames(target: &mut Target, workspace: &mut Workspace, pixels: &mut [u8; PIXELS]) -> Option<Answers> {
        let mut answers = [None; FRAMES as usize];
        for (number, answer) in (0..).zip(&mut answers) {
            for (y, row) in (0..).zip(pixels.chunks_exact_mut(WIDTH.into())) {
                row.copy_from_slice(&camera::line(number, y));
            }
            let frame = Frame::whole(Image::new(pixels, WIDTH, HEIGHT).ok()?);
            if number == 0 {
                target.lock(workspace, &frame, START).ok()?;
            } else {
                *answer = Some(target.update(workspace, &frame).ok()?);
            }
        }
        Some(answers)
    }

    /// Measures the instructions per timer cycle. Their number is constant in QEMU with `-icount`.
    fn instructions_a_cycle(timer: &mut SYST) -> u32 {
        const INSTRUCTIONS: u32 = 2_000_000;
        start(timer, 1 << 24);
        let before = SYST::get_current();
        // SAFETY: two instructions a round count down a register.
        unsafe {
            asm!("2:", "subs {rounds}, #1", "bne 2b", rounds = inout(reg) INSTRUCTIONS / 2 => _, options(nomem, nostack));
        }
        let cycles = (before.wrapping_sub(SYST::get_current()) & 0x00FF_FFFF).max(1);
        (INSTRUCTIONS + cycles / 2) / cycles
    }

    fn start(timer: &mut SYST, cycles: u32) {
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(cycles - 1);
        timer.clear_current();
        timer.enable_counter();
    }

    fn fail(what: &str) -> ! {
        println!("error: {what}");
        exit(1)
    }
}
