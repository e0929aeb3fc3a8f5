#!/usr/bin/env bash
# Builds the module smr as a native module, a file that MicroPython loads without a new firmware: core/micropython/native.sh [--refiner] ARCH MICROPYTHON FILE
#
# ARCH is MicroPython's name of the processor: armv6m, armv7emsp, rv32imc or x64 (Linux). MICROPYTHON is the folder of MicroPython's source, FILE
# the output. --refiner builds the module with the refiner.
#
# Needs gcc and binutils for the processor, a Python with pyelftools (PYTHON [default: python3]), and except for x64 the tools of .ci/target-cargo.
set -euo pipefail

usage() { echo "usage: core/micropython/native.sh [--refiner] armv6m|armv7emsp|rv32imc|x64 MICROPYTHON FILE" >&2; exit 2; }

features=()
if [ "${1:-}" = --refiner ]; then
  features=(--features refiner)
  shift
fi
[ $# -eq 3 ] || usage
arch=$1 micropython=$(realpath "$2") file=$(realpath -ms "$3")
headers=()
case $arch in
  armv6m) cargo=(.ci/target-cargo thumbv6m-none-eabi) gcc=arm-none-eabi-gcc flags=(-mthumb -mcpu=cortex-m0plus) ;;
  armv7emsp)
    cargo=(.ci/target-cargo thumbv7em-none-eabihf) gcc=arm-none-eabi-gcc
    flags=(-mthumb -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard) ;;
  rv32imc)
    cargo=(.ci/target-cargo riscv32imc-unknown-none-elf) gcc=riscv64-unknown-elf-gcc
    flags=(-march=rv32imac -mabi=ilp32 -mno-relax) headers=(--specs=picolibc.specs) ;;
  x64) cargo=(cargo) gcc=gcc flags=() ;;
  *) usage ;;
esac
cd "$(dirname "$0")/../.."
"${PYTHON:-python3}" -c 'import elftools' 2>/dev/null || { echo "error: ${PYTHON:-python3} has no module elftools, which writes the file: pip install pyelftools" >&2; exit 2; }

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# Builds position-independent code, in a folder for each processor: a change of rustc's flags would cause a rebuild.
built=$(realpath -m "${CARGO_TARGET_DIR:-target}")
library=$(CARGO_TARGET_DIR=$built/micropython/$arch CARGO_PROFILE_FIRMWARE_DEBUG=false RUSTFLAGS="-Crelocation-model=pic" \
  "${cargo[@]}" rustc -p smr-c --crate-type staticlib --profile firmware --locked --quiet "${features[@]}" \
  --message-format json-render-diagnostics | sed -n 's/.*"filenames":\[[^]]*"\([^"]*libsmr\.a\)".*/\1/p' | tail -n 1)

# Options as in py/dynruntime.mk. No separate sections: they move the module's start. No jump tables: they need libgcc.
compile=("$gcc" "${flags[@]}" "${headers[@]}" -I"$work" -I"$micropython" -Icore/c/include -std=gnu99 -Os -Wall -Wextra -Wno-unused-parameter -Werror
  -fpic -fno-common -fno-stack-protector -fno-jump-tables -U_FORTIFY_SOURCE -DNDEBUG -DNO_QSTR -DMICROPY_ENABLE_DYNRUNTIME
  -DMICROPY_FLOAT_IMPL=MICROPY_FLOAT_IMPL_NONE '-DMP_CONFIGFILE="names.h"')
mpy_ld=("${PYTHON:-python3}" "$micropython/tools/mpy_ld.py" --arch "$arch")
printf '#include <stdint.h>\ntypedef uintptr_t mp_off_t;\n' >"$work/names.h"
"${compile[@]}" -E core/micropython/smr/smr.c -o "$work/smr.i"
"${mpy_ld[@]}" --preprocess -o "$work/names.h" "$work/smr.i"
"${compile[@]}" -c core/micropython/smr/smr.c -o "$work/smr.o"
"$gcc" "${flags[@]}" -r -nostdlib -Wl,--gc-sections,-e,mpy_init,-z,noexecstack "$work/smr.o" "$library" -o "$work/module.o"
# On a host, libsmr.a has a variable (detected processor), which mpy_ld.py cannot place. It goes into the writable code.
variables=$(readelf -SW "$work/module.o" | sed -n 's/.* \(\.bss\.[^ ]*\) .*/--set-section-flags \1=alloc,load,data,contents --rename-section \1=.rodata.variable/p')
# shellcheck disable=SC2086 # one argument for each word
"${gcc%gcc}objcopy" --strip-unneeded -R .eh_frame -R '.ARM.ex*' -R '.rel.ARM.ex*' -R '.init_array*' $variables "$work/module.o"
"${mpy_ld[@]}" --qstrs "$work/names.h" -o "$file" "$work/module.o" >"$work/log" || { cat "$work/log" >&2; exit 1; }
printf '%s: %d bytes\n' "${file##*/}" "$(stat -c %s "$file")"
