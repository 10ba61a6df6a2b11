#!/usr/bin/env bash
# The published study of docs/error-vs-time/, on the default device. README.md shows its plot and table.
#
#     benches/error_vs_time.sh             the plot and its table: under 15 minutes on two cores, after the references
#     benches/error_vs_time.sh tables      exponents, Veach's bound, cost of the estimate: about 15 minutes
#     benches/error_vs_time.sh coverage    coverage of the estimate, 8000 renders: about 15 minutes
#     benches/error_vs_time.sh all
#     benches/error_vs_time.sh rehearsal DIR
#                                          every step of the first with one scene in small, into DIR and nothing else: for CI
#
# The first run renders references (15 minutes more) and keeps them in target/error-vs-time/references, with a page of all curves beside them
# (target/error-vs-time/index.html). The real model needs the assets: STERADIAN_ASSETS, else ../shared/assets; without them it is left out, and
# said. BUDGET (seconds of a run, 5) and REPEATS (5) make it shorter. Tables are put between the marks of the two README.md.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
here=$PWD
cd "$root"
part=${1:-plot}
out=target/error-vs-time
docs=docs/error-vs-time
readme=README.md
scenes=(scenes/cornell.toml scenes/veach.toml scenes/showcase.toml)
height=128
if [[ $part == rehearsal ]]; then
    if [[ -z ${2:-} ]] || ! docs=$(cd "$here" && mkdir -p "$2" 2>/dev/null && cd "$2" && pwd); then
        echo "benches/error_vs_time.sh: rehearsal: '${2:-}' is no folder and cannot be made one; give another" >&2
        exit 2
    fi
    out=$docs/work readme=$docs/project.md
    cp README.md "$readme"
    cp docs/error-vs-time/README.md "$docs"
    scenes=(scenes/veach.toml) height=16 BUDGET=0.3 REPEATS=2
fi
mkdir -p "$out" "$docs"

# splice FILE NAME FRAGMENT: the fragment takes the place of what stands between <!-- NAME --> and <!-- /NAME -->.
splice() {
    awk -v name="$2" -v fragment="$3" '
        $0 == "<!-- " name " -->" { print; while ((getline line < fragment) > 0) print line; is_inside = 1; next }
        $0 == "<!-- /" name " -->" { is_inside = 0 }
        !is_inside { print }' "$1" >"$out/spliced"
    cat "$out/spliced" >"$1"
}

# The real model, where it is.
add_model() {
    if [[ -d $STERADIAN_ASSETS/gltf ]]; then
        scenes+=(scenes/peer_d.toml)
    else
        echo "skipped: no assets: scenes/peer_d.toml (a glTF model under an HDR sky)" >&2
    fi
}

plot() {
    export STERADIAN_ASSETS=${STERADIAN_ASSETS:-../shared/assets}
    # Paths in scenes count from the scene's folder.
    [[ $STERADIAN_ASSETS == /* ]] || STERADIAN_ASSETS=$(realpath -m "$STERADIAN_ASSETS")
    [[ $part == rehearsal ]] || add_model
    ./x converge "${scenes[@]}" --height "$height" --variants mis,mis+independent,bsdf,light \
        --budget "${BUDGET:-5}" --repeats "${REPEATS:-5}" -o "$out"
    cp "$out"/{overview.svg,runs.csv,summary.json,table.md,veach-equal-time.png} "$docs"
    sed "s#(runs.csv)#($docs/runs.csv)#" "$docs/table.md" >"$out/table-of-readme.md"
    splice "$readme" error-vs-time "$out/table-of-readme.md"
    splice "$docs/README.md" error-vs-time "$docs/table.md"
}

bench() {
    ./x bench --filter "$@" -o "$docs"
    splice "$docs/README.md" "$1" "$docs/$1.md"
}

tables() {
    bench exponents --seeds 16
    bench mis-bound --rounds 3
    bench estimate
}

case $part in
    plot | rehearsal) plot ;;
    tables) tables ;;
    coverage) bench coverage ;;
    all) plot && tables && bench coverage ;;
    *)
        echo "benches/error_vs_time.sh: '$part' is none of plot, tables, coverage, all, rehearsal" >&2
        exit 2
        ;;
esac
