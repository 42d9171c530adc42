#!/usr/bin/env python3
"""Runs the variants of a sweep on a HyperQueue cluster of this process's own and merges them: for trying, and for one machine.

    pip install hyperqueue
    sweep_hyperqueue.py OUT SCENE --set speed=5..30:26 --set angle=0,15,30

As sweep_hyperqueue.sh does with a server that is running, it gives every variant a task and a folder of its own; the same
command again runs what is missing. CRUMPLE=path is the program, if it is not in the PATH.
"""
import os
import subprocess
import sys
from pathlib import Path

from hyperqueue import Job, LocalCluster


def main(out, *sweep):
    program = os.environ.get("CRUMPLE", "crumple")
    command = [program, "sweep", *sweep]
    count = int(subprocess.run([*command, "--count"], check=True, capture_output=True, text=True).stdout)
    parts = [Path(out, "parts", str(variant)).absolute() for variant in range(count)]
    job = Job()
    for variant, part in enumerate(parts):
        part.mkdir(parents=True, exist_ok=True)
        work = [*command, "--quiet", "--jobs", "1", "--only", str(variant), "--out", str(part)]
        # A task that is lost with its worker is run again.
        job.program(work, cwd=os.getcwd(), stdout=None, stderr=f"{part}.log", crash_limit=5)
    with LocalCluster() as cluster:
        cluster.start_worker()
        client = cluster.client()
        client.wait_for_jobs([client.submit(job)], raise_on_error=False)
    sys.exit(subprocess.run([program, "merge", *map(str, parts), "--out", out]).returncode)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
