# Sourced by the scripts beside it: installs what is missing, says what, and
# never asks. Not a program of its own.

# Finds the package manager's way to install Debian packages, if there is one.
as_root() {
    if [ "$(id -u)" = 0 ]; then
        "$@"
    elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
        sudo -n "$@"
    else
        return 1
    fi
}

# install_packages NAME…: 0 where all of them are there afterwards.
install_packages() {
    command -v apt-get >/dev/null || return 1
    echo "decor: installing $* with apt-get" >&2
    as_root apt-get update -qq >/dev/null 2>&1 || true
    as_root env DEBIAN_FRONTEND=noninteractive \
        apt-get install -y -qq --no-install-recommends "$@" >/dev/null 2>&1
}

# POV-Ray, from the system's packages. 1 where it cannot be had.
ensure_povray() {
    if [ -n "${DECOR_POVRAY:-}" ] || command -v povray >/dev/null; then
        return 0
    fi
    install_packages povray povray-includes && command -v povray >/dev/null
}

# POV-Ray's own animations, which the tests render: Debian has them apart.
ensure_povray_examples() {
    [ -d /usr/share/doc/povray/examples/animations ] || install_packages povray-examples
}

# Python with virtual environments: the published metrics are compared with ours.
ensure_python() {
    python3 -c 'import venv, ensurepip' 2>/dev/null || install_packages python3 python3-venv
}

# Mitsuba, from PyPI, into a virtual environment in the user's cache. 1 where it
# cannot be had.
ensure_mitsuba() {
    if [ -n "${DECOR_MITSUBA:-}" ] || command -v mitsuba >/dev/null; then
        return 0
    fi
    local version=3.9.1
    local place="${XDG_CACHE_HOME:-$HOME/.cache}/decor/mitsuba-$version"
    if [ ! -x "$place/bin/mitsuba" ]; then
        ensure_python || return 1
        echo "decor: installing Mitsuba $version with pip" >&2
        rm -rf "$place"
        python3 -m venv "$place" &&
            "$place/bin/pip" install --quiet --disable-pip-version-check "mitsuba==$version" >&2 || return 1
    fi
    DECOR_MITSUBA="$place/bin/mitsuba"
    export DECOR_MITSUBA
}

# numpy: the renderer in Python that the tests of exec: call needs it.
ensure_numpy() {
    local there="import numpy"
    python3 -c "$there" 2>/dev/null && return 0
    # The system's package is not seen by a Python of another kind.
    install_packages python3 python3-numpy && python3 -c "$there" 2>/dev/null && return 0
    echo "decor: installing numpy with pip" >&2
    python3 -m pip install --quiet --disable-pip-version-check numpy >&2 && python3 -c "$there"
}

# A browser: the test of the report opens its page. Debian's name, and others'.
ensure_browser() {
    command -v chromium >/dev/null || command -v chromium-browser >/dev/null ||
        command -v google-chrome >/dev/null || install_packages chromium
}

# A C compiler: some crates build C.
ensure_compiler() {
    command -v cc >/dev/null || install_packages gcc libc6-dev
}

# The Rust toolchain is the one thing that is expected to be there.
ensure_cargo() {
    if ! command -v cargo >/dev/null && [ -x "$HOME/.cargo/bin/cargo" ]; then
        PATH="$HOME/.cargo/bin:$PATH"
        export PATH
    fi
    if ! command -v cargo >/dev/null; then
        echo "decor: cargo was not found: install Rust first" >&2
        return 1
    fi
}
