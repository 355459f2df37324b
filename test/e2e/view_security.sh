#!/bin/bash
# `tulle view` against those who should not come in, or want too much: view_security.py.
set -eu
. "$(dirname "$0")/view_start.bash"
python3 "$(dirname "$0")/view_security.py" "$work"
