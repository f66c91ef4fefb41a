#!/bin/sh
# `make check` on one core and, beside it on another, what most tests need compiled: legs of one to three links and
# jumping legs; after the check longer legs. Left to the tests, both of their processes would compile the same code.
# Usage: tools/check_and_compile.sh     (`make test` calls it)
set -eu
cd "$(dirname "$0")/.."

legs() {
    for links in "$@"; do .venv/bin/synth --quiet warmup --links "$links" || return; done
}

jumps() {
    .venv/bin/python -c 'from synth.commands import progress, warmup; warmup.compile_jumps(progress.Progress(quiet=True))'
}

{ legs 3 2 1 && jumps; } &
compiling=$!
"${MAKE:-make}" --no-print-directory check || {
    kill "$compiling" 2>/dev/null
    exit 1
}
legs 4 5 6
wait "$compiling"
