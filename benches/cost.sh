#!/usr/bin/env bash
# The guide's page on what accuracy costs and how cost grows (src/guide/cost.md, its figures in
# src/guide/cost.html), and the small table of the README, from one command:
#
#     benches/cost.sh
#
# It takes about six minutes on a machine that does nothing else. Times are of the machine that runs it; calls and errors are not.
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
"$program" growth torus-3deg --out "$work/growth" --page "$work/growth.md"
machine=$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)
{
    cat <<'PAGE'
# What accuracy costs

Each knob of a scene is turned with all others at their reference, and the error is set against CPU time and
calls of the right-hand side; `squeakscope cost SCENE` does it for any scene, draws it, records it for the
viewer (`cost.rrd`: a tab a knob), and ends in advice, which `--write` puts into the scene and
`--accuracy 1e-4` takes. Errors of the state are the largest within
the time given, in the norm of the vibration's energy, relative to its size. A cell has the error, the CPU
time and, where there are any, the calls; the integrators of all scenes and the other knobs of `torus-3deg`
are drawn below. This page is made by `benches/cost.sh`.

PAGE
    echo "Times are of ${machine:-an unknown processor}, one core."
    echo
    for scene in "${scenes[@]}"; do cat "$work/$scene.md"; done
    cat <<'PAGE'
# How cost grows

`squeakscope growth SCENE` measures it: CPU time, and the most memory that the program held meanwhile. Modes
are of finite elements, as the paper has eleven only; the faster they are, the shorter the steps. A sweep is
timed by the clock. A run's memory is that of its windows and of the recording's index, which has a line for
each piece of the recording and is written at its end; without a recording (`--npz`) it does not grow.

PAGE
    sed 's/^## /## In /' "$work/growth.md"
    echo '# Drawn'
} > src/guide/cost.md
# A figure in a line of its own, as HTML wants it within Markdown.
for figure in "${scenes[@]/%//cost-integrator.svg}" torus-3deg/cost-{invariants,events,nodes,modes,elements,exponents,recurrence}.svg growth/growth.svg; do
    echo "<div>$(tr '\n' ' ' < "$work/$figure" |
        sed 's/ width="[0-9.]*mm" height="[0-9.]*mm"/ width="100%"/')</div>"
    echo
done > src/guide/cost.html
# The advice for one scene stands in the README, between two marks.
sed -n '/^| for an error/,/^$/p' "$work/torus-3deg.md" > "$work/table"
sed -i -e '/<!-- cost -->/,/<!-- end of cost -->/{/<!-- cost -->/{p;r '"$work/table"'
};/<!-- end of cost -->/p;d}' README.md
