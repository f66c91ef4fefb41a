#!/bin/sh
# Make reports/static/three.js anew: three.js with what the leg's page uses of it, in one file.
# Usage: tools/three/build.sh [VERSION]      needs node and npm
set -eu
version=${1:-0.187.0}
here=$(cd "$(dirname "$0")" && pwd)
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
npm init -y >/dev/null
npm install --silent "three@$version" esbuild@0.28.2
cp "$here/entry.js" entry.js
npx esbuild entry.js --bundle --minify --format=iife --global-name=THREE --legal-comments=none --outfile=three.js
{
    echo "// three.js $version, tree-shaken by tools/three/build.sh. MIT License, copyright 2010-2026 three.js authors:"
    echo "// reports/static/three.LICENSE.txt"
    cat three.js
} >"$here/../../reports/static/three.js"
cp node_modules/three/LICENSE "$here/../../reports/static/three.LICENSE.txt"
