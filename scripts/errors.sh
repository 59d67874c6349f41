#!/usr/bin/env bash
# Measures every error against the screen reference that pages quote (benches/runs/README.md has a row for each folder) again.
# This is needed after a change of that reference, since older records then no longer hold. Other programs may run at the same
# time: they make the recorded times rough, but do not change the errors. It takes an hour on two cores.
#
#   scripts/errors.sh OUT SCENES [FOLDER...]   SCENES contains ssct-rooms/ and sponza/; without FOLDER, all folders are measured
#
# The environment may set SSCT, the program. An interrupted run goes on where it was.
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }

root=$(cd "$(dirname "$0")/.." && pwd)
ssct=${SSCT:-${CARGO_TARGET_DIR:-$root/target}/debug/ssct}
out=${1:?usage: scripts/errors.sh OUT SCENES [FOLDER...]}
scenes=${2:?usage: scripts/errors.sh OUT SCENES [FOLDER...]}
shift 2
mkdir -p "$out"

# Measures into OUT/whole/FOLDER, and copies the records error.json, and the files named after --, to OUT/FOLDER.
run() { # folder, options... [-- file...]
    local folder=$1 options=() file
    shift
    while [ $# -gt 0 ] && [ "$1" != -- ]; do options+=("$1") && shift; done
    "$ssct" error "${options[@]}" -o "$out/whole/$folder" --resume >/dev/null
    mkdir -p "$out/$folder"
    for file in error.json "${@:2}"; do cp "$out/whole/$folder/$file" "$out/$folder/"; done
}

# Measures each scene of a list by its own run, and joins the records of all scenes to OUT/FOLDER/error.json.
together() { # folder, scenes separated by spaces, options...
    local folder=$1 all=$2 scene files=()
    shift 2
    for scene in $all; do
        run "parts/$folder/$scene" --scene "$scene" "$@"
        files+=("$out/parts/$folder/$scene/error.json")
    done
    mkdir -p "$out/$folder"
    python3 -c 'import json, sys; json.dump([r for f in sys.argv[1:] for r in json.load(open(f))], sys.stdout, indent=1)' \
        "${files[@]}" >"$out/$folder/error.json"
}

# Options of most runs: a small image with few rays. Without a sweep, only the given settings are measured.
small=(--size 320x180 --rays 16)
plain=("${small[@]}" --no-sweep)

# Each function from here on measures the folder, or the folders below it, that its name names with - in the place of _.
bars() {
    [ ! -e "$out/bars/errors.csv" ] || return 0
    WHAT=error ERROR_SIZES=480x270 RAYS=32 SSCT=$ssct "$root/scripts/bars.sh" "$out/bars" "$scenes"
}

error_rooms() {
    run error-rooms --scene rooms --method ssct,hzct,sslr,linear,poster,ssr,ssr-fast,dda,stochastic,unified --beyond none \
        "${plain[@]}" --samples 3 -- error-screen.svg
}

methods_quick() { run methods-quick --quick --no-sweep; }

impostors() {
    local scene
    for scene in street museum cathedral; do
        run "impostors/$scene" --scene "$scene" --method ssct,ssr,ssr-fast,pccm,billboard,ibr,environment "${plain[@]}" \
            --roughness 0,0.1 --samples 5
    done
}

search() {
    local common=(--scene rooms --method ssct,linear --roughness 0 "${plain[@]}" --samples 3)
    run search/published "${common[@]}"
    run search/tolerance "${common[@]}" --search-tolerance 0.0002
    run search/first "${common[@]}" --search-first 0.16667
    run search/both "${common[@]}" --search-tolerance 0.0002 --search-first 0.16667
}

cone_angle() {
    local common=(--scene rooms --method ssct,hzct --roughness 0.1,0.3,0.6 "${plain[@]}" --samples 3)
    run cone-angle/lobe "${common[@]}"
    run cone-angle/interpolated "${common[@]}" --cone-angle interpolated
}

dda() {
    local scene stride
    for scene in rooms museum street; do
        for stride in 1 4 16; do
            run "dda/$scene-stride-$stride" --scene "$scene" --method dda --roughness 0 "${small[@]}" --samples 1 \
                --dda-stride "$stride"
        done
        run "dda/$scene" --scene "$scene" --method dda,ssct,linear,unified --beyond none --roughness 0 "${plain[@]}" --samples 5
    done
}

stochastic() {
    local scene history common=(--beyond none --roughness 0.05,0.1,0.3,0.6 "${small[@]}" --samples 1 --fade off)
    for scene in rooms museum street; do
        run "stochastic/$scene" --scene "$scene" --method stochastic,unified,ssct "${common[@]}"
    done
    for history in rooms-16-1 museum-16-1 street-16-1 rooms-16-0.5 rooms-16-2 rooms-32-1 rooms-8-1; do
        IFS=- read -r scene frames deviations <<<"$history"
        run "stochastic/$scene-history-$frames-$deviations" --scene "$scene" --method stochastic,unified "${common[@]}" --no-sweep \
            --history on --history-frames "$frames" --history-deviations "$deviations"
    done
}

normals() {
    local kind common=(--scene rooms --method ssct,unified --beyond none --roughness 0,0.3 "${plain[@]}" --samples 5)
    for kind in shading geometric up; do
        run "normals/$kind" "${common[@]}" --trace-normals "$kind"
    done
    for kind in 0.05 0.2; do
        run "normals/bump-$kind" "${common[@]}" --trace-normals geometric --bump-after "$kind"
    done
}

poster() {
    local filter scene
    for filter in mip volume edge-aware; do
        for scene in rooms museum street; do
            run "poster/$filter/$scene" --scene "$scene" --method poster,ssct --poster-filter "$filter" --roughness 0,0.1,0.3 \
                "${plain[@]}" --samples 3
        done
    done
}

bounces() {
    local scene
    for scene in rooms museum; do
        run "bounces/$scene" --scene "$scene" --method ssct,unified,stochastic --beyond none --bounces 3 --bounces-sweep \
            --roughness 0,0.1,0.3,0.6 "${small[@]}" --samples 3
    done
}

chain_mask() {
    local mask common=(--method ssct,dda --roughness 0.1,0.3,0.6 "${plain[@]}" --samples 3)
    together chain-mask/hardware-none 'rooms museum street' "${common[@]}" --chain-filter hardware --chain-mask none
    for mask in none covered surface; do
        together "chain-mask/gaussian-$mask" 'rooms museum street' "${common[@]}" --chain-filter gaussian --chain-mask "$mask"
    done
}

claims() {
    local step half
    for step in 1 5 10 20; do
        run "claims/steps-$step" --scene street --view puddles --method ssr --roughness 0 --normal-deviation 0 "${plain[@]}" \
            --samples 1 --pixel-step "$step"
    done
    local hall=(--scene atrium --view hall --roughness 0,0.1 "${plain[@]}" --samples 1)
    run claims/hall-published "${hall[@]}" --method ssct,sslr
    run claims/hall-fine "${hall[@]}" --method sslr --uniform-steps 2000 --uniform-stride-min 0.0001 --uniform-stride-max 0.01
    half=(--scene rooms --method ssct,sslr --roughness 0,0.1,0.3 "${plain[@]}" --samples 1)
    run claims/full "${half[@]}"
    run claims/half "${half[@]}" --resolution-scale 0.5
}

[ $# -gt 0 ] || set -- bars error-rooms methods-quick impostors search cone-angle dda stochastic normals poster bounces \
    chain-mask claims
for folder in "$@"; do
    echo "errors: $folder" >&2
    "${folder//-/_}"
done
