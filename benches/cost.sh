#!/usr/bin/env bash
# The guide's page on what accuracy costs (src/guide/cost.md), the small table of the README, and the
# figures, from one command:
#
#     benches/cost.sh
#
# It takes about three minutes. Times are of the machine that runs it; calls and errors are not.
set -euo pipefail
cd "$(dirname "$0")/.."

scenes=(periodic-2deg torus-3deg chaos-5deg impact-oscillator)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# SQUEAKSCOPE is a program that is built already.
program=${SQUEAKSCOPE:-}
if [ -z "$program" ]; then
    cargo build --release --bin squeakscope
    program="${CARGO_TARGET_DIR:-target}/release/squeakscope"
fi
for scene in "${scenes[@]}"; do
    "$program" cost "$scene" --out "$work/$scene" --page "$work/$scene.md"
done
machine=$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)
{
    cat <<'PAGE'
# What accuracy costs

Each knob of a scene is turned with all others at their reference, and the error is set against CPU time and
calls of the right-hand side; `squeakscope cost SCENE` does it for any scene, draws it, records it for the
viewer (`cost.rrd`: a tab a knob), and ends in advice, which `--write` puts into the scene and
`--accuracy 1e-4` takes. Errors of the state are the largest within
the time given, in the norm of the vibration's energy, relative to its size. This page is made by
`benches/cost.sh`.

PAGE
    echo "Times are of ${machine:-an unknown processor}, one core."
    echo
    for scene in "${scenes[@]}"; do cat "$work/$scene.md"; done
} > src/guide/cost.md
# The advice for one scene stands in the README, between two marks.
sed -n '/^| for an error/,/^$/p' "$work/torus-3deg.md" > "$work/table"
sed -i -e '/<!-- cost -->/,/<!-- end of cost -->/{/<!-- cost -->/{p;r '"$work/table"'
};/<!-- end of cost -->/p;d}' README.md
