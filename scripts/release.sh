#!/usr/bin/env bash
# Makes what a release is of, in target/dist: static stripped programs for Linux (x86-64, aarch64), completions, manual pages,
# a Debian package, the registry's crate with its tests run from it alone. What cannot be made here is named at the end.
#
#   scripts/release.sh            all of it
#   scripts/release.sh binaries   or checks, deb, crate: one part
set -euo pipefail
cd "$(dirname "$0")/.."
part="${1:-all}"
dist=target/dist
version="$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)"
missing=()
mkdir -p "$dist"

wants() { [ "$part" = all ] || [ "$part" = "$1" ]; }

# The standard library of a target, by rustup where it is not there yet.
has_target() {
  rustup target list --installed 2>/dev/null | grep -qx "$1" || rustup target add "$1" >/dev/null 2>&1
}

# Nothing is compiled by a C compiler, so the linker that comes with Rust links for any processor.
export CARGO_TARGET_X86_64_UNKNOWN_LINUX_MUSL_LINKER=rust-lld
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_MUSL_LINKER=rust-lld

binary() {
  local target="$1" folder="$dist/fstop-$version-$1"
  has_target "$target" || { missing+=("$target: no standard library"); return; }
  cargo build --release --locked --bin fstop --target "$target"
  mkdir -p "$folder"
  cp "target/$target/release/fstop" README.md CHANGELOG.md LICENSE-APACHE LICENSE-MIT "$folder/"
  if file --brief "$folder/fstop" | grep -Eq 'dynamically linked|not stripped'; then
    echo "$folder/fstop is not static and stripped" >&2
    exit 1
  fi
  tar --sort=name --owner=0 --group=0 --numeric-owner -C "$dist" -czf "$folder.tar.gz" "${folder##*/}"
}

if wants binaries; then
  binary x86_64-unknown-linux-musl
  binary aarch64-unknown-linux-musl
fi
if wants checks; then
  for target in x86_64-pc-windows-msvc x86_64-pc-windows-gnu aarch64-apple-darwin; do
    if has_target "$target"; then
      cargo check --locked --target "$target"
    else
      missing+=("$target: no standard library")
    fi
  done
fi
if wants deb; then
  if cargo deb --version >/dev/null 2>&1; then
    cargo build --release --locked
    program=target/release/fstop
    "$program" man target/man
    mkdir -p target/completions
    for shell in bash zsh fish; do "$program" completions "$shell" >"target/completions/fstop.$shell"; done
    gzip -9nf target/man/*.1
    cargo deb --locked --no-build --output "$dist"
  else
    missing+=("the Debian package: no cargo-deb")
  fi
fi
if wants crate; then
  # From the crate alone, in a folder without the repository around it.
  cargo package --locked --no-verify
  crate="$(mktemp -d)"
  trap 'rm -rf "$crate"' EXIT
  tar -C "$crate" -xzf "target/package/fstop-$version.crate"
  size="$(stat -c %s "target/package/fstop-$version.crate")"
  [ "$size" -le 10000000 ] || { echo "the crate has $size bytes; the registry takes 10 MB" >&2; exit 1; }
  target="$PWD/target/from-crate"
  # The crate cannot depend on itself, as the repository does to give its tests this feature.
  (cd "$crate/fstop-$version" && cargo check --locked --benches --features internals --target-dir "$target" &&
    cargo test --release --locked --features internals --target-dir "$target" --no-fail-fast)
  cp "target/package/fstop-$version.crate" "$dist/"
  grep -q '^repository = ' Cargo.toml ||
    missing+=("Cargo.toml names no repository: relative links of the README lead nowhere on the registry's page")
fi
printf 'not made: %s\n' "${missing[@]}" | sed '/^not made: $/d'
