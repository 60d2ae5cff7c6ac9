#!/usr/bin/env bash
# Whole renders beside rs_pbrt 0.9.12, the Rust port of pbrt-v3: the same scene files, 2 threads,
# interleaved runs, processor time of the whole process. Needs its source, which
# `cargo install rs_pbrt --version 0.9.12` brings.
#
#   benches/peer/run.sh [RUNS [SCENE...]]     (3 runs of all scenes unless told)
#   RS_PBRT=path         a binary mended as below; built from the source otherwise
#   PBRT3=path           pbrt-v3 instead of it
#   PREPARE=folder       only puts the scenes there, for benches/peer/mitsuba/compare.py or by hand
#   REFERENCE=16         how many times the scene's samples the reference has
#
# It prints, for each scene,
#   - the processor seconds of both at the scene's samples a pixel, and their ratio;
#   - what share of the reference's mean each picture has (both should be 1: they show the same);
#   - the samples with which fstop's error is no larger than rs_pbrt's, the seconds it takes for them, and the ratio
#     of rs_pbrt's to those: time to equal error.
#
# The error is the mean squared one against a render by fstop with many times the samples and another seed. What the
# reference itself is off by adds the same to both errors. rs_pbrt writes eight-bit PNG only: both are measured
# by their PNG, decoded to linear; pixels that noise might clip are left out (examples/peer_error.rs).
#
# What the files and the peer are changed in, because rs_pbrt 0.9.12 would not draw the scene:
#   - it forgets the material of what it hits in an instance, so that instances cast shadows and cannot be seen: that
#     line (`ret.primitive = None` in Transform::transform_surface_interaction) is mended, and nothing else;
#   - it has no cones: the lens scene shows cylinders, to both programs;
#   - it reads one directive a line: the lens scene's are put on lines of their own;
#   - it has too little light in the camera's medium, behind surfaces without material and through rough glass: `media` and `glass`
#     have none of these.
set -euo pipefail
[ -z "${PREPARE:-}" ] || { mkdir -p "$PREPARE" && PREPARE=$(cd "$PREPARE" && pwd); }
cd "$(dirname "$0")/../.."
runs=${1:-3}
[ $# -gt 0 ] && shift
scenes=("$@")
[ ${#scenes[@]} -gt 0 ] || scenes=(creature cornell dgauss meadow copper glass media lamps textures room)
target=${CARGO_TARGET_DIR:-$PWD/target}

cargo build --release --locked --quiet --features studies --bin fstop --example peer_error --example make_meadow
fstop=$target/release/fstop
peer_error=$target/release/examples/peer_error

rs_pbrt=${RS_PBRT:-$target/peer/release/rs_pbrt}
peer=rs_pbrt
[ -z "${PBRT3:-}" ] || peer=pbrt-v3
if [ -z "${PREPARE:-}${PBRT3:-}" ] && [ ! -x "$rs_pbrt" ]; then
  source=$(ls -d "${CARGO_HOME:-$HOME/.cargo}"/registry/src/*/rs_pbrt-0.9.12 2>/dev/null | head -n 1)
  [ -n "$source" ] || { echo "no source of rs_pbrt: cargo install rs_pbrt --version 0.9.12" >&2; exit 2; }
  mkdir -p "$target/peer/source"
  cp -r "$source/." "$target/peer/source"
  sed -i 's|ret.primitive = None; // TODO? si.primitive;|ret.primitive = si.primitive;|' "$target/peer/source/src/core/transform.rs"
  grep -q 'ret.primitive = si.primitive;' "$target/peer/source/src/core/transform.rs"
  (cd "$target/peer/source" && CARGO_TARGET_DIR=$target/peer cargo build --release --quiet --bin rs_pbrt)
fi

# One folder with everything, where both may write.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp -r scenes/creature/. scenes/cornell/. scenes/course/geometry/. scenes/course/textures lenses/dgauss.50mm.dat benches/peer/*.pbrt "$work"
"$target/release/examples/make_meadow" "$work"
cd "$work"
sed -i -E 's/Shape "cone" "float radius" \[.05\] "float height" \[.15\]/Shape "cylinder" "float radius" [.05] "float zmin" [0] "float zmax" [.15]/
  s/ +(Translate|ObjectInstance|AttributeEnd)/\n\1/g' stage.pbrt

if [ -n "${PREPARE:-}" ]; then
  cp -r . "$PREPARE"
  exit
fi

# Seconds of user and system time of a command.
cost() {
  local TIMEFORMAT='%U %S'
  { time "$@" >/dev/null 2>&1; } 2>&1 | awk '{ print $1 + $2 }'
}
median() { sort -n | awk '{ v[NR] = $1 } END { print NR % 2 ? v[(NR + 1) / 2] : (v[NR / 2] + v[NR / 2 + 1]) / 2 }'; }
ours() { "$fstop" render "$1.pbrt" --spp "$2" -o ours.png --threads 2 --quiet; }
theirs() {
  case $peer in
    rs_pbrt) "$rs_pbrt" -t 2 -p "$1.pbrt" ;;
    *) "$PBRT3" --quiet --nthreads 2 --outfile pbrt.png "$1.pbrt" ;;
  esac
}
error_of() { "$peer_error" reference.exr "$1" | cut -d ' ' -f 1; }
share_of() { "$peer_error" reference.exr "$1" | cut -d ' ' -f 2; }
# Is fstop's error with so many samples at most that much?
good_with() { ours "$1" "$2" >/dev/null && awk -v a="$(error_of ours.png)" -v b="$3" 'BEGIN { exit !(a <= b) }'; }

printf '%-10s %5s %9s %9s %6s %17s %7s %9s %6s   (medians of %d, processor seconds)\n' \
  scene spp fstop $peer ratio 'means/reference' 'eq.spp' fstop ratio "$runs"
for scene in "${scenes[@]}"; do
  spp=$(sed -nE 's/.*"integer pixelsamples" *\[ *([0-9]+) *\].*/\1/p' "$scene.pbrt")
  "$fstop" render "$scene.pbrt" --spp $((${REFERENCE:-16} * spp)) --seed 4711 -o reference.exr --quiet
  theirs "$scene" >/dev/null 2>&1
  goal=$(error_of pbrt.png)
  their_share=$(share_of pbrt.png)
  ours "$scene" "$spp" >/dev/null
  our_share=$(share_of ours.png)
  # The fewest samples that are good: double until some are, then halve the interval.
  low=0 high=$spp
  until good_with "$scene" "$high" "$goal"; do low=$high high=$((2 * high)); done
  while [ $((high - low)) -gt 1 ]; do
    middle=$(((low + high) / 2))
    if good_with "$scene" "$middle" "$goal"; then high=$middle; else low=$middle; fi
  done
  : >same.txt; : >fewer.txt; : >theirs.txt
  for _ in $(seq "$runs"); do
    cost ours "$scene" "$spp" >>same.txt
    cost theirs "$scene" >>theirs.txt
    cost ours "$scene" "$high" >>fewer.txt
  done
  awk -v s="$scene" -v n="$spp" -v a="$(median <same.txt)" -v b="$(median <theirs.txt)" -v c="$(median <fewer.txt)" \
    -v p="$our_share" -v q="$their_share" -v m="$high" \
    'BEGIN { printf "%-10s %5d %9.2f %9.2f %6.2f %8.4f %8.4f %7d %9.2f %6.2f\n", s, n, a, b, b / a, p, q, m, c, b / c }'
done
