//! The camera, an HM01B0 at 162x122 pixels: I2C configures it, a PIO state machine reads its pixels bit by bit, and DMA
//! stores them, while the processor follows the target in the frame before.

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::I2c;
use rp2040_hal::Timer;
use rp2040_hal::dma::double_buffer::{self, WriteNext};
use rp2040_hal::dma::{CH0, CH1, Channel};
use rp2040_hal::pac::PIO0;
use rp2040_hal::pio::{
    Buffers, PIO, PIOBuilder, PinDir, Running, Rx, SM0, ShiftDirection, StateMachine, Tx, UninitStateMachine,
};

/// Width in pixels: the sensor halves its QVGA picture of 324x244 pixels in both directions.
pub const WIDTH: u16 = 162;
pub const HEIGHT: u16 = 122;

/// The pixels of a frame, four in a word.
pub type Buffer = [u32; WIDTH as usize * HEIGHT as usize / 4];
const BITS: u32 = WIDTH as u32 * HEIGHT as u32 * 8;

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

type Machine = (PIO0, SM0);
type Words = &'static mut Buffer;
/// Fills a buffer, then a second one.
type Transfer = double_buffer::Transfer<Channel<CH0>, Channel<CH1>, Rx<Machine>, Words, WriteNext<Words>>;

/// A streaming camera. Its pins are fixed in the PIO program.
pub struct Camera {
    timer: Timer,
    _machine: StateMachine<Machine, Running>,
    armed: Tx<Machine>,
    /// `None` only inside of `frame`.
    transfer: Option<Transfer>,
    /// The third buffer, with the frame that `frame` returned last.
    pixels: Option<Words>,
    /// The frame that is being read came to a halt: its end will be that of another frame.
    torn: bool,
}

impl Camera {
    /// Configures the sensor and starts the stream. `None` if the sensor does not respond.
    pub fn start(
        mut bus: impl I2c,
        mut timer: Timer,
        pio: &mut PIO<PIO0>,
        machine: UninitStateMachine<Machine>,
        channels: (Channel<CH0>, Channel<CH1>),
        [first, second, third]: [Words; 3],
    ) -> Option<Self> {
        write(&mut bus, RESET)?;
        timer.delay_ms(100);
        for setting in SETTINGS {
            write(&mut bus, setting)?;
        }
        // Waits until a buffer is ready, then for the rising edge of VSYNC (GP16). While HREF (GP15) is high, reads one
        // bit at each rising edge of PCLK (GP14).
        let program = pio::pio_asm!(
            ".wrap_target",
            "pull block",
            "mov x, osr",
            "wait 0 gpio 16",
            "wait 1 gpio 16",
            "bit:",
            "wait 1 gpio 15",
            "wait 1 gpio 14",
            "in pins, 1",
            "wait 0 gpio 14",
            "jmp x-- bit",
            ".wrap",
        );
        let (mut machine, received, mut armed) =
            PIOBuilder::from_installed_program(pio.install(&program.program).ok()?)
                .in_pin_base(D0_PIN)
                .in_shift_direction(ShiftDirection::Right) // the first bit is the lowest
                .autopush(true)
                .push_threshold(32)
                .buffers(Buffers::RxTx)
                .build(machine);
        machine.set_pindirs([D0_PIN, 14, 15, 16].map(|pin| (pin, PinDir::Input)));
        let transfer = double_buffer::Config::new(channels, received, first).start().write_next(second);
        armed.write(BITS - 1);
        armed.write(BITS - 1);
        let (transfer, pixels) = (Some(transfer), Some(third));
        Some(Self { timer, _machine: machine.start(), armed, transfer, pixels, torn: false })
    }

    /// Returns the pixels of the newest frame, or of the next one if that was returned before. The frame after it is
    /// then being read into the second buffer, and the third waits. `None` if no frame ends in time.
    pub fn frame(&mut self) -> Option<&[u8]> {
        let deadline = self.timer.get_counter().ticks() + PATIENCE_MICROSECONDS;
        self.next(deadline)?;
        if self.torn {
            self.next(deadline)?;
            self.torn = false;
        }
        // An update can take longer than a frame.
        while self.transfer.as_ref()?.is_done() {
            self.next(deadline)?;
        }
        let words: &[u32] = self.pixels.as_deref()?;
        // SAFETY: any four bytes are a word, and bytes need no alignment.
        let (_, pixels, _) = unsafe { words.align_to() };
        Some(pixels)
    }

    /// Waits for the end of a frame, makes it `pixels`, and gives the buffer that it takes the place of to the camera.
    fn next(&mut self, deadline: u64) -> Option<()> {
        while !self.transfer.as_ref()?.is_done() {
            if self.timer.get_counter().ticks() > deadline {
                self.torn = true;
                return None;
            }
        }
        let (full, transfer) = self.transfer.take()?.wait();
        let empty = self.pixels.replace(full)?;
        self.transfer = Some(transfer.write_next(empty));
        self.armed.write(BITS - 1);
        Some(())
    }
}

fn write(bus: &mut impl I2c, (register, value): (u16, u8)) -> Option<()> {
    let [high, low] = register.to_be_bytes();
    bus.write(ADDRESS, &[high, low, value]).ok()
}
