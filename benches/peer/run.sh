#!/usr/bin/env bash
# Whole renders beside rs_pbrt 0.9.12, the Rust port of pbrt-v3: the same scene files, 2 threads,
# interleaved runs, processor time of the whole process. Needs `cargo install rs_pbrt --version 0.9.12`.
#
#   benches/peer/run.sh [RUNS]        (5 unless told; RS_PBRT=path where it is not on the PATH)
set -euo pipefail
cd "$(dirname "$0")/../.."
runs=${1:-5}
rs_pbrt=$(command -v "${RS_PBRT:-rs_pbrt}") || { echo "no rs_pbrt: cargo install rs_pbrt --version 0.9.12" >&2; exit 2; }
cargo build --release --locked --quiet
fstop=${CARGO_TARGET_DIR:-$PWD/target}/release/fstop

# One folder with everything, where both may write.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp -r scenes/creature/. scenes/course/geometry/. scenes/course/textures lenses/dgauss.50mm.dat benches/peer/dgauss.pbrt "$work"
cd "$work"
sed -i 's/Shape "cone" "float radius" \[.05\] "float height" \[.15\]/Shape "cylinder" "float radius" [.05] "float zmin" [0] "float zmax" [.15]/' stage.pbrt

# Seconds of user and system time of a command.
cost() {
  local TIMEFORMAT='%U %S'
  { time "$@" >/dev/null 2>&1; } 2>&1 | awk '{ print $1 + $2 }'
}
median() { sort -n | awk '{ v[NR] = $1 } END { print NR % 2 ? v[(NR + 1) / 2] : (v[NR / 2] + v[NR / 2 + 1]) / 2 }'; }

printf '%-12s %10s %10s %8s   (median of %d, processor seconds)\n' scene fstop rs_pbrt ratio "$runs"
for scene in creature dgauss; do
  : >ours.txt; : >theirs.txt
  for _ in $(seq "$runs"); do
    cost "$fstop" render "$scene.pbrt" -o ours.exr --threads 2 --quiet >>ours.txt
    cost "$rs_pbrt" -t 2 -p "$scene.pbrt" >>theirs.txt
  done
  ours=$(median <ours.txt) theirs=$(median <theirs.txt)
  awk -v s="$scene" -v a="$ours" -v b="$theirs" 'BEGIN { printf "%-12s %10.2f %10.2f %8.2f\n", s, a, b, b / a }'
done
