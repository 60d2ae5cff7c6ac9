#!/bin/bash
# One picture, made in every way that must not change a bit of it: the table of docs/farm.md. Run by hand; it takes some
# minutes:
#
#   cargo build --release
#   bash tests/farm/hashes.sh
#
# FSTOP names another program than target/release/fstop, SPP other samples a pixel than 384. Where Slurm is installed, and for
# root, tests/farm/slurm.sh adds its row.
set -euo pipefail
cd "$(dirname "$0")/../.."
fstop=$(realpath "${FSTOP:-target/release/fstop}")
scene=scenes/course/dgauss.pbrt
export SPP="${SPP:-384}"
goal=(--spp "$SPP" --quiet)
work=$(mktemp -d "${TMPDIR:-/tmp}/fstop-hashes.XXXXXX")
trap 'rm -rf "$work"' EXIT

row() { # WHAT FILE
    echo "| $1 | \`$(sha256sum "$2" | cut -c1-16)…\` |"
}

shards() { # NUMBER
    local of=$1 shard
    for shard in $(seq "$of" | shuf); do
        "$fstop" render "$scene" -o "$work/s.exr" "${goal[@]}" --shard "$shard/$of"
    done
    "$fstop" merge "$work"/s.shard-*-of-"$of".fsc -o "$work/s.exr" --quiet
    row "$of shards in any order" "$work/s.exr"
}

# Sends a signal again and again to renders that have kept some work since they started.
disturbed() { # SIGNAL TIMES
    local done=0 pid size
    rm -f "$work/d.exr" "$work/d.fsc"
    while ((done < $2)); do
        size=$(stat -c %s "$work/d.fsc" 2>/dev/null || echo 0)
        "$fstop" render "$scene" -o "$work/d.exr" "${goal[@]}" --checkpoint "$work/d.fsc" --checkpoint-every 0.1s &
        pid=$!
        while kill -0 "$pid" 2>/dev/null && (($(stat -c %s "$work/d.fsc" 2>/dev/null || echo 0) < size + 20000)); do
            sleep 0.01
        done
        kill "-$1" "$pid" 2>/dev/null || break
        wait "$pid" 2>/dev/null || true
        done=$((done + 1))
    done
    "$fstop" render "$scene" -o "$work/d.exr" "${goal[@]}" --checkpoint "$work/d.fsc"
    row "$done times SIG$1, and continued" "$work/d.exr"
}

echo "| | SHA-256 of the file |"
echo "|---|---|"
"$fstop" render "$scene" -o "$work/one.exr" "${goal[@]}" --no-checkpoint
row "one process" "$work/one.exr"
"$fstop" render "$scene" -o "$work/one.exr" "${goal[@]}" --no-checkpoint --threads 1
row "one thread" "$work/one.exr"
for of in 2 7 64; do shards "$of"; done
disturbed KILL 20
disturbed TERM 5
for set in sse2 avx2 avx512; do
    FSTOP_INSTRUCTIONS=$set "$fstop" render "$scene" -o "$work/i.exr" "${goal[@]}" --no-checkpoint
    name=${set^^}
    row "at most ${name/AVX512/AVX-512}" "$work/i.exr"
done
if command -v slurmctld slurmd munged >/dev/null && [[ $(id -u) == 0 ]]; then
    hash=$(bash tests/farm/slurm.sh node_lost | sed -n 's/^node_lost: //p')
    echo "| 8 shards on Slurm, with a node lost | \`${hash:0:16}…\` |"
fi
