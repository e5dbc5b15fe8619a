#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# The acceptance suite in the folder that root.sh set up:
#
#   tools/app/run.sh ROOT OUTPUT
#
# Tries the zips in dist; leaves the pictures of every step in OUTPUT. Processes and mounts end with it.
set -eu
root=$(realpath "$1")
output=$2
work=$root/root/app
rm -rf "$work"
mkdir -p "$work" "$output"
cp tools/app/*.py dist/prt_relight-*.zip "$work"
status=0
unshare --mount --pid --fork --kill-child --mount-proc="$root/proc" sh -c '
    mount --rbind /dev "$1/dev"
    exec chroot "$1" env -i HOME=/root LANG=C.UTF-8 PATH=/usr/bin:/bin python3 /root/app/accept.py' sh "$root" || status=$?
rm -f "$output"/*.png "$output"/window.log
cp "$work"/*.png "$work"/*.log "$output" || true
exit $status
