#!/usr/bin/env bash
# Makes a machine ready to build and test: a Rust toolchain must be there; where no Vulkan driver is
# found, Debian's software driver is installed (as root or with sudo). Does nothing where all is there.
# `./setup.sh npm` installs npm as well, for `make test-export`.
set -euo pipefail

if ! command -v cargo >/dev/null; then
    echo "setup: cargo was not found; install Rust 1.90 or newer from https://rustup.rs" >&2
    exit 1
fi

missing=()
cargo fmt --version >/dev/null 2>&1 || missing+=(rustfmt)
cargo clippy --version >/dev/null 2>&1 || missing+=(clippy)
if [ ${#missing[@]} -gt 0 ]; then
    echo "setup: \`make test\` needs ${missing[*]}; install with: rustup component add ${missing[*]}" >&2
fi

# macOS and Windows bring their own graphics driver.
[ "$(uname -s)" = Linux ] || exit 0

# ldconfig is not in every user's path.
loader() { PATH=$PATH:/sbin:/usr/sbin ldconfig -p 2>/dev/null | grep -q 'libvulkan\.so\.1'; }
driver() {
    [ -n "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ] ||
        compgen -G '/usr/share/vulkan/icd.d/*.json' >/dev/null ||
        compgen -G '/etc/vulkan/icd.d/*.json' >/dev/null ||
        compgen -G '/usr/local/share/vulkan/icd.d/*.json' >/dev/null ||
        compgen -G "${HOME:-}/.local/share/vulkan/icd.d/*.json" >/dev/null
}

packages=()
loader || packages+=(libvulkan1)
driver || packages+=(mesa-vulkan-drivers)
command -v cc >/dev/null || packages+=(gcc libc6-dev)
[ "${1:-}" != npm ] || command -v npm >/dev/null || packages+=(nodejs npm)
[ ${#packages[@]} -gt 0 ] || exit 0

as_root=()
[ "$(id -u)" = 0 ] || as_root=(sudo -n)
if command -v apt-get >/dev/null && { [ "$(id -u)" = 0 ] || sudo -n true 2>/dev/null; }; then
    echo "setup: installing ${packages[*]}" >&2
    "${as_root[@]}" apt-get -qq update
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends "${packages[@]}" >&2
else
    echo "setup: please install these (Debian's names): ${packages[*]}" >&2
    echo "       they are a C compiler for linking, the Vulkan loader and a Vulkan driver (lavapipe will do), or npm" >&2
    exit 1
fi
