#!/bin/sh
# Write requirements.txt: every package of pyproject.toml and its dev extra, at one version each, with hashes.
# Usage: tools/lock.sh [--upgrade]       (keeps the present versions where they still fit, unless --upgrade)
# The oldest supported Python makes the lock: newer ones need no package more (`make setup` would say so).
set -eu
cd "$(dirname "$0")/.."
python=${PYTHON:-python3}
case "$("$python" --version)" in
    'Python 3.11.'*) ;;
    *) echo "lock: Python 3.11 makes the lock, this is $("$python" --version): make lock PYTHON=python3.11" >&2; exit 1 ;;
esac

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
"$python" -m venv "$scratch/venv"
"$scratch/venv/bin/python" -m pip install --quiet --disable-pip-version-check 'pip-tools>=7.5'

# Wheels lying on this machine have hashes that no one else could match.
unset PIP_FIND_LINKS PIP_EXTRA_INDEX_URL
export PIP_CONFIG_FILE=/dev/null
tail -n +4 requirements.txt >"$scratch/requirements.txt" 2>/dev/null || true
"$scratch/venv/bin/pip-compile" --quiet --generate-hashes --strip-extras --allow-unsafe --extra dev \
    --no-header --no-emit-index-url --no-emit-find-links --no-emit-trusted-host \
    --output-file "$scratch/requirements.txt" "$@" pyproject.toml

{
    echo '# Locked versions for running and testing, made by `make lock` (Python 3.11). Do not edit.'
    echo '# Which packages and why: pyproject.toml. Installed by tools/bootstrap.sh with --require-hashes.'
    echo
    cat "$scratch/requirements.txt"
} >"$scratch/whole.txt"
cp "$scratch/whole.txt" requirements.txt
echo "lock: $(grep -c '==' requirements.txt) packages"
