#!/usr/bin/env bash
# All checks of the project: format, lints, tests (firmware in QEMU included), the Python package,
# instruction budgets, bare-metal builds, documentation. Runs from any folder.
#
# Installs missing tools: Rust, the Cortex-M target, QEMU, Python, GNU parallel, Java. With RUSTUP_AUTO_INSTALL=0, rustup
# downloads nothing.
set -euo pipefail

TARGET=thumbv7em-none-eabihf
MINIMUM_RUST=89 # 1.89: rust-version in Cargo.toml

cd "$(dirname "$0")/.."
export CARGO_INCREMENTAL=0 # each package is compiled once: less disk
skipped=""
log=$(mktemp)
trap 'rm -f "$log"' EXIT

heading() { printf '\n=== %s\n' "$1"; }
give_up() { printf 'check.sh: %s\n' "$1" >&2; exit 1; }
have() { command -v "$1" >/dev/null 2>&1; }

can_apt() { [ "$(id -u)" = 0 ] && have apt-get; }
apt_install() {
    echo "installing: $*"
    DEBIAN_FRONTEND=noninteractive apt-get update -qq </dev/null
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" </dev/null
}

# Whether the rustc $1 exists and has the minimum version.
recent() {
    have "$1" || return 1
    minor=$("$1" --version 2>/dev/null | sed -n 's/^rustc 1\.\([0-9]*\)\..*/\1/p')
    [ "${minor:-0}" -ge "$MINIMUM_RUST" ]
}

heading "Set-up: Rust"
if ! have cargo && [ -x "${CARGO_HOME:-$HOME/.cargo}/bin/cargo" ]; then
    PATH="${CARGO_HOME:-$HOME/.cargo}/bin:$PATH"
fi
if ! { have cargo && recent rustc; }; then
    can_apt || give_up "Rust 1.$MINIMUM_RUST or newer is required: see rustup.rs"
    apt_install rustc-web cargo-web ca-certificates
    hash -r
    recent rustc || give_up "Rust 1.$MINIMUM_RUST or newer is required: see rustup.rs"
fi
if ! have cc; then
    can_apt || give_up "a C linker is required: install gcc"
    apt_install gcc libc6-dev
fi
rustc --version

heading "Set-up: $TARGET"
target_installed() { [ -d "$(rustc --print sysroot)/lib/rustlib/$TARGET/lib" ]; }
# Debian's compiler builds the core library of the target from source
# (fsw-target/tools/src/toolchain.rs).
debian_ready() {
    recent /usr/bin/rustc && [ -x /usr/bin/cargo ] && [ -x /usr/bin/ld.lld ] &&
        [ -d /usr/lib/rustlib/src/rust/library/core ]
}
if ! target_installed && [ "${RUSTUP_AUTO_INSTALL:-1}" != 0 ] && have rustup; then
    rustup target add "$TARGET" || echo "rustup could not add the target"
fi
if target_installed; then
    echo "installed"
else
    if ! debian_ready && can_apt; then
        apt_install rustc-web cargo-web rust-web-src lld
    fi
    debian_ready || give_up "no compiler for $TARGET: run 'rustup target add $TARGET', or on \
Debian 'apt-get install rustc-web cargo-web rust-web-src lld'"
    echo "built from source by $(/usr/bin/rustc --version)"
fi

heading "Set-up: QEMU"
if ! have qemu-system-arm; then
    can_apt || give_up "no qemu-system-arm: install QEMU (Debian: apt-get install qemu-system-arm)"
    apt_install qemu-system-arm
fi
qemu-system-arm --version | sed -n 1p

heading "Set-up: C compiler for the Cortex-M"
if ! have arm-none-eabi-gcc; then
    can_apt || give_up "no arm-none-eabi-gcc: install it (Debian: apt-get install gcc-arm-none-eabi)"
    apt_install gcc-arm-none-eabi
fi
if ! have g++; then
    can_apt || give_up "no g++: install it (Debian: apt-get install g++)"
    apt_install g++
fi
arm-none-eabi-gcc --version | sed -n 1p

heading "Set-up: Chromium"
if ! have chromium && can_apt; then
    apt_install chromium fonts-dejavu-core
fi
if have chromium; then
    chromium --version
