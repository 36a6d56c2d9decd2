#!/usr/bin/env bash
# Checks that every C++ file is formatted by clang-format.
set -euo pipefail
cd "$(dirname "$0")/../.."
find text core import storage server client tests \( -name '*.h' -o -name '*.cc' \) -print0 |
  xargs -0 clang-format --dry-run --Werror
echo "format: all files are formatted"
