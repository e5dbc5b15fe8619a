#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# What a fresh machine lacks and pip cannot install: the shared libraries that bpy links to, Python's venv, and for the tests Node,
# npm and, where apt has it, Chromium.
#
#   tools/system.sh PYTHON [node]
#
# Says nothing if all is there. As root with apt, it installs what is missing; otherwise it stops with the line to run.
set -eu
python=$1
missing=""
names=""

lacks() { # NAME PACKAGE
    names="$names $1"
    missing="$missing $2"
}

if [ "$(uname -s)" = Linux ]; then
    while read -r library package; do
        "$python" -c "import ctypes; ctypes.CDLL('$library')" 2>/dev/null || lacks "$library" "$package"
    done <<END
libX11.so.6 libx11-6
libXi.so.6 libxi6
libXxf86vm.so.1 libxxf86vm1
libXfixes.so.3 libxfixes3
libXrender.so.1 libxrender1
libxkbcommon.so.0 libxkbcommon0
libSM.so.6 libsm6
libICE.so.6 libice6
libGL.so.1 libgl1
libEGL.so.1 libegl1
END
    # EEVEE draws through a driver: a vendor's own, or Mesa's, which needs no graphics card.
    if ! ls /usr/lib*/dri/*_dri.so /usr/lib/*/dri/*_dri.so /usr/lib*/libEGL_nvidia.so.0 /usr/lib/*/libEGL_nvidia.so.0 2>/dev/null |
        grep -q .; then
        lacks "a driver for OpenGL" libgl1-mesa-dri
    fi
fi
"$python" -c "import ensurepip, venv" 2>/dev/null || lacks "Python's venv" python3-venv
if [ "${2:-}" = node ]; then
    command -v node >/dev/null || lacks node nodejs
    command -v npm >/dev/null || lacks npm npm
    # elsewhere the tests that need a browser are skipped
    if command -v apt-get >/dev/null && ! command -v chromium >/dev/null && ! command -v google-chrome >/dev/null; then
        lacks chromium chromium
    fi
fi
[ -n "$missing" ] || exit 0

if ! command -v apt-get >/dev/null; then
    echo "Missing:$names. Install the packages of your system that hold these, then try again." >&2
    exit 1
fi
if [ "$(id -u)" != 0 ]; then
    echo "Missing:$names. Run this, then try again:" >&2
    echo "  sudo apt-get update && sudo apt-get install -y --no-install-recommends$missing" >&2
    exit 1
fi
echo "Installing what is missing:$missing"
apt-get update -qq
DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends $missing
