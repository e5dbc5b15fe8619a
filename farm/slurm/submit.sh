#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Bakes PRT Relight's transport on a Slurm cluster: an array of shards, then a merge that waits for all of them.
#
#   farm/slurm/submit.sh FILE.blend OUTPUT.blend SHARDS [SBATCH OPTIONS...]
#
# FILE.blend is baked as it was saved, with its settings and its selection, and stays as it is. SHARDS is how many tasks share the
# rays. All options after that are sbatch's, for shards and merge alike: --cpus-per-task=16 --mem=8G --partition=...
#
# PRT_BLENDER   the Blender that the nodes run, with the extension installed: "blender" if it is not set
# PRT_SHARDS    a folder that all nodes see: OUTPUT.shards if it is not set
# PRT_SETTINGS  what shall differ from the file, such as "samples=1024, bounces=5"
#
# Prints the numbers of the two jobs. Logs lie in the folder of shards.
set -eu
[ $# -ge 3 ] || { sed -n '5p' "$0" | cut -c5- >&2; exit 2; }
here=$(dirname "$(realpath "$0")")
PRT_BLEND=$(realpath "$1")
PRT_OUTPUT=$(realpath -m "$2")
shards=$3
shift 3
[ -f "$PRT_BLEND" ] || { echo "There is no file '$PRT_BLEND'." >&2; exit 2; }
[ "$PRT_BLEND" != "$PRT_OUTPUT" ] || { echo "The output must be another file than the one that is baked." >&2; exit 2; }
case $shards in '' | *[!0-9]* | 0) echo "SHARDS must be 1 or more, not '$shards'." >&2; exit 2 ;; esac
PRT_BLENDER=${PRT_BLENDER:-blender}
PRT_SHARDS=$(realpath -m "${PRT_SHARDS:-$PRT_OUTPUT.shards}")
PRT_SETTINGS=${PRT_SETTINGS:-}
export PRT_BLEND PRT_OUTPUT PRT_BLENDER PRT_SHARDS PRT_SETTINGS
mkdir -p "$PRT_SHARDS"

array=$(sbatch --parsable --export=ALL --array="0-$((shards - 1))" --output="$PRT_SHARDS/shard-%a.log" "$@" "$here/shard.sbatch")
merge=$(sbatch --parsable --export=ALL --dependency="afterok:$array" --kill-on-invalid-dep=yes \
    --output="$PRT_SHARDS/merge.log" "$@" "$here/merge.sbatch")
echo "$array $merge"
