#!/usr/bin/env bash
# The table of the guide's page on effects that are off (src/guide/off.md), from one command:
#
#     benches/off_is_free.sh
#
# It needs valgrind, and a machine that does nothing else for the times; the instructions are the same on
# any machine with AVX2. Fails where a kernel takes more instructions than it may.
set -euo pipefail
cd "$(dirname "$0")/.."

command -v valgrind >/dev/null || { echo "valgrind is missing: apt-get install valgrind" >&2; exit 1; }
out=$(mktemp)
trap 'rm -f "$out"' EXIT
# Without the features that the kernels do not need.
cargo test --release --no-default-features --lib -- --ignored --nocapture \
    joint::tests::off_is_free::off_is_free | tee "$out"
machine=$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)
{
    sed '/<!-- table -->/q' src/guide/off.md
    echo
    echo "Measured on: ${machine:-an unknown processor}, $(valgrind --version), $(rustc --version | cut -d' ' -f1,2)."
    echo
    grep '^|' "$out"
    echo
    sed -n '/<!-- end of table -->/,$p' src/guide/off.md
} > "$out.md"
mv "$out.md" src/guide/off.md
