"""Tests library.properties, choose_archive.py (as PlatformIO runs it) and Kconfig of the assembled packages: packages.py FOLDER."""

import contextlib
import io
import os
import pathlib
import re
import runpy
import sys

out = sys.argv[1]


class Environment(dict):
    """PlatformIO's build environment, as far as choose_archive.py uses it."""

    added = None

    def BoardConfig(self):
        return self["board"]

    def Flatten(self, flags):
        return flags

    def Append(self, **added):
        self.added = added

    def Exit(self, status):
        raise SystemExit(status)


def chosen(flags, board):
    """The folder below src from which choose_archive.py takes the archive for a board."""
    env = Environment(CCFLAGS=flags, board=board)
    runpy.run_path("choose_archive.py", init_globals={"Import": lambda name: None, "env": env})
    (folder,) = env.added["LIBPATH"]
    assert os.path.isfile(f"{folder}/libsmr.a") and env.added["LIBS"] == ["smr"]
    return os.path.relpath(folder, "src")


def kconfig():
    """Checks that Kconfig has no warning, and offers CONFIG_SMR on a Cortex-M, but not on 64-bit Arm or a 32-bit desktop."""
    try:
        import kconfiglib
    except ImportError:
        return print("skipped: Kconfig: no kconfiglib")
    os.environ["srctree"] = f"{out}/zephyr/smr"
    for cpu, value in (("CPU_CORTEX_M", "y"), ("ARM64", "n"), ("ARCH_POSIX", "n")):
        with open(f"{out}/tests/Kconfig", "w") as file:
            for name in ("CPU_CORTEX_M", "RISCV", "64BIT", "XTENSA", "ARM64", "ARCH_POSIX"):
                file.write(f"config {name}\n\tbool\n\tdefault {'y' if name == cpu else 'n'}\n")
            file.write('source "Kconfig"\n')
        read = kconfiglib.Kconfig(f"{out}/tests/Kconfig", warn_to_stderr=False)
        read.syms["SMR"].set_value("y")
        assert read.syms["SMR"].str_value == value and not read.warnings, read.warnings
    print("Kconfig: CONFIG_SMR is there for a Cortex-M, and not for 64 bits of Arm")


os.chdir(f"{out}/SMRTracker")
properties = dict(line.split("=", 1) for line in pathlib.Path("library.properties").read_text().splitlines())
# Checks that the library keeps arduino-lint's rules for Arduino's index: all needed properties are set and well-formed.
needed = {"name", "version", "author", "maintainer", "sentence", "paragraph", "category", "url", "architectures", "includes"}
assert all(properties.get(key, "").strip() for key in needed), needed - properties.keys()
assert re.fullmatch(r"[A-Za-z][\w .-]{,62}", properties["name"]) and re.fullmatch(r"\d+\.\d+\.\d+", properties["version"])
assert properties["url"].startswith("https://") and properties["category"] == "Signal Input/Output"
files = ["src/" + properties["includes"], "README.md", "LICENSE-MIT", *(f"examples/{name}/{name}.ino" for name in os.listdir("examples"))]
assert all(map(os.path.isfile, files)), files

assert chosen(["-mthumb", "-mcpu=cortex-m7", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard"], {}) == "cortex-m7"
assert chosen([], {"build.cpu": "cortex-m0plus", "build.mcu": "rp2040"}) == "cortex-m0plus"
assert chosen(["-march=rv32imac"], {"build.mcu": "esp32c6"}) == "esp32c6"
assert chosen(["-mlongcalls"], {"build.mcu": "esp32s3"}) == "esp32s3"
with contextlib.redirect_stdout(io.StringIO()) as said, contextlib.suppress(SystemExit):
    chosen([], {"build.mcu": "esp8266"})
assert "no src/esp8266/libsmr.a" in said.getvalue()
print("choose_archive.py: 4 boards have an archive, and an ESP8266 is refused")
kconfig()
