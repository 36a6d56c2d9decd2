#!/usr/bin/env bash
# Builds the Debian package, installs it in a new Debian system, and tests server, client, manual
# pages, unit and completion. Then it purges the package. With a fake systemctl it tests the calls
# to systemd. Argument: build folder.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
build=$(cd "$1" && pwd)
. "$here/root_folder.sh"
need_root
need debootstrap cpack dpkg-shlibdeps

work=$(mktemp -d)
root=$work/root
server=
finish() {
  [ -z "$server" ] || kill "$server" 2>/dev/null || true
  drop_root "$root"
  rm -rf "$work"
}
trap finish EXIT
fail() {
  echo "package_test: $1" >&2
  exit 1
}

echo "== the package"
(cd "$work" && cpack --config "$build/CPackConfig.cmake" -B "$work" >"$work/cpack.log" 2>&1) ||
  { cat "$work/cpack.log" >&2; fail "cpack"; }
package=$(echo "$work"/motiondb_*.deb)
dpkg-deb --info "$package" | sed -n 's/^ \(Package\|Version\|Depends\|Installed-Size\):/  &/p'
dpkg-deb --contents "$package" | awk '{ print "  " $1, $2, $6 }' | grep -v '/ *$'
for library in libgrpc++ libprotobuf libsqlite3 libspdlog; do
  dpkg-deb --field "$package" Depends | grep -q "$library" || fail "does not depend on $library"
done

has_page=true
! grep -q '^MOTIONDB_WEB:STRING=OFF' "$build/CMakeCache.txt" || has_page=false
! $has_page || dpkg-deb --contents "$package" | grep '/share/motiondb/web/index.html$' >/dev/null ||
  fail "no web page; expected npm to download its packages, or the build with MOTIONDB_WEB=OFF"
[[ $(dpkg-deb --field "$package" Maintainer) == *\ \<*@*\> ]] || fail "no maintainer"

echo "== installed by apt"
make_root "$root"
cp "$package" "$root/tmp/"
enter_root "$root" apt-get update -qq
enter_root "$root" apt-get install -y -qq --no-install-recommends man-db bash-completion systemd \
  >"$work/apt.log" 2>&1 || { tail "$work/apt.log" >&2; fail "apt"; }
enter_root "$root" apt-get install -y -qq --no-install-recommends "/tmp/$(basename "$package")" \
  >"$work/apt.log" 2>&1 || { tail "$work/apt.log" >&2; fail "apt install ./motiondb_*.deb"; }
enter_root "$root" getent passwd motiondb | grep -q /var/lib/motiondb || fail "no user motiondb"
[ "$(enter_root "$root" stat -c %U:%a /var/lib/motiondb)" = motiondb:750 ] || fail "folder of the store"
as_service() {
  enter_root "$root" setpriv --reuid motiondb --regid motiondb --clear-groups "$@"
}
as_service motiondbd --config /etc/motiondb/motiondbd.conf --check-config | sed 's/^/  /'

enter_root "$root" grep -q "^Files: \*" /usr/share/doc/motiondb/copyright || fail "no copyright file"
enter_root "$root" zcat /usr/share/doc/motiondb/changelog.gz |
  grep -q "^motiondb ($(dpkg-deb --field "$package" Version))" || fail "changelog of another version"

echo "== server and queries, as the user of the service"
# Each command replaces itself by the next, so $! is the process id of the server.
chroot "$root" setpriv --reuid motiondb --regid motiondb --clear-groups \
  motiondbd --config /etc/motiondb/motiondbd.conf --listen 127.0.0.1:0 \
  --web-listen 127.0.0.1:0 --log-level error >"$work/address" &
server=$!
for _ in $(seq 100); do
  ! grep -q listening "$work/address" || break
  kill -0 "$server" || fail "motiondbd ended"
  sleep 0.1
done
address=$(sed -n 's/.*listening on //p' "$work/address")
web=$(sed -n 's/.*HTTP API at //p' "$work/address")
! $has_page || python3 -c 'import sys, urllib.request
sys.exit(b"<title>motiondb" not in urllib.request.urlopen(sys.argv[1]).read())' "$web" || fail "no web page at $web"
"$here/walk.py" 6 1 >"$root/tmp/walk.bvh"
"$here/walk.py" 6 2 >"$root/tmp/run.bvh"
ask() {
  enter_root "$root" motiondb --server "$address" "$@"
}
ask create demo --marker-set source --min-frames 4 >/dev/null
ask ingest demo /tmp/walk.bvh --label walk | tail -n 1
# The server reads GLB with motiondb-import.
enter_root "$root" motiondb convert /tmp/run.bvh /tmp/run.glb >/dev/null
ask ingest demo /tmp/run.glb --label run | tail -n 1
ask recognize demo /tmp/run.bvh --window all | tee "$work/answer"
grep -q run "$work/answer" || fail "recognize did not find the stored motion"
kill "$server"
wait "$server" || fail "motiondbd did not shut down cleanly"
server=
# The program that it runs is in the package, too. The file has legs only, so it is rejected.
enter_root "$root" motiondb inspect /tmp/walk.bvh >"$work/inspected" 2>&1 || true
grep -q "^duration  *6 s" "$work/inspected" || { cat "$work/inspected" >&2; fail "inspect"; }

echo "== documentation, manual pages, completion, unit"
for page in README.md docs/operations.md docs/command_line.md; do
  [ -s "$root/usr/share/doc/motiondb/$page" ] || fail "no $page in /usr/share/doc/motiondb"
done
for page in motiondb.1 motiondbd.8 motiondbd.conf.5; do
  enter_root "$root" env MANWIDTH=100 man -P cat "${page##*.}" "${page%.*}" >"$work/$page" ||
    fail "no manual page $page"
  [ "$(wc -l <"$work/$page")" -gt 40 ] || fail "manual page $page is short"
