//! The time driver of Embassy on two timers of the board: one counts cycles, the other is the alarm.
//!
//! On a chip that Embassy knows, its HAL brings a driver, and a program needs nothing like this file.

use core::cell::{Cell, RefCell};
use core::ptr::with_exposed_provenance_mut;
use core::task::Waker;
use cortex_m::peripheral::NVIC;
use critical_section::{CriticalSection, Mutex};
use embassy_time::TICK_HZ;
use embassy_time_driver::{Driver, time_driver_impl};
use embassy_time_queue_utils::Queue;

/// Cycles of the board in one tick of Embassy.
pub const CYCLES_A_TICK: u64 = 25_000_000 / TICK_HZ;

/// A CMSDK timer: it counts down from `reload` to 0, requests an interrupt, and starts again.
#[derive(Clone, Copy)]
struct Timer {
    address: usize,
    interrupt: u16,
}

const COUNTER: Timer = Timer { address: 0x4000_0000, interrupt: 8 };
const ALARM: Timer = Timer { address: 0x4000_1000, interrupt: 9 };

// Registers, in words from the address of the timer.
const CONTROL: usize = 0;
const VALUE: usize = 1;
const RELOAD: usize = 2;
/// Read: 1 if an interrupt is requested. Written: 1 ends the request.
const REQUEST: usize = 3;

/// Value of CONTROL: the timer counts and requests interrupts.
const RUN: u32 = 1 << 3 | 1;

impl Timer {
    fn register(self, number: usize) -> *mut u32 {
        with_exposed_provenance_mut::<u32>(self.address).wrapping_add(number)
    }

    fn read(self, register: usize) -> u32 {
        // SAFETY: a register of a timer of this board, which may be read at any time.
        unsafe { self.register(register).read_volatile() }
    }

    fn write(self, register: usize, value: u32) {
        // SAFETY: a register of a timer of this board. The timers touch no memory, and only this module uses them.
        unsafe { self.register(register).write_volatile(value) }
    }

    fn run(self, cycles: u32) {
        self.write(CONTROL, 0);
        self.write(RELOAD, cycles);
        self.write(VALUE, cycles);
        self.write(CONTROL, RUN);
    }
}

// SAFETY: the numbers are those of the board, and `enable` is their only use.
unsafe impl cortex_m::interrupt::InterruptNumber for Timer {
    fn number(self) -> u16 {
        self.interrupt
    }
}

struct Clock {
    /// How many times the counter has started again.
    rounds: Mutex<Cell<u32>>,
    waiting: Mutex<RefCell<Queue>>,
}

time_driver_impl!(static CLOCK: Clock = Clock {
    rounds: Mutex::new(Cell::new(0)),
    waiting: Mutex::new(RefCell::new(Queue::new())),
});

/// Starts the clock at 0.
pub fn start() {
    COUNTER.run(u32::MAX);
    for timer in [COUNTER, ALARM] {
        // SAFETY: no critical section of this program masks single interrupts.
        unsafe { NVIC::unmask(timer) };
    }
}

/// Cycles since the start.
pub fn cycles() -> u64 {
    critical_section::with(|section| CLOCK.cycles(section))
}

/// Handles the interrupts of both timers. Returns false for any other interrupt number.
pub fn interrupt(number: i16) -> bool {
    critical_section::with(|section| {
        if number == COUNTER.interrupt.cast_signed() {
            COUNTER.write(REQUEST, 1);
            CLOCK.rounds.borrow(section).update(|rounds| rounds + 1);
        } else if number == ALARM.interrupt.cast_signed() {
            CLOCK.set_alarm(section);
        } else {
            return false;
        }
        true
    })
}

impl Clock {
    fn cycles(&self, section: CriticalSection<'_>) -> u64 {
        let before = COUNTER.read(VALUE);
        let pending = COUNTER.read(REQUEST);
        let value = if pending == 0 { before } else { COUNTER.read(VALUE) };
        let rounds = self.rounds.borrow(section).get() + pending;
        (u64::from(rounds) << 32) + u64::from(u32::MAX - value)
    }

    /// Wakes the tasks whose time has come, and sets the alarm to the next one.
    fn set_alarm(&self, section: CriticalSection<'_>) {
        ALARM.write(CONTROL, 0);
        ALARM.write(REQUEST, 1);
        loop {
            let now = self.cycles(section);
            let next = self.waiting.borrow_ref_mut(section).next_expiration(now / CYCLES_A_TICK);
            if next == u64::MAX {
                return; // no task waits
            }
            if let Some(wait) = next.saturating_mul(CYCLES_A_TICK).checked_sub(now).filter(|&wait| wait > 0) {
                // If the alarm comes too early, this function runs again.
                ALARM.run(u32::try_from(wait).unwrap_or(u32::MAX));
                return;
            }
        }
    }
}

impl Driver for Clock {
    fn now(&self) -> u64 {
        cycles() / CYCLES_A_TICK
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        critical_section::with(|section| {
            if self.waiting.borrow_ref_mut(section).schedule_wake(at, waker) {
                self.set_alarm(section);
            }
        });
    }
}
