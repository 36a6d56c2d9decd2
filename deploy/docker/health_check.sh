#!/bin/bash
# Healthy: /readyz on the HTTP port returns 200; without HTTP, the gRPC port accepts connections.
# Reads the addresses only from environment variables, not from flags or the configuration file.
set -eu

# dial HOST:PORT: connects descriptor 3. Uses loopback if the server listens on all addresses.
dial() {
  local host=${1%:*}
  case "$host" in
    0.0.0.0) host=127.0.0.1 ;;
    '[::]') host=localhost ;;  # IPv4 if the machine has no IPv6
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
