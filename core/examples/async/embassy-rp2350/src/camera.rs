//! A 320x240 camera at the PIO: pushes the lines of a frame into a read-out.

use embassy_futures::join::join;
use embassy_rp::dma;
use embassy_rp::gpio::Input;
use embassy_rp::peripherals::PIO0;
use embassy_rp::pio::StateMachine;
use smr_core::readout::{Format, Readout};

pub const WIDTH: u16 = 320;
pub const HEIGHT: u16 = 240;
pub const FORMAT: Format = Format::YUYV;
pub const LINE_BYTES: usize = FORMAT.line_bytes(WIDTH);

pub type Line = [u8; LINE_BYTES];

pub struct Camera {
    pub machine: StateMachine<'static, PIO0, 0>,
    pub dma: dma::Channel<'static>,
    pub vsync: Input<'static>,
    pub lines: &'static mut [Line; 2],
}

impl Camera {
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