done
for program in motiondb motiondbd; do
  # Load it like a shell: bash-completion finds the file by the name of the program.
  enter_root "$root" bash -c ". /usr/share/bash-completion/bash_completion &&
    _completion_loader $program; complete -p $program" | grep -q "_$program" ||
    fail "no completion for $program"
done
for file in zsh/vendor-completions/_motiondb fish/vendor_completions.d/motiondb.fish; do
  [ -s "$root/usr/share/$file" ] || fail "no /usr/share/$file"
done
enter_root "$root" systemd-analyze verify motiondbd.service 2>&1 | grep -v "^$" >"$work/unit" || true
if grep -q motiondbd "$work/unit"; then
  cat "$work/unit" >&2
  fail "systemd-analyze verify"
fi

echo "== installed again: keeps the changed configuration"
echo 'max-frames = 4321' >>"$root/etc/motiondb/motiondbd.conf"
enter_root "$root" apt-get install -y -qq --reinstall "/tmp/$(basename "$package")" >"$work/apt.log" 2>&1 ||
  { tail "$work/apt.log" >&2; fail "apt install --reinstall"; }
as_service motiondbd --config /etc/motiondb/motiondbd.conf --check-config | grep "^max-frames = 4321"

echo "== upgraded without a terminal to a package with another configuration: keeps the changed one"
dpkg-deb --raw-extract "$package" "$work/next"
echo '# a new setting' >>"$work/next/etc/motiondb/motiondbd.conf"
sed -i 's/^Version: .*/&.1/' "$work/next/DEBIAN/control"
dpkg-deb --root-owner-group --build "$work/next" "$root/tmp/next.deb" >"$work/dpkg.log"
# The options in docs/operations.md, for upgrade and downgrade.
options=$(sed -n 's|^\$ sudo apt install \(.*\) ./motiondb_NEW_amd64.deb.*|\1|p' "$here/../../docs/operations.md")
[ -n "$options" ] || fail "docs/operations.md has no command for an upgrade"
for deb in next.deb "$(basename "$package")"; do
  # shellcheck disable=SC2086
  enter_root "$root" apt-get install -y -qq --allow-downgrades $options "/tmp/$deb" </dev/null >"$work/apt.log" 2>&1 ||
    { tail "$work/apt.log" >&2; fail "apt install $options $deb"; }
  enter_root "$root" dpkg-query --show --showformat '  ${Version} ${Status}\n' motiondb | grep "installed$"
  as_service motiondbd --config /etc/motiondb/motiondbd.conf --check-config | grep -q "^max-frames = 4321" ||
    fail "$deb changed the configuration"
done

echo "== removed and purged: keeps the store"
enter_root "$root" apt-get purge -y -qq motiondb >"$work/apt.log" 2>&1 ||
  { cat "$work/apt.log" >&2; fail "purge"; }
grep "is left" "$work/apt.log"
[ -s "$root/var/lib/motiondb/motion.db" ] || fail "purging removed the store"
[ ! -e "$root/etc/motiondb/motiondbd.conf" ] || fail "purging left the configuration"
[ ! -e "$root/usr/bin/motiondbd" ] || fail "purging left the server"
echo "== calls to systemd"
rm "$root/usr/sbin/policy-rc.d"
mv "$root/usr/bin/systemctl" "$root/usr/bin/systemctl.real"
mkdir -p "$root/run/systemd/system"
# A fake systemctl: the real one makes and reads links; calls to systemd are only logged.
cat >"$root/usr/bin/systemctl" <<'SYSTEMCTL'
#!/bin/sh
case " $* " in
  *" preset "* | *" is-enabled "*) exec systemctl.real --root=/ "$@" ;;
  *" is-active "*) [ -e /run/motiondbd.runs ]; exit ;;
  *" start "* | *" restart "*) touch /run/motiondbd.runs ;;
  *" stop "*) rm -f /run/motiondbd.runs ;;
esac
echo "$*" >>/run/systemctl.calls
SYSTEMCTL
chmod +x "$root/usr/bin/systemctl"
after() {  # NAME CALL STATE DPKG-ARGUMENT...: runs dpkg, checks its call for the service and the resulting state
  local what=$1 expected=$2 state=$3 calls runs=stopped
  shift 3
  : >"$root/run/systemctl.calls"
  enter_root "$root" dpkg "$@" >"$work/dpkg.log" 2>&1 || { cat "$work/dpkg.log" >&2; fail "dpkg $1"; }
  calls=$(sed -nE 's/^(.* )?([a-z-]+) motiondbd.service$/\2/p' "$root/run/systemctl.calls" | tr '\n' ' ')
  [ ! -e "$root/run/motiondbd.runs" ] || runs=running
  echo "  $what: ${calls:-nothing }-> $runs"
  [ "$calls" = "${expected:+$expected }" ] && [ "$runs" = "$state" ] || fail "$what: expected $expected, $state"
  grep -q daemon-reload "$root/run/systemctl.calls" || fail "$what: no daemon-reload"
}
deb=/tmp/$(basename "$package")
wanted=$root/etc/systemd/system/multi-user.target.wants/motiondbd.service
after installed start running --install "$deb"
after upgraded restart running --install "$deb"
after removed stop stopped --remove motiondb
after "installed again" restart running --install "$deb"
rm "$wanted" "$root/run/motiondbd.runs"  # systemctl disable --now
after "upgraded, disabled" "" stopped --install "$deb"
[ ! -e "$wanted" ] || fail "an upgrade enabled the disabled service"
after purged stop stopped --purge motiondb
! find "$root/etc/systemd/system" -name 'motiondbd.service' | grep . || fail "purging left links to the unit"
echo "package_test: passed"
