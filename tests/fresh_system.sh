#!/usr/bin/env bash
# fresh_system.sh RELEASE [OPTIONS]: what a newcomer would see. Makes a minimal Debian of RELEASE
# (bookworm, trixie) in a folder, clones HEAD into it and runs
# ./backbend nightly and ./backbend test there: as root, and as a user with sudo in a second such system.
#
#   --as root|user     only one of the two (both)
#   --command WORDS    only this instead of the two commands, e.g. --command "nightly --quiet"
#   --ca FILE          certificate bundle of the site, trusted in there
#   --npmrc FILE       npm settings of the site, used in there
#   --characters FOLDER  real characters for the tests, which skip theirs without it
#   --in FOLDER        where the systems are made, some 4 GB each (a new folder under /tmp)
#   --keep             leave them there
#
# Needs root, debootstrap and the network. Archive addresses and apt's settings are this machine's
# own. Everything is mounted in a namespace of its own, which vanishes with the last process.
# Ends with a table of what was run, and with 0 where every command ended as it must.
set -euo pipefail

usage() { sed -n '2,15s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2; exit 2; }
[[ ${1-} =~ ^[a-z]+$ ]] || usage
release=$1
shift
accounts=(root user) commands=(nightly test) ca='' npmrc='' characters='' top='' keep=
while (($#)); do
  case $1 in
    --as) accounts=("$2"); shift ;;
    --command) commands=("$2"); shift ;;
    --ca) ca=$(readlink -e -- "$2"); shift ;;
    --npmrc) npmrc=$(readlink -e -- "$2"); shift ;;
    --characters) characters=$(readlink -e -- "$2"); shift ;;
    --in) top=$2; shift ;;
    --keep) keep=1 ;;
    *) usage ;;
  esac
  shift
