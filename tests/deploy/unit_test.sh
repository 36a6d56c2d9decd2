#!/usr/bin/env bash
# The service's unit: systemd finds nothing wrong with it and little exposed. Arguments: motiondbd.
set -euo pipefail
cd "$(dirname "$0")/../.."
command -v systemd-analyze >/dev/null ||
  { echo "skipped: no systemd-analyze; deploy/install_packages.sh deploy-test"; exit 77; }

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# systemd looks for the program and the manual pages, too: it gets the ones that were built, where there are
# none installed.
sed -e "s#/usr/bin/motiondbd#$1#" -e '/^Documentation=/d' deploy/systemd/motiondbd.service \
  >"$work/motiondbd.service"
if ! systemd-analyze verify --recursive-errors=no "$work/motiondbd.service" 2>"$work/verify" ||
  grep -q motiondbd.service "$work/verify"; then
  cat "$work/verify" >&2
  exit 1
fi
# Wrong settings end the service once. systemd heeds RestartPreventExitStatus for the main process alone.
grep -q '^RestartPreventExitStatus=2$' deploy/systemd/motiondbd.service ||
  { echo "unit_test: wrong settings make it start for ever" >&2; exit 1; }
! grep -n '^ExecStartPre=' deploy/systemd/motiondbd.service >&2 ||
  { echo "unit_test: what fails before the main process is tried for ever" >&2; exit 1; }
# Nor is anything else tried without end: the interval has room for all the starts, pauses between them.
value() { sed -n "/^\[$1\]/,/^\[/s/^$2=\([0-9]*\)s\?\$/\1/p" deploy/systemd/motiondbd.service; }
starts=$(value Unit StartLimitBurst)
[ "$(value Unit StartLimitIntervalSec)" -gt $(($(value Service RestartSec) * starts)) ] ||
  { echo "unit_test: no limit of starts" >&2; exit 1; }
systemd-analyze security --offline=yes --threshold=15 --no-pager "$work/motiondbd.service" >"$work/security" ||
  { cat "$work/security" >&2; exit 1; }
grep "Overall exposure" "$work/security"
# The unit's folder and file are those of the sample.
grep -q -- "--config /etc/motiondb/motiondbd.conf" deploy/systemd/motiondbd.service
grep -q '^store = "/var/lib/motiondb/' deploy/motiondbd.conf
grep -q '^StateDirectory=motiondb$' deploy/systemd/motiondbd.service
