#!/usr/bin/env bash
# Fetch a LAMMPS source tree, check it against a pinned sha256, and unpack what a build needs.
#
#   cmake/fetch-lammps.sh DIR [VERSION]      VERSION: 4Jul2026 (default) or 4Feb2025
#
# Sources, tried in this order: the Debian archive (the mirror that apt uses on this machine, or
# $PERIDEM_DEBIAN_MIRROR), the release tarball of the LAMMPS project. Each file is accepted only
# with its own sha256 below. The tarball is kept in DIR/../downloads (or $PERIDEM_DOWNLOADS), where
# it may also be put by hand. A tree of that version already in DIR is left alone, so a second call
# needs no network.
set -euo pipefail

usage() { sed -n '2,11s/^# \{0,1\}//p' "$0"; }
case "${1:-}" in ''|-h|--help) usage; exit 0 ;; esac

dest=$1
wanted=${2:-4Jul2026}
cache=${PERIDEM_DOWNLOADS:-$(dirname "$dest")/downloads}

say() { printf 'lammps: %s\n' "$*"; }
die() { printf 'lammps: %s\n' "$@" >&2; exit 1; }

# Debian's file is its source package of that release (directories of lib/ that no package used
# here needs are left out); the release file is the whole project at the tag patch_VERSION.
debian_pool=pool/main/l/lammps
case "$wanted" in
  4Jul2026)
    debian_file=lammps_20260704+dfsg.orig.tar.gz
    debian_sha=cddbc45a047416bd48a4a0b87f24a5b61b3446982b74d18cafe619c22b17eb62
    release_sha=be9deffba169d140c337fd29570d3f5469332ece7e77280cce998f6caaad5534 ;;
  4Feb2025)
    debian_file=lammps_20250204+dfsg.1.orig.tar.xz
    debian_sha=3671165bd52fad36734e0a9136c5bc5ecb225e03988f8c89aa13366a8b53b1c7
    release_sha=a4cb0a58451d47ac31ee3e1f148d92f445298d6e27f2d06f161b9b4168d79eb1 ;;
  *) die "VERSION '$wanted' is not known; allowed: 4Jul2026, 4Feb2025" ;;
esac
release_file=lammps-patch_$wanted.tar.gz

tree_version() { # DIR
  [ -f "$1/src/version.h" ] &&
    sed -n 's/^#define LAMMPS_VERSION "\(.*\)"/\1/p' "$1/src/version.h" | tr -d ' '
}

checked() { # FILE SHA256
  [ -f "$1" ] && [ "$(sha256sum "$1" | cut -d' ' -f1)" = "$2" ]
}

debian_mirror() { # the mirror this machine already uses; nothing where there is none
  local site=${PERIDEM_DEBIAN_MIRROR:-}
  if [ -z "$site" ] && command -v apt-get >/dev/null; then
    site=$(apt-get indextargets --format '$(SITE)' 'Created-By: Packages' 2>/dev/null |
             grep -E '/debian/?$' | head -n 1 || true)
  fi
  printf '%s\n' "${site%/}"
}

download() { # URL FILE: with what this machine has; apt-helper knows apt's proxy and certificates
  local apt_helper=${PERIDEM_APT_HELPER:-/usr/lib/apt/apt-helper}
  if [ -x "$apt_helper" ] && "$apt_helper" -qq -o APT::Sandbox::User=root \
       -o Acquire::Retries=3 download-file "$1" "$2" >/dev/null 2>&1; then return 0; fi
  if command -v curl >/dev/null; then
    curl -fsSL --retry 3 --connect-timeout 20 -o "$2" "$1" 2>/dev/null && return 0
  elif command -v wget >/dev/null; then
    wget -q --tries=3 --timeout=20 -O "$2" "$1" 2>/dev/null && return 0
  fi
  return 1
}

fetch() { # FILE SHA256 URL...: the checked file in $cache, or failure
  local file=$1 sha=$2 url partial=$cache/$1.partial
  shift 2
  checked "$cache/$file" "$sha" && return 0
  for url; do
    say "fetching $url"
    rm -f "$partial"
    if ! download "$url" "$partial"; then
      say "  not there, or no way to get there"
    elif ! checked "$partial" "$sha"; then
      say "  refused: its sha256 is not the pinned $sha"
    else
      mv "$partial" "$cache/$file"
      return 0
    fi
  done
  rm -f "$partial"
  return 1
}

unpack() { # FILE
  local partial=$dest.partial top strip=0 part
  local parts=(src cmake python third_party LICENSE README doc/lammps.1)
  rm -rf "$partial"
  mkdir -p "$partial"
  top=$(tar -tf "$1" 2>/dev/null | head -n 1 || true)  # Debian's 4Jul2026 has no top directory
  case "$top" in
    lammps-*) strip=1; for part in "${!parts[@]}"; do parts[part]=${top%%/*}/${parts[part]}; done ;;
    ./*) for part in "${!parts[@]}"; do parts[part]=./${parts[part]}; done ;;
  esac
  # 4Feb2025 has no third_party, and tar says so: the check below is what counts
  tar -xf "$1" -C "$partial" --no-same-owner --strip-components="$strip" "${parts[@]}" \
    2>/dev/null || true
  [ "$(tree_version "$partial")" = "$wanted" ] && [ -f "$partial/cmake/CMakeLists.txt" ] &&
    [ -d "$partial/python/lammps" ] || die "could not unpack $1 (a full disk? no xz?)"
  rm -rf "$dest"
  mv "$partial" "$dest"
}

if [ "$(tree_version "$dest")" = "$wanted" ]; then
  say "$wanted is in $dest"
  exit 0
fi
if [ -e "$dest" ] && [ -n "$(ls -A "$dest")" ] && [ -z "$(tree_version "$dest")" ]; then
  die "$dest is not empty and no LAMMPS tree: give another DIR"
fi
mkdir -p "$cache"
mirror=$(debian_mirror)
if fetch "$debian_file" "$debian_sha" ${mirror:+"$mirror/$debian_pool/$debian_file"}; then
  file=$debian_file
elif fetch "$release_file" "$release_sha" \
       "https://github.com/lammps/lammps/archive/patch_$wanted.tar.gz"; then
  file=$release_file
else
  die "LAMMPS $wanted could not be fetched. Either put one of these into $cache:" \
      "  $debian_file (sha256 $debian_sha)" \
      "  $release_file (sha256 $release_sha)" \
      "or point at a LAMMPS tree between 4Feb2025 and 4Jul2026: LAMMPS_DIR=/path/to/lammps"
fi
say "unpacking $wanted into $dest"
unpack "$cache/$file"
