//! A 320x240 camera at the PIO: pushes the lines of a frame into a read-out.
//!
//! | pin | connects to |
//! |---|---|
//! | GP6 to GP13 | camera D0 to D7 |
//! | GP14, GP15, GP16 | camera PCLK, HREF, VSYNC |
//!
//! Set your sensor's registers by I2C: 320x240, YUYV, PCLK at most 12 MHz, VSYNC high between frames.

use embassy_futures::join::join;
use embassy_rp::gpio::{Input, Pull};
use embassy_rp::peripherals::{
    DMA_CH0, PIN_6, PIN_7, PIN_8, PIN_9, PIN_10, PIN_11, PIN_12, PIN_13, PIN_14, PIN_15, PIN_16, PIO0,
};
use embassy_rp::pio::program::pio_asm;
use embassy_rp::pio::{self, Direction, FifoJoin, Pio, ShiftConfig, ShiftDirection, StateMachine};
use embassy_rp::{Peri, bind_interrupts, dma};
use smr_core::Rect;
use smr_core::readout::{Format, Readout};
use static_cell::ConstStaticCell;

pub const WIDTH: u16 = 320;
pub const HEIGHT: u16 = 240;
pub const FORMAT: Format = Format::YUYV;
/// The whole frame.
pub const FRAME: Rect = Rect::new(0, 0, WIDTH, HEIGHT);
const LINE_BYTES: usize = FORMAT.line_bytes(WIDTH);

type Line = [u8; LINE_BYTES];

static LINES: ConstStaticCell<[Line; 2]> = ConstStaticCell::new([[0; LINE_BYTES]; 2]);

bind_interrupts!(struct Interrupts {
    PIO0_IRQ_0 => pio::InterruptHandler<PIO0>;
    DMA_IRQ_0 => dma::InterruptHandler<DMA_CH0>;
});

type Pin<P> = Peri<'static, P>;

/// The peripherals and pins of the camera.
pub struct Wires {
    pub pio: Peri<'static, PIO0>,
    pub dma: Peri<'static, DMA_CH0>,
    pub data: (Pin<PIN_6>, Pin<PIN_7>, Pin<PIN_8>, Pin<PIN_9>, Pin<PIN_10>, Pin<PIN_11>, Pin<PIN_12>, Pin<PIN_13>),
    pub pclk: Pin<PIN_14>,
    pub href: Pin<PIN_15>,
    pub vsync: Pin<PIN_16>,
}

pub struct Camera {
    machine: StateMachine<'static, PIO0, 0>,
    dma: dma::Channel<'static>,
    vsync: Input<'static>,
    lines: &'static mut [Line; 2],
}

impl Camera {
    /// The calling core takes the interrupts of the DMA.
    pub fn new(wires: Wires) -> Self {
        let mut pio = Pio::new(wires.pio, Interrupts);
        let (d0, d1, d2, d3, d4, d5, d6, d7) = wires.data;
        let data = [
            pio.common.make_pio_pin(d0),
            pio.common.make_pio_pin(d1),
            pio.common.make_pio_pin(d2),
            pio.common.make_pio_pin(d3),
            pio.common.make_pio_pin(d4),
            pio.common.make_pio_pin(d5),
            pio.common.make_pio_pin(d6),
            pio.common.make_pio_pin(d7),
        ];
        let clocks = [pio.common.make_pio_pin(wires.pclk), pio.common.make_pio_pin(wires.href)];
        // PIO program: while HREF (GP15) is high, reads a byte at each rising edge of PCLK (GP14).
        let program =
            pio_asm!(".wrap_target", "wait 1 gpio 15", "wait 1 gpio 14", "in pins, 8", "wait 0 gpio 14", ".wrap");
        let mut config = pio::Config::default();
        config.use_program(&pio.common.load_program(&program.program), &[]);
        config.set_in_pins(&data.each_ref());
        // The PIO pushes each byte at once, as the low byte of a word. The DMA reads only that byte.
        config.shift_in = ShiftConfig { auto_fill: true, threshold: 8, direction: ShiftDirection::Left };
        config.fifo_join = FifoJoin::RxOnly;
        pio.sm0.set_config(&config);
        pio.sm0.set_pin_dirs(Direction::In, &data.each_ref());
        pio.sm0.set_pin_dirs(Direction::In, &clocks.each_ref());
        Self {
            machine: pio.sm0,
            dma: dma::Channel::new(wires.dma, Interrupts),
            vsync: Input::new(wires.vsync, Pull::None),
            lines: LINES.take(),
        }
    }

    /// Waits for the next frame and pushes its lines, up to the windows' last line or the first line that is refused.
    pub async fn read(&mut self, readout: &mut Readout, pixels: &mut [u8]) {
        let [mut filling, mut full] = self.lines.each_mut();
        self.machine.set_enable(false);
        self.vsync.wait_for_falling_edge().await;
        // Drops remaining bytes of the previous frame.
        self.machine.clear_fifos();
        self.machine.restart();
        self.machine.set_enable(true);
        for y in 0..=HEIGHT {
            if readout.is_complete() {
                break;
            }
            // The DMA fills `filling` with line y, while the read-out takes line y - 1 from `full`.
            let fill = async {
                if y < HEIGHT {
                    self.machine.rx().dma_pull(&mut self.dma, &mut filling[..], false).await;
                }
            };
            let push = async {
                if let Some(y) = y.checked_sub(1) {
                    let _ = readout.push_line(y, full, pixels);
                }
            };
            join(fill, push).await;
            (filling, full) = (full, filling);
        }
    }
}
