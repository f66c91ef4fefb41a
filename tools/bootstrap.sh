#!/bin/sh
# Make .venv ready: the locked packages of requirements.txt, then this project itself, editable.
# Usage: tools/bootstrap.sh [PYTHON]     (PYTHON: 3.11 or later, python3 by default)
# Needs nothing but a Python with venv. `make` calls it once; the stamp .venv/.ready says that it is done.
set -eu
cd "$(dirname "$0")/.."
python=${1:-python3}

fail() {
    printf 'set-up: %s\n' "$*" >&2
    exit 1
}

command -v "$python" >/dev/null || fail "no '$python' here. Debian: apt-get install python3 python3-venv"
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' ||
    fail "$("$python" --version) is too old, 3.11 or later is needed: make setup PYTHON=/path/to/python3.11"
"$python" -c 'import ensurepip, venv' 2>/dev/null || fail "Python has no venv. Debian: apt-get install python3-venv"

# CadQuery's kernel is linked against the system's OpenGL although nothing is drawn here. Asked before the
# download, not after it: a minimal Debian has no libGL.
has_opengl() {
    "$python" -c 'import ctypes; ctypes.CDLL("libGL.so.1")' 2>/dev/null
}
if [ "$(uname -s)" = Linux ] && ! has_opengl; then
    install='apt-get update && apt-get install -y --no-install-recommends libgl1'
    if [ "$(id -u)" != 0 ]; then
        fail "the system library libGL.so.1 is missing. Install it, then run make again:
    sudo sh -c '$install'"
    fi
    command -v apt-get >/dev/null ||
        fail "the system library libGL.so.1 is missing and there is no apt-get: install your system's OpenGL library"
    echo 'set-up: installing libgl1, which CadQuery needs'
    { apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends libgl1; } \
        >.apt.log 2>&1 || { cat .apt.log >&2; fail "apt-get failed. To try by hand: $install"; }
    rm -f .apt.log
    has_opengl || fail 'libgl1 is installed, and libGL.so.1 still does not load'
fi

# Pictures of the parts are drawn without a screen, by EGL; without it a design has none, and says so.
if [ "$(uname -s)" = Linux ] && ! "$python" -c 'import ctypes; ctypes.CDLL("libEGL.so.1")' 2>/dev/null; then
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
        echo 'set-up: installing libegl1, which draws the pictures of the parts'
        { apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends libegl1; } \
            >.apt.log 2>&1 || echo 'set-up: libegl1 could not be installed; designs will have no pictures' >&2
        rm -f .apt.log
    else
        echo 'set-up: libEGL.so.1 is missing, so designs will have no pictures. Debian: apt-get install libegl1' >&2
    fi
fi

# An environment of another Python version cannot be mended, only made again.
version='import sys; print(sys.version_info[:2])'
if [ "$(.venv/bin/python -c "$version" 2>/dev/null || true)" = "$("$python" -c "$version")" ]; then
    "$python" -m venv .venv
else
    "$python" -m venv --clear .venv
fi

echo "set-up: installing $(grep -c '==' requirements.txt) locked packages into .venv (once; some minutes)"
.venv/bin/python -m pip install --quiet --disable-pip-version-check \
    --require-hashes --only-binary :all: --requirement requirements.txt
# The build backend is among the locked packages: no isolated build, so no unlocked download.
.venv/bin/python -m pip install --quiet --disable-pip-version-check \
    --no-deps --no-build-isolation --editable .
.venv/bin/python -m pip check --disable-pip-version-check >/dev/null || .venv/bin/python -m pip check
.venv/bin/python -c 'import cadquery' 2>/dev/null || .venv/bin/python -c 'import cadquery'
touch .venv/.ready
echo 'set-up: done'
