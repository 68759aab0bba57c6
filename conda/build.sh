#!/usr/bin/env bash
set -euo pipefail
export OPENMM_DIR="$PREFIX"
"$PYTHON" -m pip install . -vv --no-deps --no-build-isolation
