"""Chooses the libsmr.a for a board. PlatformIO runs this script before it builds a program with the library."""

import os

Import("env")  # noqa: F821 (from PlatformIO)

board = env.BoardConfig()  # noqa: F821
names = ("CCFLAGS", "CFLAGS", "CXXFLAGS", "LINKFLAGS")
flags = [str(flag) for name in names for flag in env.Flatten(env.get(name, []))]  # noqa: F821
cpus = [flag[len("-mcpu=") :] for flag in flags if flag.startswith("-mcpu=")]
cpus += [board.get("build.cpu", ""), board.get("build.mcu", "")]
found = [path for cpu in cpus if cpu and os.path.isfile(path := f"src/{cpu}/libsmr.a")]
if not found:
    print(f"SMRTracker has no src/{cpus[0] or cpus[-1]}/libsmr.a: see its README.")
    env.Exit(1)  # noqa: F821
env.Append(LIBPATH=[os.path.dirname(os.path.abspath(found[0]))], LIBS=["smr"])  # noqa: F821
