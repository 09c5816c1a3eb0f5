#!/usr/bin/env bash
# Writes the tables of the guide's page on the cost of accuracy (src/guide/explanation/cost.md, its figures in
# src/guide/explanation/cost.html) and the table of advice in src/guide/how_to/choose_accuracy.md:
#
#     benches/cost.sh
#
# Takes about 6 min on an idle machine. Times depend on the machine; evaluations and errors do not.
set -euo pipefail
cd "$(dirname "$0")/.."

scenes=(periodic-2deg torus-3deg chaos-5deg impact-oscillator)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# SQUEAKSCOPE names a program that is already built.
program=${SQUEAKSCOPE:-}
if [ -z "$program" ]; then
    cargo build --release --bin squeakscope
    program="${CARGO_TARGET_DIR:-target}/release/squeakscope"
fi
for scene in "${scenes[@]}"; do
    "$program" cost "$scene" --out "$work/$scene" --markdown "$work/$scene.md"
done
"$program" growth torus-3deg --out "$work/growth" --markdown "$work/growth.md"
machine=$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)
{
    echo
    echo "Times are for one core of ${machine:-an unknown processor}."
    echo
    for scene in "${scenes[@]}"; do cat "$work/$scene.md"; done
} > "$work/measurements"
{
    echo
    sed 's/^## /## In /' "$work/growth.md"
} > "$work/growth.table"
awk '/^[|]/ { table = 1; print; next } table { print ""; exit }' "$work/torus-3deg.md" > "$work/advice"

# replace PAGE MARK FILE: replaces the text between two marks of a page.
replace() {
    sed -i -e "/<!-- $2 -->/,/<!-- end of $2 -->/{/<!-- $2 -->/{p;r $3
};/<!-- end of $2 -->/p;d}" "$1"
}
replace src/guide/explanation/cost.md measurements "$work/measurements"
replace src/guide/explanation/cost.md growth "$work/growth.table"
replace src/guide/how_to/choose_accuracy.md cost "$work/advice"

# Markdown needs each HTML figure on one line.
for figure in "${scenes[@]/%//cost-integrator.svg}" torus-3deg/cost-{invariants,events,nodes,modes,elements,exponents,recurrence}.svg growth/growth.svg; do
    echo "<div>$(tr '\n' ' ' < "$work/$figure" |
        sed 's/ width="[0-9.]*mm" height="[0-9.]*mm"/ width="100%"/')</div>"
    echo
done > src/guide/explanation/cost.html
