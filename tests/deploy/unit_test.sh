#!/usr/bin/env bash
# Checks the systemd unit with systemd-analyze: no errors, low exposure. Argument: path of
# motiondbd.
set -euo pipefail
cd "$(dirname "$0")/../.."
command -v systemd-analyze >/dev/null ||
  { echo "skipped: no systemd-analyze; deploy/install_packages.sh deploy-test"; exit 77; }

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# systemd-analyze looks for the program and the manual pages. Use the built program; omit the pages.
sed -e "s#/usr/bin/motiondbd#$1#" -e '/^Documentation=/d' deploy/systemd/motiondbd.service \
  >"$work/motiondbd.service"
if ! systemd-analyze verify --recursive-errors=no "$work/motiondbd.service" 2>"$work/verify" ||
  grep -q motiondbd.service "$work/verify"; then
  cat "$work/verify" >&2
  exit 1
fi
# Wrong settings must not cause restarts. systemd applies RestartPreventExitStatus only to the main
# process.
grep -q '^RestartPreventExitStatus=2$' deploy/systemd/motiondbd.service ||
  { echo "unit_test: expected RestartPreventExitStatus=2, against endless restarts" >&2; exit 1; }
! grep -n '^ExecStartPre=' deploy/systemd/motiondbd.service >&2 ||
  { echo "unit_test: expected no ExecStartPre, whose failure would cause endless restarts" >&2; exit 1; }
# The start limit must take effect: its interval is longer than all pauses between its starts.
value() { sed -n "/^\[$1\]/,/^\[/s/^$2=\([0-9]*\)s\?\$/\1/p" deploy/systemd/motiondbd.service; }
starts=$(value Unit StartLimitBurst)
[ "$(value Unit StartLimitIntervalSec)" -gt $(($(value Service RestartSec) * starts)) ] ||
  { echo "unit_test: StartLimitIntervalSec is too short for StartLimitBurst and RestartSec" >&2; exit 1; }
systemd-analyze security --offline=yes --threshold=15 --no-pager "$work/motiondbd.service" >"$work/security" ||
  { cat "$work/security" >&2; exit 1; }
grep "Overall exposure" "$work/security"
# The unit and the sample configuration use the same paths.
grep -q -- "--config /etc/motiondb/motiondbd.conf" deploy/systemd/motiondbd.service
grep -q '^store = "/var/lib/motiondb/' deploy/motiondbd.conf
grep -q '^StateDirectory=motiondb$' deploy/systemd/motiondbd.service
