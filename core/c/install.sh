#!/usr/bin/env bash
# Installs the C library: core/c/install.sh [--refiner] PREFIX [TARGET]
#
# Builds libsmr.a and installs it under PREFIX with the header, a package for CMake (find_package(smr)) and one for pkg-config.
# TARGET is a target of Rust, such as thumbv7em-none-eabihf; without it, the library is built for this machine. If the compiler in use
# lacks the target, .ci/target-cargo finds another compiler or reports what to install.
# --refiner builds the library with the refiner, so that smr_init accepts the configuration of smr_config_refined. Both packages tell
# whether the library has the refiner, yes or no: pkg-config --variable=refiner smr, and smr_REFINER of CMake; and define SMR_REFINER,
# without which a program reserves the refiner's memory.
#
# Environment:
#   SMR_PIXELS, SMR_SPAN   the largest box and window. Both packages define them, so that programs are compiled with equal values.
#   SMR_LIBRARY            a libsmr.a to install instead of building one
set -euo pipefail

refiner=no
if [ "${1:-}" = --refiner ]; then
  refiner=yes
  shift
fi
if [ $# -lt 1 ] || [ $# -gt 2 ] || [[ $1 == -* ]]; then
  echo "usage: core/c/install.sh [--refiner] PREFIX [TARGET]" >&2
  exit 2
fi
if [ "${2:-}" = xtensa-none-elf ] && [ -z "${SMR_LIBRARY:-}" ]; then
  echo "error: .ci/release archives xtensa builds the library for Xtensa: set SMR_LIBRARY to it" >&2
  exit 2
fi
mkdir -p "$1"
prefix=$(cd "$1" && pwd)
target=${2:-}
here=$(cd "$(dirname "$0")" && pwd)
[ -z "${SMR_LIBRARY:-}" ] || SMR_LIBRARY=$(realpath "$SMR_LIBRARY")
cd "$here/../.."

# Reads the library's path from Cargo's messages, because its folder depends on the compiler and the environment.
library=${SMR_LIBRARY:-}
if [ -z "$library" ]; then
  build=(cargo build)
  if [ -n "$target" ]; then
    build+=(--target "$target")
    # If the compiler in use cannot build for the target, another installed compiler may be able to.
    [ -d "$(rustc --print target-libdir --target "$target" 2>/dev/null)" ] || build=(.ci/target-cargo "$target" build)
  fi
  build+=(-p smr-c --profile firmware --locked --message-format json-render-diagnostics)
  [ "$refiner" = no ] || build+=(--features refiner)
  library=$("${build[@]}" | sed -n 's/.*"filenames":\[[^]]*"\([^"]*libsmr\.a\)".*/\1/p' | tail -n 1)
fi
[ -f "$library" ] || { echo "error: no library: ${library:-cargo did not build libsmr.a}" >&2; exit 1; }

number() { sed -n "s/^#define SMR_VERSION_$1 //p" "$here/include/smr.h"; }
version=$(number MAJOR).$(number MINOR).$(number PATCH)
definitions=("SMR_REFINER=$([ "$refiner" = no ] && echo 0 || echo 1)")
[ -z "${SMR_PIXELS:-}" ] || definitions+=("SMR_PIXELS=$SMR_PIXELS")
[ -z "${SMR_SPAN:-}" ] || definitions+=("SMR_SPAN=$SMR_SPAN")
# On a host libsmr.a contains Rust's standard library, which needs system libraries; --gc-sections drops unused parts.
libraries=
case $target in
  *-none-* | *-none) ;;
  *) [ "$(uname -s)" != Linux ] || libraries="-lpthread -ldl -lm" ;;
esac

mkdir -p "$prefix/include" "$prefix/lib/pkgconfig" "$prefix/lib/cmake/smr"
cp "$here/include/smr.h" "$prefix/include/smr.h"
cp "$library" "$prefix/lib/libsmr.a"

cat >"$prefix/lib/pkgconfig/smr.pc" <<END
prefix=\${pcfiledir}/../..
refiner=$refiner

Name: smr
Description: Visual tracking by the Similarity Matching Ratio
Version: $version
Cflags: -I\${prefix}/include${definitions[*]/#/ -D}
Libs: -L\${prefix}/lib -lsmr -Wl,--gc-sections $libraries
END

cp "$here"/packages/cmake/smr-config{,-version}.cmake "$prefix/lib/cmake/smr"
cat >"$prefix/lib/cmake/smr/smr-installed.cmake" <<END
set(smr_LIBRARY "\${smr_prefix}/lib/libsmr.a")
set(smr_REFINER $refiner)
set(smr_DEFINITIONS "$(IFS=';'; echo "${definitions[*]}")")
set(smr_LIBRARIES "${libraries// /;}")
END

with=
[ "$refiner" = no ] || with=" with the refiner"
echo "smr $version$with${target:+ for $target} in $prefix"
