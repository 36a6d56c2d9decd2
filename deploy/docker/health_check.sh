#!/bin/bash
# Healthy: the server says on its HTTP port that it is ready. Where HTTP is off: it listens for gRPC.
set -eu

http=${MOTIONDBD_HTTP_LISTEN:-none}
if [ "$http" = none ]; then
  exec 3<>"/dev/tcp/127.0.0.1/${MOTIONDBD_LISTEN##*:}"
  exit 0
fi
exec 3<>"/dev/tcp/127.0.0.1/${http##*:}"
printf 'GET /readyz HTTP/1.0\r\nHost: localhost\r\n\r\n' >&3
IFS= read -r -t 4 status <&3
[[ $status == HTTP/1.?\ 200* ]]
