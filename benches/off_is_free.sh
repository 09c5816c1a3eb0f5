#!/usr/bin/env bash
# Updates the table of the guide's page on disabled effects (src/guide/explanation/off.md):
#
# benches/off_is_free.sh
#
# Requires valgrind, and an otherwise idle machine for the times. Instruction counts are the same on any
# machine with AVX2. Fails if a kernel exceeds its limit of instructions.
set -euo pipefail
cd "$(dirname "$0")/.."

command -v valgrind >/dev/null || { echo "valgrind is missing: apt-get install valgrind" >&2; exit 1; }
out=$(mktemp)
trap 'rm -f "$out"' EXIT
# Build without the features that the kernels do not need.
cargo test --release --no-default-features --lib -- --ignored --nocapture \
    joint::tests::off_is_free::off_is_free | tee "$out"
machine=$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)
{
    sed '/<!-- table -->/q' src/guide/explanation/off.md
    echo
    echo "Measured on: ${machine:-an unknown processor}, $(valgrind --version), $(rustc --version | cut -d' ' -f1,2)."
    echo
    grep '^|' "$out"
    echo
    sed -n '/<!-- end of table -->/,$p' src/guide/explanation/off.md
} > "$out.md"
mv "$out.md" src/guide/explanation/off.md
