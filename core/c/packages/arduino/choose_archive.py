"""Chooses the libsmr.a for a board. PlatformIO runs this before it builds a program with the library."""

import glob
import os

Import("env")  # noqa: F821 (from PlatformIO)

board = env.BoardConfig()  # noqa: F821
names = ("CCFLAGS", "CFLAGS", "CXXFLAGS", "LINKFLAGS")
flags = [str(flag) for name in names for flag in env.Flatten(env.get(name, []))]  # noqa: F821
cpus = [flag[len("-mcpu=") :] for flag in flags if flag.startswith("-mcpu=")]
cpus += [board.get("build.cpu", ""), board.get("build.mcu", "")]
# The archives without a name for the floating point unit can be linked with -mfloat-abi=softfp and soft.
archive = "*-hard/libsmr.a" if "-mfloat-abi=hard" in flags else "libsmr.a"
found = [path for cpu in cpus if cpu for path in glob.glob(f"src/{cpu}/{archive}")]
if not found:
    print(f"SMRTracker has no src/{cpus[0] or cpus[-1]}/{archive}. Xtensa (ESP32, S2, S3): see its README.")
    env.Exit(1)  # noqa: F821
env.Append(LIBPATH=[os.path.dirname(os.path.abspath(found[0]))], LIBS=["smr"])  # noqa: F821
