#!/bin/sh
# Runs the variants of a sweep one by one with GNU parallel and merges them.
#
#   sweep_parallel.sh OUT SCENE --set speed=5..30:26 --set angle=0,15,30
#
# A job that dies is run again, three times in all; after a break the same command goes on where it was. Every variant has
# a folder of its own below OUT/parts, so that nothing is written by two.
#
#   CRUMPLE=path   the program, if it is not in the PATH
#   HOSTS=8/a,16/b machines and how many run on each at once; they must see the same folders. This machine alone without it.
set -eu
[ $# -ge 2 ] || { sed -n '2,11p' "$0" >&2; exit 2; }
out=$1
shift
program=${CRUMPLE:-crumple}
variants=$("$program" sweep "$@" --count)
mkdir -p "$out/parts"
seq 0 $((variants - 1)) |
    parallel --quote --will-cite --resume-failed --retries 3 --joblog "$out/jobs.log" \
        --sshlogin "${HOSTS:-:}" --workdir "$PWD" \
        "$program" sweep "$@" --quiet --jobs 1 --only {} --out "$out/parts/{}"
exec "$program" merge "$out"/parts/* --out "$out"
