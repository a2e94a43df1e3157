"""Frames of a scene by HyperQueue: a task for each shard, one core each, then `gobo verify`.

python3 hyperqueue_job.py GOBO SCENE OUT FRAMES SHARDS [gobo's options]...

Asks the server of `hq server start` that HQ_SERVER_DIR names, whose workers are started by
`hq worker start` or from Slurm and PBS; without it, two workers on this machine. Shards that fail are submitted
again, twice at most: frames that are whole are left.
"""

import os
import subprocess
import sys
import tempfile
from contextlib import ExitStack
from pathlib import Path

from hyperqueue import Client, Job, LocalCluster
from hyperqueue.cluster import WorkerConfig

ATTEMPTS = 3


def main(gobo, scene, out, frames, shards, *options):
    gobo, scene, out = (str(Path(path).resolve()) for path in (gobo, scene, out))
    with ExitStack() as stack:
        folder = os.environ.get("HQ_SERVER_DIR")
        if folder:
            client = Client(folder)
        else:
            folder = stack.enter_context(tempfile.TemporaryDirectory())
            cluster = stack.enter_context(LocalCluster(folder))
            for _ in range(2):
                cluster.start_worker(WorkerConfig(cores=1))
            client = cluster.client()
        for _ in range(ATTEMPTS):
            job = Job(max_fails=None)
            for shard in range(int(shards)):
                job.program(
                    [gobo, "render", scene, "-o", out, "--frames", frames]
                    + ["--shard", f"{shard}/{shards}", "--skip-existing", *options],
                    cwd=str(Path.cwd()),
                    stdout=f"{out}.{shard}.log",
                    stderr=f"{out}.{shard}.log",
                )
            if client.wait_for_jobs([client.submit(job)], raise_on_error=False):
                break
    return subprocess.run([gobo, "verify", out], check=False).returncode


sys.exit(main(*sys.argv[1:]))
