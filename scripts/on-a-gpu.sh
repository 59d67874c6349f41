#!/usr/bin/env bash
# Measures on a GPU, in at most eight minutes, what was not measured on a GPU yet. The most wanted runs come first. They are
# the time of a history by stage, at rest and along a path; every method by stage; methods of two builds in turns; the compiled
# programs; a film; and ray queries. Each run has a folder in OUT. An interrupted script goes on where it
# was, and names at its end the runs for which no time was left.
#
#   scripts/on-a-gpu.sh [OUT]
#
# The environment may set SSCT (the program, built in release by default), and BEFORE (an older build of it, for the third run).
# It may also set SIZES (960x540,1920x1080), SAMPLES (15), VIEWS (4, the number of views) and LIMIT (480, in seconds). SSCT_DEVICE
# chooses a device.
set -euo pipefail
[ "${1:-}" != --help ] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" && exit; }

root=$(cd "$(dirname "$0")/.." && pwd)
ssct=${SSCT:-${CARGO_TARGET_DIR:-$root/target}/release/ssct}
before=${BEFORE:-}
out=${1:-on-a-gpu}
sizes=${SIZES:-960x540,1920x1080}
largest=${sizes##*,}
samples=${SAMPLES:-15}
limit=${LIMIT:-480}
[ -x "$ssct" ] || { echo "on-a-gpu: there is no program $ssct; make build PROFILE=release makes it" >&2 && exit 1; }
[ -z "$before" ] || [ -x "$before" ] || { echo "on-a-gpu: BEFORE names $before, which is no program" >&2 && exit 1; }
places=('rooms corridor' 'atrium hall' 'museum exit-sign' 'street car')
places=("${places[@]:0:${VIEWS:-4}}")
mkdir -p "$out"
left_out=()

# Runs a program for as long as the limit allows. A run that is stopped at the limit goes on when the script is called again.
run() { # name, program, arguments...
    local name=$1 program=$2 left=$((limit - SECONDS)) status=0
    shift 2
    if [ "$left" -le 1 ]; then
        left_out+=("$name")
        return
    fi
    local from=$SECONDS
    timeout --signal INT "$left" "$program" "$@" >"$out/$name.txt" 2>"$out/$name.log" || status=$?
    case $status in
        0) echo "on-a-gpu: $name, $((SECONDS - from)) s" >&2 ;;
        124 | 130) left_out+=("$name") ;;
        *) echo "on-a-gpu: $name: $(tail -n 1 "$out/$name.log")" >&2 ;;
    esac
}

# Splits "SCENE VIEW" into scene and view, and sets place to the options of ssct that choose them.
choose() { read -r scene view <<<"$1" && place=(--scene "$scene" --view "$view"); }

"$ssct" devices >"$out/devices.txt"

# 1. The time of a history, in the fragment stage and in the compute stage.
for view in "${places[@]}"; do
    choose "$view"
    run "history-$scene" "$ssct" time "${place[@]}" --size "$sizes" --roughness 0.05,0.1,0.3,0.6 --samples "$samples" \
        --variant unified --variant 'unified --history on --history-stage fragment' \
        --variant 'unified --history on --history-stage compute' -o "$out/history-$scene" --resume
    # The run above has a camera at rest. Along a path, the history also has to find where a surface was.
    for history in off on; do
        run "moving-$scene-$history" "$ssct" path --scene "$scene" --size "$largest" --roughness 0.1 --frames 60 \
            --method unified --history "$history" -o "$out/moving-$scene-$history" --resume
    done
done

# 2. Published methods in both stages, and the methods that trace rays beyond the screen.
for view in "${places[@]}"; do
    choose "$view"
    variants=()
    for method in ssct hzct sslr linear poster ssr dda stochastic; do
        variants+=(--variant "$method --stage fragment" --variant "$method --stage compute")
    done
    for stage in fragment compute; do
        variants+=(--variant "unified --beyond none --stage $stage")
    done
    run "methods-$scene" "$ssct" time "${place[@]}" --size "$largest" --roughness 0,0.1 --samples "$samples" "${variants[@]}" \
        --variant unified --variant traced --variant 'unified --captures 4' -o "$out/methods-$scene" --resume
done

# 3. Two builds in turns, for three rounds, so that a drift of the device's clock shows as a difference of the rounds.
for round in ${before:+1 2 3}; do
    for which in before after; do
        program=$ssct
        [ "$which" = after ] || program=$before
        for view in "${places[@]}"; do
            choose "$view"
            run "$which-$scene-$round" "$program" time "${place[@]}" --size "$largest" --roughness 0,0.1,0.3 --samples "$samples" \
                --variant 'unified --beyond none' --variant unified --variant traced --variant 'unified --captures 4' \
                --variant 'unified --history on' -o "$out/$which-$scene-$round" --resume
        done
    done
done

# 4. Statistics of the compiled programs, by the device's own compiler, and by AMD's if scripts/drivers.sh has fetched it.
run shaders "$ssct" shaders -o "$out/shaders" --resume
if radv=$("$root/scripts/drivers.sh" --radv 2>/dev/null) && [ -n "$radv" ]; then
    read -r -a variables <<<"${radv#export }"
    run shaders-radv env -u SSCT_DEVICE "${variables[@]}" RADV_FORCE_FAMILY=navi31 "$ssct" shaders -o "$out/shaders-radv" --resume
fi

# 5. A film of methods beside the reference.
run film "$ssct" video --scene rooms --view corridor --way walk --roughness 0.1 --size 320x180 --frames 30 --rays 32 \
    --variant ssct --variant unified --variant 'unified --history on' -o "$out/film" --resume

# 6. Ray queries beside the tree, if the device supports ray queries.
for view in "${places[@]}"; do
    choose "$view"
    run "queries-$scene" "$ssct" time "${place[@]}" --size "$largest" --roughness 0,0.1 --samples "$samples" \
        --variant 'traced --tracer tree' --variant 'traced --tracer query' -o "$out/queries-$scene" --resume
done

if [ ${#left_out[@]} -gt 0 ]; then
    echo "on-a-gpu: $limit s did not suffice for: ${left_out[*]}; the same command goes on" >&2
fi
echo "$out"
