#!/usr/bin/env bash
# Builds the browser version into web/dist: index.html, ocularium.js, ocularium_bg.wasm and a brotli
# twin of each, for any server of static files, from any path. Does nothing when they are up to date.
#
#   web/build.sh              build
#   web/build.sh --toolchain  only say which Rust toolchain builds it (exit 1: there is none)
#
# `./dev web-build` installs what this needs, then calls it.
set -eEuo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

most_bytes=6000000 # of the whole page as brotli
web_target=${CARGO_TARGET_DIR:-$PWD/target}-web
wasm_target=wasm32-unknown-unknown

fail() {
    printf 'web/build.sh: %s\n' "$*" >&2
    exit 1
}

# Whatever fails without a sentence of its own gets one, told once, by the outermost shell.
on_error() {
    ((BASH_SUBSHELL)) || printf 'web/build.sh: stopped (exit %d) at line %d: %s\n' "$1" "$2" "$3" >&2
}
trap 'on_error $? $LINENO "$BASH_COMMAND"' ERR

has() { command -v "$1" >/dev/null 2>&1; }

# ---- Which toolchain ------------------------------------------------------------------------

# The standard library is best had ready-made, from rustup. Debian's rustc-web has none for
# WebAssembly but can build it from rust-web-src, once for each $web_target; that is an unstable
# option of cargo, hence the bootstrap switch.
debian_cargo=(env RUSTC_BOOTSTRAP=1 RUSTC=/usr/bin/rustc RUSTDOC=/usr/bin/rustdoc /usr/bin/cargo)

has_debian_rust() {
    [[ -x /usr/bin/cargo && -x /usr/bin/rustc && -x /usr/bin/rust-lld ]] &&
        [[ -e $(/usr/bin/rustc --print sysroot)/lib/rustlib/src/rust/library/std/Cargo.toml ]]
}

has_wasm_std() {
    has cargo && has rustc && [[ -d $(rustc --print sysroot)/lib/rustlib/$wasm_target/lib ]]
}

if has_wasm_std; then
    rustc=rustc
    cargo_build=(cargo build)
elif has_debian_rust; then
    rustc=/usr/bin/rustc
    cargo_build=("${debian_cargo[@]}" build "-Zbuild-std=std,panic_abort")
else
    fail "no Rust standard library for $wasm_target: run ./dev setup, or rustup target add $wasm_target."
fi
if [[ ${1:-} == --toolchain ]]; then
    "$rustc" --version
    exit
fi

has brotli || fail "brotli is missing: run ./dev setup."

# One build at a time in one folder: the second waits, and then finds the page finished.
mkdir -p "$web_target"
if has flock; then
    exec 9>"$web_target/lock"
    flock 9
fi

# ---- Is there anything to do ----------------------------------------------------------------

# The inputs: everything that cargo or this script reads, by content.
fingerprint() {
    local compiler
    compiler=$("$rustc" -vV) || return
    {
        echo "$compiler"
        find Cargo.toml Cargo.lock src shaders assets web/build.sh web/index.html \
            -type f -print0 | LC_ALL=C sort -z | xargs -0 sha256sum
    } | sha256sum | cut -c 1-16
}

report() {
    local file raw compressed total=0
    printf '%-20s %12s %12s\n' 'web/dist, bytes' raw brotli
    for file in index.html ocularium.js ocularium_bg.wasm; do
        raw=$(wc -c <"web/dist/$file")
        compressed=$(wc -c <"web/dist/$file.br")
        total=$((total + compressed))
        printf '%-20s %12d %12d\n' "$file" "$raw" "$compressed"
    done
    ((total <= most_bytes)) || fail "the download is $total bytes as brotli, more than $most_bytes."
}

# Finished files are kept beside the build, so that a fresh checkout with the same inputs has them.
stamp=$(fingerprint)
finished=$web_target/page-$stamp
if [[ -d $finished ]]; then
    rm -rf web/dist && cp -r "$finished" web/dist
    echo "The browser version is up to date."
    report
    exit
fi

# ---- Build ----------------------------------------------------------------------------------

# wasm-bindgen's two halves must agree to the letter. It is built beside the program, which leaves a processor
# idle at times, and optimised a little: it runs for seconds.
bindgen_version=$(sed -n '/^name = "wasm-bindgen"$/{n;s/version = "\(.*\)"/\1/p}' Cargo.lock)
bindgen=$web_target/tools/wasm-bindgen-$bindgen_version/bin/wasm-bindgen
build_bindgen() {
    local install=(env CARGO_PROFILE_RELEASE_OPT_LEVEL=1 CARGO_PROFILE_RELEASE_LTO=off CARGO_PROFILE_RELEASE_CODEGEN_UNITS=16
        CARGO_PROFILE_RELEASE_DEBUG=false cargo install wasm-bindgen-cli --version "$bindgen_version" --quiet --no-default-features
        --bin wasm-bindgen --root "${bindgen%/bin/*}" --target-dir "$web_target/tools/build")
    # Its own lockfile may name a release that was withdrawn since, or that a mirror does not have yet.
    "${install[@]}" --locked 2>/dev/null || "${install[@]}"
    rm -rf "$web_target/tools/build"
}
tool= # the process that builds it
if has wasm-bindgen && [[ $(wasm-bindgen --version) == "wasm-bindgen $bindgen_version" ]]; then
    bindgen=wasm-bindgen
elif [[ ! -x $bindgen ]]; then
    echo "building wasm-bindgen $bindgen_version, once"
    set -m # in a process group of its own, so that all of it ends with this script
    build_bindgen &
    tool=$!
    set +m
fi
trap '[[ -z $tool ]] || kill -- "-$tool" 2>/dev/null || true' EXIT

"${cargo_build[@]}" --profile web --locked --bin ocularium --target "$wasm_target" --target-dir "$web_target"
if [[ -n $tool ]]; then
    wait "$tool" || fail "wasm-bindgen could not be built; cargo says why above."
    tool=
fi

work=$web_target/page-work
rm -rf "$work" && mkdir -p "$work"
# Its name section, two thirds of the file, goes; wasm-opt is left out: it takes minutes, and what it
# makes smaller raw is not smaller as brotli.
"$bindgen" --target web --no-typescript --remove-name-section --remove-producers-section \
    --out-name ocularium --out-dir "$work" "$web_target/$wasm_target/web/ocularium.wasm"

# The page needs the size for its progress bar (a compressing server hides it), and the stamp so that
# a browser never pairs an old file with a new one.
sed -e "s/@WASM_BYTES@/$(wc -c <"$work/ocularium_bg.wasm")/" -e "s/@STAMP@/$stamp/" \
    web/index.html >"$work/index.html"
for file in index.html ocularium.js ocularium_bg.wasm; do
    brotli --quality=11 --lgwin=24 --keep --force "$work/$file"
done

rm -rf "$web_target"/page-[0-9a-f]* web/dist
cp -r "$work" web/dist
mv "$work" "$finished"
report
