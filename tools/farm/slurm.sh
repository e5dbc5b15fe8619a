#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# A Slurm of one machine, from Debian's packages and without systemd, for as long as a command runs. As root.
#
#   tools/farm/slurm.sh COMMAND...
set -eu
for program in munged slurmctld slurmd sbatch; do
    command -v $program >/dev/null || { apt-get update -q && apt-get install -qy --no-install-recommends munge slurm-wlm; break; }
done
state=$(mktemp -d)
host=$(hostname -s)
export SLURM_CONF="$state/slurm.conf"
cat >"$SLURM_CONF" <<CONF
ClusterName=prt
SlurmctldHost=$host(127.0.0.1)
AuthType=auth/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation=$state/state
SlurmdSpoolDir=$state/spool
SlurmctldPidFile=$state/slurmctld.pid
SlurmdPidFile=$state/slurmd.pid
SlurmctldLogFile=$state/slurmctld.log
SlurmdLogFile=$state/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
JobRequeue=1
MailProg=/bin/true
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=farm Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
mkdir -p "$state/state" "$state/spool" /run/munge
chown munge:munge /run/munge
stop() {
    for daemon in slurmd slurmctld; do [ -f "$state/$daemon.pid" ] && kill "$(cat "$state/$daemon.pid")" || true; done
    [ -f /run/munge/munged.pid ] && kill "$(cat /run/munge/munged.pid)" || true
    sleep 1
    rm -rf "$state"
}
trap stop EXIT
[ -f /etc/munge/munge.key ] || mungekey --create
su -s /bin/sh munge -c "munged --force"
slurmctld
slurmd
for _ in $(seq 30); do sinfo -h -o %T | grep -q idle && break; sleep 1; done
sinfo
"$@"
