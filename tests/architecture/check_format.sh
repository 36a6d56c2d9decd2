#!/usr/bin/env bash
# Every C++ file stands as clang-format would write it.
set -euo pipefail
cd "$(dirname "$0")/../.."
find text core storage server client tests \( -name '*.h' -o -name '*.cc' \) -print0 |
  xargs -0 clang-format --dry-run --Werror
echo "format: as .clang-format says"
