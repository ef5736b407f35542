#!/usr/bin/env bash
# thread_sanitizer.sh [CTEST OPTIONS]: the tests under the thread sanitizer, by default the unit tests
# (`--label-regex '^cli$'` for those of the commands).
#
# TBB hands work from thread to thread inside its library, which the sanitizer must see to know that
# one thing came after the other: without it every parallel loop looks like a race. So the
# distribution's own version of TBB is taken as source, built with the sanitizer, and loaded in the
# place of the installed one. Embree and OpenImageIO stay as they are; what only their own threads
# do is left out by thread_sanitizer.supp.
#
# Needs the network, apt, dpkg-dev and the build's packages. All is kept in build/tsan.
set -euo pipefail
cd -- "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/.."
tsan=$PWD/build/tsan
tbb=$tsan/tbb
jobs=$(nproc)

if [[ ! -e $tbb/done ]]; then
  rm -rf -- "$tbb"
  mkdir -p "$tbb/lists/partial" "$tbb/source"
  # shellcheck disable=SC2016 # apt's own variables
  archive=$(apt-get indextargets --format '$(LABEL) $(REPO_URI) $(CODENAME)' | awk '$1 == "Debian" {print $2, $3; exit}')
  [[ -n $archive ]] || { echo "apt on this machine knows no Debian archive" >&2; exit 75; }
  echo "deb-src $archive main" >"$tbb/sources.list"
  from=(-o Dir::Etc::sourcelist="$tbb/sources.list" -o Dir::Etc::sourceparts=- -o Dir::State::lists="$tbb/lists")
  if ! { apt-get "${from[@]}" update && (cd "$tbb/source" && apt-get "${from[@]}" source onetbb); } >"$tbb/log" 2>&1; then
    tail -n 5 "$tbb/log" >&2
    exit 75
  fi
  cmake -S "$tbb"/source/onetbb-*/ -B "$tbb/build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DTBB_SANITIZE=thread \
    -DTBB_TEST=OFF -DTBB_STRICT=OFF -DTBBMALLOC_BUILD=OFF >>"$tbb/log"
  cmake --build "$tbb/build" --parallel "$jobs" >>"$tbb/log"
  touch "$tbb/done"
fi

# Built and installed programs find it by themselves: the tests of the commands hand no environment on,
# and other programs that they call must keep the plain one.
place=$(find "$tbb/build" -name libtbb.so.12 -printf '%h\n' -quit)
cmake --preset tsan -DCMAKE_BUILD_RPATH="$place" -DCMAKE_INSTALL_RPATH="$place"
cmake --build --preset tsan --parallel "$jobs" \
  --target backbend_descriptions backbend_import solver_tests skin_tests render_tests validate_tests
(($#)) || set -- --label-regex '^(solver|skin|render|validate)$'
exec ctest --preset tsan --parallel "$jobs" --no-tests=error "$@"
