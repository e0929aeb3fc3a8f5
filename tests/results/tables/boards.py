"""Boards by their names in a shop, with the library for each, and the updates a second that its processor allows."""

from typing import NamedTuple


class Board(NamedTuple):
    name: str
    chip: str
    # The clock in MHz; 0 if the processor has no estimate.
    clock: int
    # The processor in the table of cycles, or a family in the ratios of instructions.
    processor: str
    ram: str
    archive: str
    # The largest tracker that fits.
    most: str
    tried: str


TRACKERS = ("paper", "robust", "refined")

BOARDS = [
    Board("ESP32-CAM (AI Thinker)", "ESP32", 240, "xtensa", "520 KB, PSRAM", "xtensa", "refined", "sketch run in QEMU"),
    Board("XIAO ESP32S3 Sense", "ESP32-S3", 240, "xtensa", "512 KB, PSRAM", "xtensa", "refined", "sketch run in QEMU"),
    Board("M5Stack UnitCamS3", "ESP32-S3", 240, "xtensa", "512 KB, PSRAM", "xtensa", "refined", "run in QEMU"),
    Board("M5Stack Timer Camera", "ESP32", 240, "xtensa", "520 KB, PSRAM", "xtensa", "refined", "run in QEMU"),
    Board("ESP32-S3-EYE", "ESP32-S3", 240, "xtensa", "512 KB, PSRAM", "xtensa", "refined", "run in QEMU"),
    Board("ESP32-S2-Kaluga-1", "ESP32-S2", 240, "xtensa", "320 KB, PSRAM", "xtensa", "refined", "run in QEMU"),
    Board("XIAO ESP32C3", "ESP32-C3", 160, "riscv", "400 KB", "riscv32imc", "refined", "run in QEMU"),
    Board("ESP32-C6-DevKitC", "ESP32-C6", 160, "riscv", "512 KB", "riscv32imc", "refined", "run in QEMU"),
    Board("ESP32-P4-Function-EV-Board", "ESP32-P4", 360, "riscv", "768 KB, PSRAM", "riscv32imafc", "refined", "run in QEMU"),
    Board("OpenMV Cam H7 Plus", "STM32H743", 480, "cortex-m7", "1 MB", "cortex-m4", "refined", "run in QEMU"),
    Board("OpenMV Cam RT1062", "i.MX RT1062", 600, "cortex-m7", "1 MB", "cortex-m4", "refined", "run in QEMU"),
    Board("OpenMV N6", "STM32N657", 800, "cortex-m55", "4.2 MB", "cortex-m55", "refined", "run in QEMU"),
    Board("OpenMV AE3", "Alif Ensemble E3", 400, "cortex-m55", "13.5 MB", "cortex-m55", "refined", "run in QEMU"),
    Board("Arduino Nicla Vision", "STM32H747", 480, "cortex-m7", "1 MB", "cortex-m4", "refined", "sketch run in QEMU"),
    Board("Arduino Portenta H7, Vision Shield", "STM32H747", 480, "cortex-m7", "1 MB", "cortex-m4", "refined", "run in QEMU"),
    Board("Arduino GIGA R1", "STM32H747", 480, "cortex-m7", "1 MB", "cortex-m4", "refined", "run in QEMU"),
    Board("Arduino Nano 33 BLE Sense", "nRF52840", 64, "cortex-m4", "256 KB", "cortex-m4", "refined", "run in QEMU"),
    Board("Arduino UNO R4", "RA4M1", 48, "cortex-m4", "32 KB", "cortex-m4", "paper", "run in QEMU"),
    Board("XIAO nRF52840 Sense", "nRF52840", 64, "cortex-m4", "256 KB", "cortex-m4", "refined", "run in QEMU"),
    Board("nRF5340 DK", "nRF5340", 128, "cortex-m4", "512 KB", "cortex-m4", "refined", "run in QEMU"),
    Board("Grove Vision AI V2", "Himax WE2", 400, "cortex-m55", "2.4 MB", "cortex-m55", "refined", "run in QEMU"),
    Board("Arducam Pico4ML", "RP2040", 133, "cortex-m0plus", "264 KB", "cortex-m0plus", "refined", "run in QEMU"),
    Board("Raspberry Pi Pico", "RP2040", 133, "cortex-m0plus", "264 KB", "cortex-m0plus", "refined", "run in QEMU"),
    Board("Raspberry Pi Pico 2", "RP2350", 150, "cortex-m4", "520 KB", "cortex-m4", "refined", "run in QEMU"),
    Board("Raspberry Pi Pico 2, RISC-V", "RP2350", 150, "riscv", "520 KB", "riscv32imc", "refined", "run in QEMU"),
    Board("Raspberry Pi Zero 2 W", "RP3A0, Linux", 0, "", "512 MB", "aarch64-linux", "refined", "run in QEMU"),
    Board("Sipeed Maix Bit", "Kendryte K210", 400, "riscv", "8 MB", "riscv64imafc", "refined", "run in QEMU"),
    Board("Sipeed M1s Dock", "BL808", 480, "riscv", "768 KB, PSRAM", "riscv64gc", "refined", "run in QEMU"),
    Board("Milk-V Duo", "CV1800B, Linux", 1000, "riscv", "64 MB", "riscv64gc", "refined", "bare metal run in QEMU, not Linux"),
    Board("Sony Spresense", "CXD5602", 156, "cortex-m4", "1.5 MB", "cortex-m4", "refined", "run in QEMU"),
    Board("MAX78000FTHR", "MAX78000", 100, "cortex-m4", "128 KB", "cortex-m4", "refined (160x120)", "run in QEMU"),
    Board("STM32H747I-DISCO, B-CAMS-OMV", "STM32H747", 480, "cortex-m7", "1 MB", "cortex-m4", "refined", "run in QEMU"),
    Board("STM32N6570-DK", "STM32N657", 800, "cortex-m55", "4.2 MB", "cortex-m55", "refined", "run in QEMU"),
    Board("Teensy 4.1", "i.MX RT1062", 600, "cortex-m7", "1 MB", "cortex-m4", "refined", "run in QEMU"),
    Board("EK-RA8D1", "RA8D1", 480, "cortex-m85", "1 MB", "cortex-m55", "refined", "run in QEMU"),
]


def updates(board, cycles, ratios):
    """Updates a second of each tracker, with two digits. `cycles` has millions for each processor and tracker, `ratios` a family's instructions
    as multiples of those of the M4."""
    own = cycles["cortex-m4" if board.processor in ratios else board.processor]
    return [float(f"{board.clock / millions / ratio:.2g}") for millions, ratio in zip(own, ratios.get(board.processor, (1, 1, 1)))]


def row(board, cycles, ratios):
    most, _, note = board.most.partition(" ")
    rates = [f"{rate:.0f}" for rate in updates(board, cycles, ratios)] if board.clock else ["", "", "any"]
    at = TRACKERS.index(most)
    cells = [*rates[:at], f"**{rates[at]}** {note}".strip(), *["-"] * (2 - at)]
    chip = f"{board.chip}, {board.clock} MHz" if board.clock else board.chip
    return [board.name, chip, board.ram, f"`{board.archive}`", *cells, board.tried]


def rows(cycles, ratios):
    return [row(board, cycles, ratios) for board in BOARDS]
