# Debian systems in folders, for tests; source this file. Downloads are kept in `cache`.
#
#   need_root            skips the test if chroot is not allowed
#   need PROGRAM...      skips the test if a program is not installed
#   make_root FOLDER     makes a new Debian 12 in FOLDER, with the package sources of this machine
#   enter_root FOLDER COMMAND...    runs a command in it
#   drop_root FOLDER     unmounts and removes it

skipped=77  # SKIP_RETURN_CODE of ctest
cache=${MOTIONDB_DEPLOY_CACHE:-$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)/build/deploy}

need_root() {
  [ "$(id -u)" = 0 ] || { echo "skipped: needs root, for chroot"; exit "$skipped"; }
}

need() {
  local program
  for program in "$@"; do
    command -v "$program" >/dev/null ||
      { echo "skipped: no $program; deploy/install_packages.sh deploy-test"; exit "$skipped"; }
  done
}

# Makes a minimal Debian once; every test copies it.
base_root() {
  local base=$cache/bookworm source
  [ ! -e "$base" ] || return 0
  source=$(apt-get indextargets --format '$(RELEASE) $(REPO_URI)' 'Created-By: Packages' |
    awk '$1 == "bookworm" { print $2; exit }')
  [ -n "$source" ] || { echo "skipped: no package source of bookworm"; exit "$skipped"; }
  echo "making a Debian in $base (once, takes minutes)"
  mkdir -p "$cache"
  rm -rf "$base.new"
  debootstrap --variant=minbase bookworm "$base.new" "$source" >"$cache/debootstrap.log" ||
    { tail -n 20 "$cache/debootstrap.log" >&2; exit 1; }
  # No fsync by dpkg: these systems are temporary.
  echo force-unsafe-io >"$base.new/etc/dpkg/dpkg.cfg.d/unsafe-io"
  printf '#!/bin/sh\nexit 101\n' >"$base.new/usr/sbin/policy-rc.d"  # no services in a chroot
  chmod +x "$base.new/usr/sbin/policy-rc.d"
  mv "$base.new" "$base"
}

make_root() {
  base_root
  mkdir -p "$cache/archives" "$1"
  cp -a "$cache/bookworm/." "$1"
  # Package sources and network settings of this machine; not in the cached copy.
  rm -f "$1/etc/apt/sources.list"
  cp -rL /etc/apt/. "$1/etc/apt"
  rm -f "$1"/etc/apt/apt.conf.d/docker-*  # they delete downloads and manual pages
  cp -L /etc/resolv.conf "$1/etc/resolv.conf"
  cp -rL /usr/share/keyrings/. "$1/usr/share/keyrings"
  mkdir -p "$1/var/cache/apt/archives/partial" "$1/dev" "$1/proc"
  mount --bind "$cache/archives" "$1/var/cache/apt/archives"
  mkdir -p "$cache/archives/partial"
  mount -t proc proc "$1/proc"
  mount --rbind /dev "$1/dev"
  mount --make-rslave "$1/dev"
}

enter_root() {
  local root=$1
  shift
  chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 \
    DEBIAN_FRONTEND=noninteractive "$@"
}

drop_root() {
  umount -lR "$1/dev" "$1/proc" "$1/var/cache/apt/archives" 2>/dev/null || true
  # Never delete files of a mounted file system.
  if grep -q " $1/" /proc/mounts; then
    echo "cannot remove $1: a file system is still mounted in it" >&2
    return
  fi
  rm -rf "$1"
}
