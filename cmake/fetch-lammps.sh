#!/usr/bin/env bash
# Fetch a LAMMPS source tree, check it against a pinned sha256, and unpack what a build needs.
#
#   cmake/fetch-lammps.sh DIR [VERSION]      VERSION: 4Jul2026 (default), 4Feb2025, or any
#
# Sources are Debian's signed archive first (works on any Debian or Ubuntu that has its archive
# keyring), then the release tarball of LAMMPS's own download site. Nothing of the system's apt
# configuration is read for sources or changed. A tree that is already in DIR is left alone.
set -euo pipefail

usage() { sed -n '2,9s/^# \{0,1\}//p' "$0"; }
case "${1:-}" in ''|-h|--help) usage; exit 0 ;; esac

dest=$1
wanted=${2:-4Jul2026}
cache=${PERIDEM_DOWNLOADS:-$(dirname "$dest")/downloads}

# version | suites to look in | Debian source version | file name | sha256
table='4Jul2026|testing sid|20260704+dfsg-2|lammps_20260704+dfsg.orig.tar.gz|cddbc45a047416bd48a4a0b87f24a5b61b3446982b74d18cafe619c22b17eb62
4Feb2025|trixie|20250204+dfsg.1-2|lammps_20250204+dfsg.1.orig.tar.xz|3671165bd52fad36734e0a9136c5bc5ecb225e03988f8c89aa13366a8b53b1c7'

say() { printf 'lammps: %s\n' "$*"; }

check() { # FILE SHA256
  [ -f "$1" ] && [ "$(sha256sum "$1" | cut -d' ' -f1)" = "$2" ]
}

mirror() { # the Debian mirror this machine already uses, else the usual one
  local site=
  if command -v apt-get >/dev/null; then
    site=$(apt-get indextargets --format '$(SITE)' 'Created-By: Packages' 2>/dev/null |
             grep -E '/debian/?$' | head -1 || true)
  fi
  printf '%s\n' "${site:-http://deb.debian.org/debian}"
}

from_debian() { # SUITE SOURCE_VERSION FILE SHA256
  command -v apt-get >/dev/null || return 1
  local keyring=/usr/share/keyrings/debian-archive-keyring.gpg work opts
  [ -f "$keyring" ] || return 1
  work=$(mktemp -d)
  mkdir -p "$work/lists/partial" "$work/cache/archives/partial" "$work/out"
  printf 'deb-src [signed-by=%s] %s %s main\n' "$keyring" "$(mirror)" "$1" >"$work/sources.list"
  opts=(-qq -o "Dir::Etc::sourcelist=$work/sources.list" -o Dir::Etc::sourceparts=/dev/null
        -o "Dir::State::Lists=$work/lists" -o "Dir::Cache=$work/cache"
        -o APT::Sandbox::User=root -o Acquire::Languages=none -o Acquire::Retries=3
        # an index of testing may be past its date; the pinned sha256 below gives the check back
        -o Acquire::Check-Valid-Until=false -o Acquire::Check-Date=false)
  if apt-get "${opts[@]}" update >"$work/log" 2>&1 &&
     (cd "$work/out" && apt-get "${opts[@]}" source --only-source --tar-only --download-only \
        "lammps=$2") >>"$work/log" 2>&1 && check "$work/out/$3" "$4"; then
    mv "$work/out/$3" "$cache/$3"
    rm -rf "$work"
    return 0
  fi
  say "not in the archive's $1: $(tail -n 1 "$work/log")"
  rm -rf "$work"
  return 1
}

unpack() { # FILE
  local tree=$dest.partial strip=0 first
  rm -rf "$tree" && mkdir -p "$tree"
  first=$(tar -tf "$1" 2>/dev/null | head -1 || true)
  local parts=(src cmake python third_party LICENSE README doc/lammps.1)
  case "$first" in
    lammps-*) strip=1; parts=("${parts[@]/#/${first%%/*}/}") ;;
    ./*) parts=("${parts[@]/#/./}") ;;
  esac
  # some releases lack third_party or the man page: what a tree lacks, CMake names by itself
  tar -xf "$1" -C "$tree" --strip-components="$strip" "${parts[@]}" 2>/dev/null || true
  [ -f "$tree/cmake/CMakeLists.txt" ] && [ -f "$tree/src/version.h" ] || {
    say "could not unpack $1"; return 1; }
  rm -rf "$dest" && mv "$tree" "$dest"
}

if [ -f "$dest/src/version.h" ]; then
  say "$dest is there ($(sed -n 's/.*LAMMPS_VERSION "\(.*\)".*/\1/p' "$dest/src/version.h"))"
  exit 0
fi
mkdir -p "$cache"
tried=
while IFS='|' read -r version suites source file sha; do
  [ "$wanted" = any ] || [ "$wanted" = "$version" ] || continue
  tried="$tried $version"
  if ! check "$cache/$file" "$sha"; then
    for suite in $suites; do
      say "fetching $version ($file) from Debian's $suite"
      from_debian "$suite" "$source" "$file" "$sha" && break
    done
  fi
  if check "$cache/$file" "$sha"; then
    say "unpacking $version into $dest"
    unpack "$cache/$file" && exit 0
  fi
done <<<"$table"

say "no LAMMPS source could be had (tried:$tried)." >&2
say "Get a LAMMPS release between 4Feb2025 and 4Jul2026 and say LAMMPS_DIR=/path/to/lammps." >&2
exit 1
