#!/usr/bin/env bash
# Writes the guide's page on the cost of accuracy (src/guide/explanation/cost.md, its figures in
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
    cat <<'PAGE'
# Cost of accuracy

For each setting of a scene this page compares the error with CPU time and evaluations of the right-hand
side; all other settings keep their reference values. `squeakscope cost SCENE` runs the same study for
any scene. It draws the figures, writes a recording for the viewer (`cost.rrd`, with one tab for each
setting) and recommends settings; `--write` stores them in the scene, and `--accuracy 1e-4` applies them.
Errors of the state are the largest relative errors within the given time, in the energy norm of the
vibration. A cell contains the error, the CPU time and, where they exist, the evaluations. The figures
below show the integrators of all scenes and the other settings of `torus-3deg`. The largest exponents
are estimates over 100 ms and only limit the time over which trajectories are compared. `benches/cost.sh`
writes this page.

# Error budget

The settings are also chosen together. For each quantity (by default frequency of the strongest line,
amplitude and rms velocity of the settled motion) the total relative error is modelled as a sum:

```text
E = E_integrator + E_nodes + E_reduction + E_modes + E_elements + E_averaging
```

Each term is measured by refining one source alone, up to a reference: tolerances down to 1e-8, 2,000 contact
nodes in rings, elements of order 4 and 4 mm, 2.56 s of averaging. The error of a level is its difference from
the reference, but at least that of the finer levels, plus the error of the reference, extrapolated from the last
two differences with their ratio (Richardson; a ratio above 0.5 counts as 0.5). For the averaging time it is the
scatter of three successive windows. Published frequencies define eleven modes, so that the number of modes is a
source only with `frequencies = "fe"`.

The CPU time is modelled as setup + evaluations x time of one evaluation, each measured per level. Of all
combinations whose modelled errors are within the target, the cheapest is run, and so is the combination with
every source at its next finer level. The verified error is

```text
difference of the two runs + modelled error of the finer run
```

in which the averaging time counts with the error of the choice, because the phase of a window is a matter of
chance.

If it exceeds the target, the model is scaled by the ratio of verified and modelled error, and the next
combination is tried, at most three; a choice that fails is reported and not written to the scene.

The verified error is an estimate, not a strict bound: a motion that is not fully settled after 0.1 s, and sources
that interact, can exceed it. For `torus-3deg` and the target 1e-2 the frequency
differed by 2.3e-5 from a run with 3,000 nodes, elements of 4 mm, a tolerance of 1e-9 and 1 s of averaging, and
2.2e-5 had been verified.

The error refers to the model: it contains no error of the published frequencies, of the friction law or of the
Hertz patch. It holds for the settled motion that the scene reaches; where attractors coexist, another setting
can lead to another one, and the verification then fails. A chaotic motion has neither an exact line nor a
converging amplitude, and the study says so; its rms velocity and exponent have the scatter of their averages.

# Measurements

PAGE
    echo "Times are for one core of ${machine:-an unknown processor}."
    echo
    for scene in "${scenes[@]}"; do cat "$work/$scene.md"; done
    cat <<'PAGE'
# Growth of cost

`squeakscope growth SCENE` measures CPU time and peak memory. The modes are those of the finite elements,
because the paper has only eleven; faster modes need shorter steps. Sweeps are measured in wall time. The
memory of a run consists of its windows and the index of the recording. The index has a line for each
chunk of the recording and is written at the end. Without a recording (`--npz`) the memory does not grow
with the length of the run.

PAGE
    sed 's/^## /## In /' "$work/growth.md"
    echo '# Figures'
} > src/guide/explanation/cost.md
# Markdown needs each HTML figure on one line.
for figure in "${scenes[@]/%//cost-integrator.svg}" torus-3deg/cost-{invariants,events,nodes,modes,elements,exponents,recurrence}.svg growth/growth.svg; do
    echo "<div>$(tr '\n' ' ' < "$work/$figure" |
        sed 's/ width="[0-9.]*mm" height="[0-9.]*mm"/ width="100%"/')</div>"
    echo
done > src/guide/explanation/cost.html
# The how-to page has the advice for one scene between two marks.
how_to=src/guide/how_to/choose_accuracy.md
awk '/^[|]/ { table = 1; print; next } table { print ""; exit }' "$work/torus-3deg.md" > "$work/table"
sed -i -e '/<!-- cost -->/,/<!-- end of cost -->/{/<!-- cost -->/{p;r '"$work/table"'
};/<!-- end of cost -->/p;d}' "$how_to"
