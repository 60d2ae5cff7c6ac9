#!/usr/bin/env bash
# Pictures beside rs_pbrt 0.9.12, the Rust port of pbrt-v3, of what no reference in refimages shows:
# the ratio of the means of each channel. Its pictures have 8 bits, so that even areas are off by up
# to half a level: a tenth of a percent at these brightnesses.
#
#   benches/peer/pictures.sh        (RS_PBRT=path where it is not on the PATH)
set -euo pipefail
cd "$(dirname "$0")/../.."
rs_pbrt=$(command -v "${RS_PBRT:-rs_pbrt}") || { echo "no rs_pbrt: cargo install rs_pbrt --version 0.9.12" >&2; exit 2; }
cargo build --release --locked --quiet
fstop=$(realpath "${CARGO_TARGET_DIR:-target}/release/fstop")

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp benches/peer/{hair,heterogeneous}.pbrt "$work"
cd "$work"
for scene in hair heterogeneous; do
  "$fstop" render "$scene.pbrt" -o "$scene.exr" --variance --quiet
  "$rs_pbrt" -p "$scene.pbrt" >/dev/null 2>&1
  mv pbrt.png "$scene.png"
  echo "$scene"
  # Differences that 8 bits make are no failure.
  { "$fstop" compare "$scene.exr" "$scene.png" --no-flip || true; } | grep -A3 '^mean '
done
