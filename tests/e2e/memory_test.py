# SPDX-License-Identifier: Apache-2.0
"""Short memory: a job that lacks it fails and says so, and the next make gives what it always gives."""
import resource
import subprocess

from nightly import some_of
from workspace import BUILD, REPOSITORY, CopiedSiteTest, environment

# From less than the libraries take to more than the job takes.
LIMITS_MB = some_of(range(70, 270, 6), one_in=4)


class MemoryTest(CopiedSiteTest):
    def run_limited(self, command, limit_mb):
        size = limit_mb * 2**20
        return subprocess.run(list(map(str, command)), cwd=self.work.folder, env=environment(), text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (size, size)))

    def outcomes(self, stage, ports, outputs):
        """Runs a job of the site with less and more memory; -> whether each run succeeded."""
        site = self.work.path("")
        command = [REPOSITORY / "scripts/run_job.sh", site, stage, BUILD / "bin" / stage, "--threads", 2,
                   "--config", site / f"config/{stage}.toml"]
        for port in ports:
            command += ["--in", port]
        for name, path in outputs.items():
            command += ["--out", f"{name}={site / path}"]
        for limit_mb in LIMITS_MB:
            for path in outputs.values():
                (site / path).unlink(missing_ok=True)
            result = self.run_limited(command, limit_mb)
            with self.subTest(stage, limit_mb=limit_mb):
                if result.returncode == 0:
                    self.assertEqual(self.work.hashes(), self.hashes, result.stdout)
                else:
                    self.assertRegex(result.stdout, "out of memory|given no memory")
                    self.assertIn("THREADS=1", result.stdout)
                    self.assertFalse([path for path in outputs.values() if (site / path).exists()])
            yield result.returncode == 0

    def check_job(self, stage, ports, outputs):
        outcomes = list(self.outcomes(stage, ports, outputs))
        self.assertFalse(outcomes[0])
        self.assertTrue(outcomes[-1])

    def test_no_keyframe_of_a_tile_is_lost(self):
        tiles = self.work.path("tiles")
        ports = [f"tile={tiles}/tile_0_0.json", f"cameras={tiles}/cameras.json", "data=data"]
        self.check_job("point_cloud", ports, {"tile_cloud": "point_cloud/tile_0_0.ply", "places": "point_cloud/places_0_0.csv",
                                              "report": "point_cloud/report_0_0.json"})

    def test_no_frame_of_a_shard_is_lost(self):
        frames = self.work.path("frames")
        ports = [f"frames={frames}/shard_0000.csv", f"cameras={frames}/cameras.json", "data=data"]
        self.check_job("features", ports, {"features": "features/shard_0000.h5",
                                           "report": "features/report_0000.json"})

    def test_the_make_after_one_with_short_memory_gives_the_map(self):
        for limit_mb in some_of((100, 130, 160, 300), one_in=2):
            with self.subTest(limit_mb=limit_mb):
                for job in ("features", "point_cloud"):
                    for path in self.work.path(job).iterdir():
                        path.unlink()
                limited = self.run_limited(self.work.command("map"), limit_mb)
                if limited.returncode != 0:
                    self.assertRegex(limited.stdout, "memory")
                    self.assertNotIn("Traceback", limited.stdout)
                self.work.output("map")
                hashes = self.work.hashes()  # with those of localize, which the report of the failed run asked for
                self.assertEqual({name: hashes.get(name) for name in self.hashes}, self.hashes)
