#!/bin/bash
# Healthy: the server says on its HTTP port that it is ready. Where HTTP is off: it listens for gRPC.
# Where that is it reads from the variables alone; of flags and the configuration file it knows nothing.
set -eu

# dial HOST:PORT: connects, as descriptor 3. A server on every address is asked on loopback.
dial() {
  local host=${1%:*}
  case "$host" in
    0.0.0.0) host=127.0.0.1 ;;
    '[::]') host=localhost ;;  # of either version of IP: where there is no IPv6, that is IPv4
    '['*) host=${host:1:-1} ;;
  esac
  exec 3<>"/dev/tcp/$host/${1##*:}"
}

http=${MOTIONDBD_HTTP_LISTEN:-none}
if [ "$http" = none ]; then
  dial "$MOTIONDBD_LISTEN"
  exit 0
fi
dial "$http"
printf 'GET /readyz HTTP/1.0\r\nHost: localhost\r\n\r\n' >&3
IFS= read -r -t 4 status <&3
[[ $status == HTTP/1.?\ 200* ]]