done
(($(id -u) == 0)) || { echo "fresh_system.sh needs root" >&2; exit 75; }
source=$(readlink -f -- "${BASH_SOURCE[0]}")
source=${source%/tests/*}

# Once more in a namespace of its own: no mount and no daemon outlives it.
if [[ -z ${BACKBEND_FRESH_NAMESPACE-} ]]; then
  if [[ -z $top ]]; then top=$(mktemp -d /tmp/fresh-system.XXXXXX); fi
  mkdir -p "$top"
  again=("$release" --in "$top" ${keep:+--keep})
  status=0
  for account in "${accounts[@]}"; do
    arguments=("${again[@]}" --as "$account" ${ca:+--ca "$ca"} ${npmrc:+--npmrc "$npmrc"}
      ${characters:+--characters "$characters"})
    ((${#commands[@]} == 1)) && arguments+=(--command "${commands[0]}")
    BACKBEND_FRESH_NAMESPACE=1 unshare --mount --propagation private --pid --fork --mount-proc \
      --kill-child "$0" "${arguments[@]}" || status=$?
    if [[ -z $keep ]]; then rm -rf --one-file-system -- "${top:?}/$account"; fi
  done
  echo "== $release"
  cat "$top"/*.results
  if [[ -z $keep ]]; then rm -rf --one-file-system -- "$top"; fi
  exit "$status"
fi

account=${accounts[0]}
system=$top/$account
results=$top/$account.results
: >"$results"

# archive LABEL: the address that this machine's own apt has for it.
# shellcheck disable=SC2016 # apt's own variables
archive() {
  apt-get indextargets --format '$(LABEL) $(REPO_URI)' | awk -v label="$1" '$1 == label {print $2; exit}'
}
main=$(archive Debian)
security=$(archive Debian-Security)
[[ -n $main ]] || { echo "apt on this machine knows no Debian archive" >&2; exit 75; }

echo "== $release: a minimal system for $account in $system" >&2
rm -rf --one-file-system -- "$system"
mkdir -p "$system/etc/apt/apt.conf.d"
debootstrap --variant=minbase "$release" "$system" "$main" >"$top/$account.debootstrap.log" 2>&1 ||
  { tail -n 5 "$top/$account.debootstrap.log" >&2; exit 75; }

{
  echo "deb $main $release main"
  echo "deb $main $release-updates main"
  if [[ -n $security ]]; then echo "deb $security $release-security main"; fi
} >"$system/etc/apt/sources.list"
apt-config dump Acquire | grep -E '^Acquire::(http|https|Check-|Retries|ForceIPv)' \
  >"$system/etc/apt/apt.conf.d/00site" || true
cp -L /etc/resolv.conf /etc/hosts "$system/etc/"
# As a fresh system has none of its services running, nothing that is installed is started.
printf '#!/bin/sh\nexit 101\n' >"$system/usr/sbin/policy-rc.d"
chmod 755 "$system/usr/sbin/policy-rc.d"

home=/root
chroot "$system" mkdir -p /etc/ssl/site
environment=(LANG=C.UTF-8 TERM=dumb)
if [[ -n $ca ]]; then
  cp -L "$ca" "$system/etc/ssl/site/ca.pem"
  chmod 644 "$system/etc/ssl/site/ca.pem"
  echo 'Acquire::https::CaInfo "/etc/ssl/site/ca.pem";' >>"$system/etc/apt/apt.conf.d/00site"
  environment+=(SSL_CERT_FILE=/etc/ssl/site/ca.pem NODE_EXTRA_CA_CERTS=/etc/ssl/site/ca.pem)
fi
mount -t proc proc "$system/proc"
mount --rbind /dev "$system/dev"
mount --rbind /sys "$system/sys"
if [[ -n $characters ]]; then
  mkdir -p "$system/srv/characters"
  mount --bind "$characters" "$system/srv/characters"
  mount -o remount,bind,ro "$system/srv/characters"
  environment+=(BACKBEND_CHARACTERS=/srv/characters)
fi

if [[ $account == user ]]; then
  home=/home/td
  {
    chroot "$system" apt-get update
    DEBIAN_FRONTEND=noninteractive chroot "$system" apt-get install -y --no-install-recommends sudo
    chroot "$system" useradd --create-home --shell /bin/bash td
  } >"$top/$account.sudo.log" 2>&1 || { tail -n 5 "$top/$account.sudo.log" >&2; exit 75; }
  echo 'td ALL=(ALL) NOPASSWD: ALL' >"$system/etc/sudoers.d/td"
fi
if [[ -n $npmrc ]]; then
  install -m 644 "$npmrc" "$system$home/.npmrc"
  if [[ -n $ca ]]; then
    sed -i '/^cafile *=/d' "$system$home/.npmrc"
    echo cafile=/etc/ssl/site/ca.pem >>"$system$home/.npmrc"
  fi
fi
git clone --quiet --depth 1 "file://$source" "$system$home/backbend"
chroot "$system" chown -R "$([[ $account == user ]] && echo td:td || echo root:root)" "$home"

# inside WORDS: runs them in the clone, from a login with nothing set, and without a terminal.
inside() {
  local -a become=(env -i)
  if [[ $account == user ]]; then become=(setpriv --reuid td --regid td --init-groups --reset-env env); fi
  chroot "$system" "${become[@]}" HOME="$home" PATH=/usr/local/bin:/usr/bin:/bin \
    "${environment[@]}" sh -c "cd $home/backbend && exec $*" </dev/null
}

failed=0
# step WORDS -- ALLOWED EXIT CODES: runs and notes one command.
step() {
  local words=$1 started=$SECONDS code=0 verdict=ok
  echo "== $release, $account: $words" >&2
  inside "$words" >"$top/$account.out" 2> >(tee "$top/$account.err" >&2) || code=$?
  tail -n 12 "$top/$account.out"
  if [[ " ${*:2} " != *" $code "* ]]; then verdict=FAILED failed=1; fi
  printf '%-8s %-5s %-40s exit %-3s %5d s  %s\n' "$release" "$account" "$words" "$code" \
    $((SECONDS - started)) "$verdict" | tee -a "$results" >&2
}

for command in "${commands[@]}"; do
  case $command in
    test*) step "./backbend $command" 0 ;;
    # The bundled suite's proposed rig is the thesis's, whose faults are found: 1 is its honest end.
    nightly*) step "./backbend $command" 0 1
      page=$(grep -o '[^ ]*index\.html' "$top/$account.out" | tail -n 1 || true)
      step "test -s '${page:-no page was named}'" 0 ;;
    *) step "./backbend $command" 0 ;;
  esac
done
exit "$failed"
