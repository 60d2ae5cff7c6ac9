#!/bin/sh
# Our traversal beside Embree 3.13: builds benches/embree/rays.c and runs the traversal bench, in which all contenders
# take turns with the same mesh and rays. Arguments go to the bench (`--rounds N`).
# Needs Debian's libembree-dev (nothing of Embree enters fstop) and a C compiler.
set -eu
cd "$(dirname "$0")/../.."
if ! [ -e /usr/include/embree3/rtcore.h ]; then
    echo "Embree's headers are missing: apt-get install libembree-dev" >&2
    exit 2
fi
mkdir -p target
${CC:-cc} -O3 -march=native -Wall -Wextra benches/embree/rays.c -o target/embree_rays -lembree3 -lm
exec ${CARGO:-cargo} bench --bench traversal -- --embree target/embree_rays "$@"
