# Shared by ./run and ./test: installs what is missing on a Debian-like system, and says what it does.

say() { printf '\033[1m== %s\033[0m\n' "$*"; }
fail() { printf 'himmel: %s\n' "$*" >&2; exit 1; }

# Where cargo puts what it builds.
target_folder() { printf '%s' "${CARGO_TARGET_DIR:-target}"; }

# apt-get, as root or through sudo.
install_packages() {
    command -v apt-get >/dev/null || fail "$1 is missing and there is no apt-get here; install it with your system's package manager, then run this again"
    local sudo=""
    if [ "$(id -u)" != 0 ]; then
        command -v sudo >/dev/null || fail "$1 is missing; as root, run: apt-get install ${*:2}"
        sudo=sudo
    fi
    say "installing ${*:2} ($1)"
    $sudo apt-get update -qq
    $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${@:2}" >/dev/null
}

# Rust, and the C linker that it calls.
need_build_tools() {
    command -v cargo >/dev/null || fail "cargo is missing; install a Rust toolchain (rustup.rs), 1.95 or newer"
    command -v cc >/dev/null || install_packages "a C linker" gcc libc6-dev
}

# A GPU adapter that answers; Mesa's software rasteriser where there is none. $1: the himmel binary.
need_gpu() {
    # Mesa's device-selection layer asks a Wayland server that is not there, and complains.
    [ -n "${XDG_RUNTIME_DIR:-}" ] || export NODEVICE_SELECT=1
    "$1" info >/dev/null 2>&1 && return
    install_packages "no GPU adapter answers: a software one" mesa-vulkan-drivers libvulkan1
    "$1" info >/dev/null || fail "still no GPU adapter answers; see the line above"
}
