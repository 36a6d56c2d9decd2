#!/bin/sh
# Installs the client into a new folder, builds the example with find_package, and runs it.
# Arguments: cmake, build folder, example folder, generator, compiler, compiler launcher, sanitizers
# (the last two may be empty).
set -eu
cmake=$1 build=$2 example=$3 generator=$4 compiler=$5 launcher=${6:-} sanitize=${7:-}

work=$build/package_test
rm -rf "$work"
mkdir -p "$work"

fail() {
  echo "package_test: $1" >&2
  exit 1
}

"$cmake" --install "$build" --component client --prefix "$work/prefix" > "$work/install.log"
"$work/prefix/bin/motiondb" --version | grep -q '^motiondb [0-9]' || fail "motiondb --version"
find "$work/prefix" -name query.proto | grep -q . || fail "the .proto files are not installed"
if grep -rn "client/connection.h\|core/" "$work/prefix/include" --include='*.h' |
    grep '#include'; then
  fail "an installed header includes a header that is not installed"
fi

flags=
if [ -n "$sanitize" ]; then flags=-fsanitize=$sanitize; fi
"$cmake" -S "$example" -B "$work/example" -G "$generator" \
  -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_CXX_COMPILER_LAUNCHER="$launcher" \
  -DCMAKE_CXX_FLAGS="$flags" -DCMAKE_PREFIX_PATH="$work/prefix" > "$work/configure.log"
"$cmake" --build "$work/example" > "$work/build.log" || {
  cat "$work/build.log" >&2
  fail "the example does not build"
}

# Nothing listens on port 1: the example must report it.
if "$work/example/recognize_motion" 127.0.0.1:1 walks walk a.bvh b.bvh 2> "$work/error.txt"; then
  fail "the example succeeded without a server"
fi
grep -q '127.0.0.1:1' "$work/error.txt" || fail "the example's error does not name the server"
echo "package_test: installed, found, built and run"
