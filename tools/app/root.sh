#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# A real Blender with a display to try it on: Debian's packages in a folder of their own.
#
#   tools/app/root.sh FOLDER [SUITE]
#
# Needs Debian, root, about 3 minutes and 1.5 GB. Does nothing if the folder is already set up. SUITE is Debian's: sid
# (the default) has Blender 5.2 LTS on Python 3.14.
set -eu
root=$1
suite=${2:-sid}
[ -e "$root/.ready" ] && exit
mkdir -p "$root"
root=$(realpath "$root")

# The machine's own mirror, whichever way its sources are written.
sources=$(ls /etc/apt/sources.list.d/debian.sources /etc/apt/sources.list 2>/dev/null || true)
mirror=$(sed -nE 's/^(URIs:|deb( \[[^]]*\])?) *([^ ]+).*/\3/p' $sources | head -n 1)

command -v debootstrap >/dev/null || { apt-get update -qq && apt-get install -qq -y debootstrap; }
debootstrap --variant=minbase "$suite" "$root" "$mirror"
packages="blender python3-numpy python3-requests python3-zstandard python3-cattr
    xvfb xdotool imagemagick tesseract-ocr libgl1-mesa-dri libegl1 libegl-mesa0 libglx-mesa0"
DEBIAN_FRONTEND=noninteractive chroot "$root" apt-get install -qq -y --no-install-recommends $packages
touch "$root/.ready"
