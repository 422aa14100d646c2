#!/usr/bin/env bash
# Install what a build, the tests and the pictures need from the system; nothing when all is there.
#
#   cmake/setup-system.sh             install what is missing (apt, as root or through sudo)
#   cmake/setup-system.sh --check     only say what is missing; exit status 1 if anything is
#
# Where neither root nor sudo is at hand, it prints the one apt line to have run. Programs that are
# there already (from modules, Homebrew, your own builds ...) count: only what is missing is asked for.
set -euo pipefail
cd "$(dirname "$0")/.."

say() { printf 'system: %s\n' "$*"; }

# ---- what is needed, and how to see that it is there --------------------------------------------

has() { command -v "$1" >/dev/null 2>&1; }

newer_cmake() {
  has cmake || return 1
  local have
  have=$(cmake --version | sed -n '1s/[^0-9]*\([0-9.]*\).*/\1/p')
  [ "$(printf '3.20\n%s\n' "$have" | sort -V | head -n 1)" = 3.20 ]
}

cxx17() {
  local cxx=${CXX:-c++}
  has "$cxx" && printf '#include <filesystem>\nint main() { return 0; }\n' |
    "$cxx" -std=c++17 -fsyntax-only -x c++ - >/dev/null 2>&1
}

certificates() { [ -n "${SSL_CERT_FILE:-}" ] || [ -s /etc/ssl/certs/ca-certificates.crt ] ||
                 [ -s /etc/pki/tls/certs/ca-bundle.crt ] || [ -s /etc/ssl/cert.pem ]; }

as_root=()
can_install() { # with apt, as root or through sudo
  has apt-get || return 1
  [ "$(id -u)" -ne 0 ] || return 0
  has sudo && { sudo -n true 2>/dev/null || { [ -t 0 ] && sudo -v; }; } && as_root=(sudo)
}

missing=()   # what, in words
packages=()  # apt's names for it
need() { # WORDS PACKAGES PROBE...
  local words=$1 names=$2
  shift 2
  "$@" >/dev/null && return 0
  missing+=("$words")
  read -r -a names <<<"$names"
  packages+=("${names[@]}")
}

installed=
in_dpkg() { # PACKAGE: installed, under its own name or provided by another (libgl1 and the like)
  [ -n "$installed" ] || installed=$(dpkg-query -W \
    -f '${db:Status-Status} ${Package} ${Provides}\n' | sed -n 's/^installed //p' |
    sed 's/([^)]*)//g' | tr -s ', ' '\n\n')
  grep -qxF "$1" <<<"$installed"
}

look() {
  missing=() packages=() installed=
  need 'a C++17 compiler'    'g++'                          cxx17
  need 'CMake 3.20 or later' 'cmake'                        newer_cmake
  need 'make'                'make'                         has make
  need 'an MPI compiler'     'libopenmpi-dev openmpi-bin'   has mpicxx
  need 'mpirun'              'openmpi-bin'                  has mpirun
  need 'xz'                  'xz-utils'                     has xz
  need 'TLS certificates'    'ca-certificates'              certificates
  need 'Python 3.10 to 3.13 that can make virtual environments' \
       'python3 python3-venv'                               cmake/setup-python.sh --find
  if has dpkg-query; then  # libraries that gmsh and the pictures load
    local name
    while read -r name; do
      case "$name" in ''|'#'*) continue ;; esac
      need "the library package $name" "$name"              in_dpkg "$name"
    done <python/system-packages.txt
  fi
}

# ---- look, install, look again -------------------------------------------------------------------

look
# Ninja builds faster, but make will do where nothing can be installed
if ! has ninja && { [ ${#missing[@]} -gt 0 ] || can_install; }; then
  need 'Ninja'               'ninja-build'                  has ninja
fi
# valgrind counts instructions in a test: it comes along with the rest, no build waits for it
if [ ${#missing[@]} -gt 0 ] && ! has valgrind; then
  need 'valgrind'            'valgrind'                     has valgrind
fi
if [ ${#missing[@]} -eq 0 ]; then
  say 'all there'
  exit 0
fi
printf 'system: missing: %s\n' "${missing[@]}"
[ "${1:-}" != --check ] || exit 1

if ! has apt-get; then
  say 'no apt here: install the above by your own means, then repeat' >&2
  exit 1
fi
readarray -t packages < <(printf '%s\n' "${packages[@]}" | sort -u)
if ! can_install; then
  say 'neither root nor sudo: have this one line run, then repeat' >&2
  printf '\n    apt-get update && apt-get install -y --no-install-recommends %s\n\n' \
    "${packages[*]}" >&2
  exit 1
fi

install() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq install -y \
    --no-install-recommends -o Dpkg::Use-Pty=0 "${packages[@]}"
}
log=$(mktemp)
trap 'rm -f "$log"' EXIT
say "installing ${packages[*]}"
if ! install >"$log" 2>&1; then  # the lists may be missing or old
  "${as_root[@]}" apt-get -qq update >"$log" 2>&1 && install >>"$log" 2>&1 || {
    tail -n 20 "$log" >&2
    say 'apt could not install them (its last lines are above)' >&2
    exit 1
  }
fi

look
if [ ${#missing[@]} -ne 0 ]; then
  printf 'system: still missing: %s\n' "${missing[@]}" >&2
  exit 1
fi
say 'all there'
