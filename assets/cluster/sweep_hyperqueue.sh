#!/bin/sh
# Runs the variants of a sweep as one array job of HyperQueue and merges them. A server and workers must be running, and all
# machines must see the same folders.
#
#   sweep_hyperqueue.sh OUT SCENE --set speed=5..30:26 --set angle=0,15,30
#
# Tasks that are lost with their worker are run again by HyperQueue. The same command again runs what is missing: a variant
# that is finished is read from its folder.
#
#   CRUMPLE=path   the program, if it is not in the PATH
set -eu
[ $# -ge 2 ] || { sed -n '2,10p' "$0" >&2; exit 2; }
out=$1
shift
# Workers want the whole path.
program=$(command -v "${CRUMPLE:-crumple}")
variants=$("$program" sweep "$@" --count)
mkdir -p "$out/parts"
hq submit --wait --name crumple --cpus 1 --array "0-$((variants - 1))" --crash-limit 5 \
    --stdout none --stderr "$out/parts/%{TASK_ID}.log" --env "OUT=$out" --env "PROGRAM=$program" -- \
    sh -c 'exec "$PROGRAM" sweep "$@" --quiet --jobs 1 --only "$HQ_TASK_ID" --out "$OUT/parts/$HQ_TASK_ID"' sh "$@" ||
    echo "some tasks have failed, see $out/parts/*.log" >&2
exec "$program" merge "$out"/parts/*/ --out "$out"
