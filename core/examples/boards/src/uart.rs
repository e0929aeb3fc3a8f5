//! The board's UART that its USB connector or debugger shows: 115,200 baud, 8 bits, no parity. Only sends.

use core::fmt;
use core::ptr::with_exposed_provenance_mut;

pub struct Uart(());

fn write(address: usize, value: u32) {
    // SAFETY: the callers name registers of this board's chip, which no other code uses.
    unsafe { with_exposed_provenance_mut::<u32>(address).write_volatile(value) }
}

fn read(address: usize) -> u32 {
    // SAFETY: the callers name registers of this board's chip.
    unsafe { with_exposed_provenance_mut::<u32>(address).read_volatile() }
}

/// UART of an nRF51: TX is pin 24, which the micro:bit's debugger reads.
#[cfg(feature = "microbit")]
impl Uart {
    const BASE: usize = 0x4000_2000;

    pub fn new() -> Self {
        const TX: u32 = 24;
        write(0x5000_0508, 1 << TX); // OUTSET
        write(0x5000_0518, 1 << TX); // DIRSET
        write(Self::BASE + 0x50C, TX); // PSELTXD
        write(Self::BASE + 0x524, 0x01D7_E000); // BAUDRATE
        write(Self::BASE + 0x500, 4); // ENABLE
        write(Self::BASE + 0x008, 1); // STARTTX
        Self(())
    }

    fn send(&mut self, byte: u8) {
        const TXDRDY: usize = Uart::BASE + 0x11C;
        write(TXDRDY, 0);
        write(Self::BASE + 0x51C, byte.into()); // TXD
        while read(TXDRDY) == 0 {}
    }
}

/// USART1 of an STM32: TX is pin PA9.
#[cfg(not(feature = "microbit"))]
impl Uart {
    #[cfg(feature = "stm32vldiscovery")]
    const BASE: usize = 0x4001_3800;
    #[cfg(feature = "netduinoplus2")]
    const BASE: usize = 0x4001_1000;

    pub fn new() -> Self {
        #[cfg(feature = "stm32vldiscovery")]
        let clock = {
            set(0x4002_1018, 1 << 14 | 1 << 2); // RCC_APB2ENR: USART1, port A
            write(0x4001_0804, read(0x4001_0804) & !0xF0 | 0xB0); // GPIOA_CRH: PA9 is an output of USART1
            8_000_000
        };
        #[cfg(feature = "netduinoplus2")]
        let clock = {
            set(0x4002_3830, 1); // RCC_AHB1ENR: port A
            set(0x4002_3844, 1 << 4); // RCC_APB2ENR: USART1
            write(0x4002_0000, read(0x4002_0000) & !(3 << 18) | 2 << 18); // GPIOA_MODER: PA9 belongs to a peripheral
            write(0x4002_0024, read(0x4002_0024) & !0xF0 | 0x70); // GPIOA_AFRH: to USART1
            16_000_000
        };
        write(Self::BASE + 0x08, clock / 115_200); // BRR
        write(Self::BASE + 0x0C, 1 << 13 | 1 << 3); // CR1: on, with transmitter
        Self(())
    }

    fn send(&mut self, byte: u8) {
        const EMPTY: u32 = 1 << 7;
        while read(Self::BASE) & EMPTY == 0 {}
        write(Self::BASE + 0x04, byte.into()); // DR
    }
}

#[cfg(not(feature = "microbit"))]
fn set(address: usize, bits: u32) {
    write(address, read(address) | bits);
}

impl fmt::Write for Uart {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.bytes().for_each(|byte| self.send(byte));
        Ok(())
    }
}
