//! The camera, an HM01B0 at 162x122 pixels: I2C configures it, and a PIO state machine reads its pixels bit by bit.

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::InputPin;
use embedded_hal::i2c::I2c;
use rp2040_hal::Timer;
use rp2040_hal::pac::PIO0;
use rp2040_hal::pio::{
    Buffers, PIO, PIOBuilder, PinDir, Rx, SM0, ShiftDirection, StateMachine, Stopped, UninitStateMachine,
};

/// Width in pixels: the sensor halves its QVGA picture of 324x244 pixels in both directions.
pub const WIDTH: u16 = 162;
pub const HEIGHT: u16 = 122;
pub const PIXELS: usize = WIDTH as usize * HEIGHT as usize;

const ADDRESS: u8 = 0x24;
const D0_PIN: u8 = 6;
/// Sensor registers and their values, in the order of writing.
const SETTINGS: [(u16, u8); 12] = [
    (0x3059, 0x22), // one bit per clock
    (0x0383, 0x03), // every second column
    (0x0387, 0x03), // every second row
    (0x0390, 0x03), // the mean of the four
    (0x3010, 0x01), // a 4:3 window
    (0x0340, 0x00), // rows of a frame, including blanking: 128
    (0x0341, 0x80),
    (0x0342, 0x00), // clocks of a row, including blanking: 215
    (0x0343, 0xD7),
    (0x3060, 0x08), // the pixel clock: the sensor's clock, divided
    (0x0104, 0x01), // apply all of these
    (0x0100, 0x01), // stream
];
const RESET: (u16, u8) = (0x0103, 0x01);
/// The longest wait for a frame; a frame takes less.
const PATIENCE_MICROSECONDS: u64 = 300_000;

/// A streaming camera. VSYNC may be any pin; D0, PCLK and HREF are fixed in the PIO program.
pub struct Camera<V> {
    vsync: V,
    timer: Timer,
    machine: Option<StateMachine<(PIO0, SM0), Stopped>>,
    received: Rx<(PIO0, SM0)>,
    pixels: [u8; PIXELS],
}

impl<V: InputPin> Camera<V> {
    /// Configures the sensor and starts the stream. `None` if the sensor does not respond.
    pub fn start(
        mut bus: impl I2c,
        vsync: V,
        mut timer: Timer,
        pio: &mut PIO<PIO0>,
        machine: UninitStateMachine<(PIO0, SM0)>,
    ) -> Option<Self> {
        write(&mut bus, RESET)?;
        timer.delay_ms(100);
        for setting in SETTINGS {
            write(&mut bus, setting)?;
        }
        // PIO program: while HREF (GP15) is high, reads one bit at each rising edge of PCLK (GP14).
        let program =
            pio::pio_asm!(".wrap_target", "wait 1 gpio 15", "wait 1 gpio 14", "in pins, 1", "wait 0 gpio 14", ".wrap",);
        let (mut machine, received, _) = PIOBuilder::from_installed_program(pio.install(&program.program).ok()?)
            .in_pin_base(D0_PIN)
            .in_shift_direction(ShiftDirection::Right) // the first bit is the lowest
            .autopush(true)
            .push_threshold(32)
            .buffers(Buffers::OnlyRx)
            .build(machine);
        machine.set_pindirs([(D0_PIN, PinDir::Input), (14, PinDir::Input), (15, PinDir::Input)]);
        Some(Self { vsync, timer, machine: Some(machine), received, pixels: [0; PIXELS] })
    }

    /// Waits for the next frame and reads it. `None` if no frame arrives in time.
    pub fn frame(&mut self) -> Option<&[u8]> {
        let deadline = self.timer.get_counter().ticks() + PATIENCE_MICROSECONDS;
        let timer = self.timer;
        let late = || timer.get_counter().ticks() > deadline;
        while self.vsync.is_high().ok()? {
            if late() {
                return None;
            }
        }
        while self.vsync.is_low().ok()? {
            if late() {
                return None;
            }
        }
        let mut machine = self.machine.take()?;
        machine.clear_fifos();
        let mut machine = machine.start();
        // Drops remaining bits of the previous frame.
        machine.restart();
        let complete = self.read(late);
        self.machine = Some(machine.stop());
        complete.then_some(&self.pixels)
    }

    /// Reads a frame in words of four pixels, faster than the words arrive. Returns false if a word is missing after
    /// the deadline (`late`).
    fn read(&mut self, late: impl Fn() -> bool) -> bool {
        for four in self.pixels.chunks_exact_mut(4) {
            let word = loop {
                match self.received.read() {
                    Some(word) => break word,
                    None if late() => return false,
                    None => {}
                }
            };
            four.copy_from_slice(&word.to_le_bytes());
        }
        true
    }
}

fn write(bus: &mut impl I2c, (register, value): (u16, u8)) -> Option<()> {
    let [high, low] = register.to_be_bytes();
    bus.write(ADDRESS, &[high, low, value]).ok()
}
