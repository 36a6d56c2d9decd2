#!/usr/bin/env bash
# Types, rules, format and unit tests of client/web.
set -euo pipefail
cd "$(dirname "$0")/../../client/web"
skip() {
  echo "skipped: $1"
  exit 77
}
command -v npm >/dev/null || skip "npm is missing (deploy/install_packages.sh web)"
command -v protoc >/dev/null || skip "protoc is missing"
[ -d node_modules ] || skip "the packages of client/web are not installed (build the target web)"
exec 9>.build-lock
flock 9
npm run --silent check