else
    skipped="$skipped reports-in-a-browser"
    echo "skipped: no chromium; the reports are not opened (Debian: apt-get install chromium)"
fi

heading "Set-up: Python, GNU parallel"
has_python() {
    have python3 &&
        python3 -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 10))' 2>/dev/null
}
if ! has_python && can_apt; then
    apt_install python3 python3-venv
fi
if has_python; then
    python3 --version
else
    skipped="$skipped python-package"
    echo "skipped: no Python 3.10 with venv; the wheel is not built (Debian: apt-get install python3-venv)"
fi
if ! have parallel && can_apt; then
    apt_install parallel
fi
# A scheduler that is missing is skipped by its test with a reason. Slurm is used where it is installed.
have parallel || skipped="$skipped parallel"
have slurmctld || skipped="$skipped slurm"

heading "Set-up: Java"
if ! have java && can_apt; then
    apt_install default-jre-headless || true
fi
if have java; then
    java -version 2>&1 | sed -n 1p
else
    skipped="$skipped yamcs"
    echo "skipped: no Java; Yamcs is not run (Debian: apt-get install default-jre-headless)"
fi

heading "Format"
if cargo fmt --version >/dev/null 2>&1; then
    cargo fmt --all --check
else
    skipped="$skipped format"
    echo "skipped: rustfmt is not installed"
fi

heading "Lints"
if cargo clippy --version >/dev/null 2>&1; then
    cargo clippy --workspace --all-targets -- -D warnings
    if target_installed; then
        cargo clippy --target "$TARGET" --package fsw-target --bins -- -D warnings
    fi
else
    skipped="$skipped lints"
    echo "skipped: clippy is not installed"
fi

heading "Tests, firmware in QEMU included"
cargo test --workspace --no-fail-fast -- --include-ignored 2>&1 | tee "$log"

if has_python; then
    heading "Python package: wheel, tests, notebook"
    HOST_SIM=${CARGO_TARGET_DIR:-target}/debug/host-sim tests/python.sh # built for the tests above

    heading "Ground systems: XTCE, flight image through Yamcs"
    tests/ground.sh
fi

heading "Fuzzing, a minute"
cargo run --package tests --bin fuzz -- --seconds 8

heading "Flipped bits"
cargo run --package tests --bin upsets -- --runs 2000

heading "Instruction budgets, counted in QEMU"
cargo bench-target

heading "Bare metal: fsw-core for $TARGET"
cargo target build --package fsw-core --profile firmware
cargo target build --package fsw-core --profile firmware --features defmt

heading "Advisories of the dependencies"
if cargo deny --version >/dev/null 2>&1; then
    cargo deny check
else
    skipped="$skipped advisories"
    echo "skipped: cargo-deny is not installed; licences, duplicates and sources are tested above"
fi
heading "Other processors: fsw-core and its C interface"
# Debian's compiler builds their core library from source; an ambient toolchain is used where it has the target.
with_library=() from_source=()
for other in thumbv6m-none-eabi thumbv7m-none-eabi thumbv7em-none-eabi thumbv8m.main-none-eabihf \
    riscv32imac-unknown-none-elf; do
    if [ -d "$(rustc --print sysroot)/lib/rustlib/$other/lib" ]; then
        with_library+=(--target "$other")
    elif debian_ready; then
        from_source+=(--target "$other")
    else
        skipped="$skipped $other"
        echo "skipped: no core library for $other (rustup target add $other)"
    fi
done
if [ ${#with_library[@]} != 0 ]; then
    cargo check --package fsw-core --package fsw-core-c "${with_library[@]}"
fi
if [ ${#from_source[@]} != 0 ]; then
    env -u RUSTUP_TOOLCHAIN -u CARGO -u RUSTDOC RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 \
        /usr/bin/cargo check -Zbuild-std=core --package fsw-core --package fsw-core-c "${from_source[@]}"
fi

heading "Documentation"
RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps

heading "Test count"
awk '
    /^test result:/ { passed += $4; failed += $6; ignored += $8 }
    END { printf "%d passed, %d failed, %d ignored\n", passed, failed, ignored }
' "$log"

heading "All checks passed${skipped:+ (skipped:$skipped)}"
