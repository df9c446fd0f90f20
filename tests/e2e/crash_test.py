# SPDX-License-Identifier: Apache-2.0
"""Power cuts and full disks: whatever moment a run dies at, the next one gives the same bytes."""
import contextlib
import json
import os
import shutil
import signal
import subprocess
import tempfile

from nightly import some_of
from signal_at_write import SignalAtWrite
from workspace import BUILD, GOALS, SITE, CopiedSiteTest, environment

NUM_KILLS = 6
MIN_TMPFS_BYTES = 200 * 1024


class CrashTest(CopiedSiteTest):
    made = GOALS

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        receipts = (cls.base.folder / "maps" / SITE).glob("*/receipt*.json")
        cls.duration_s = sum(json.loads(path.read_text())["wall_time_s"] for path in receipts)
        cls.signals = SignalAtWrite()
        cls.addClassCleanup(cls.signals.remove)

    def kill_after(self, time_s):
        """Starts make and kills it and all it started; True when it was alive to be killed."""
        process = subprocess.Popen(self.work.command(*GOALS), cwd=self.work.folder, env=environment(),
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                   start_new_session=True)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(time_s)
        alive = process.poll() is None
        if alive:
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        return alive

    def check_whole_artifacts(self):
        """A file that a killed run leaves under a final name is the whole file or nothing."""
        for name, digest in self.work.hashes().items():
            if "/.writing." not in "/" + name:
                self.assertEqual(digest, self.hashes[name], name)

    def check_resumed(self):
        self.work.output(*GOALS)
        self.assertEqual(self.work.hashes(), self.hashes)  # so that no temporary is left either
        self.assertEqual(self.work.make("-q", *GOALS).returncode, 0)

    def test_killed_at_moments_all_over_a_run(self):
        self.work.make("clean")
        num_killed = 0
        for index in range(NUM_KILLS):
            num_killed += self.kill_after(self.duration_s * (index + 1) / (2 * NUM_KILLS))
            self.check_whole_artifacts()
        self.assertGreater(num_killed, 0)
        self.check_resumed()

    def kill_in_mid_write(self, folder):
        """Kills the stage of a folder while a file there is half written."""
        for path in folder.glob("*.*"):
            shutil.rmtree(path) if path.is_dir() else path.unlink()
        self.signals.kill(self.work.command(*GOALS), self.work.folder, f"/{folder.name}/.writing.")
        self.assertTrue(any(folder.glob(".writing.*/*")))

    def test_killed_while_a_stage_writes(self):
        for stage in some_of(("features", "pose_graph", "adjust", "point_cloud", "octree"), one_in=3):
            with self.subTest(stage):
                self.kill_in_mid_write(self.work.path(stage))
                self.check_whole_artifacts()
                self.check_resumed()

    def test_a_run_leaves_the_temporaries_of_another_that_is_alive(self):
        stage = self.work.path("grid")
        site = f"maps/{SITE}"
        command = [BUILD / "bin" / "grid", "--config", f"{site}/config/grid.toml", "--in", f"octree={site}/octree/map.ot",
                   "--in", f"keyframes={site}/map_frame/keyframes.tum"]
        for name in ("floors=floors.json", "pgm=map.pgm", "yaml=map.yaml", "png=map.png",
                     "distances=distances.h5", "report=report.json", "receipt=receipt.json"):
            command += ["--out", name.replace("=", f"={site}/grid/")]
        stopped = subprocess.Popen(command, cwd=self.work.folder, stderr=subprocess.DEVNULL,
                                   env=self.signals.environment("/grid/.writing.", signal.SIGSTOP))
        self.assertTrue(os.WIFSTOPPED(os.waitpid(stopped.pid, os.WUNTRACED)[1]), "the stage ended before it was stopped")
        left = {path: path.read_bytes() for path in stage.glob(".writing.*/*")}
        self.assertTrue(left)
        other = subprocess.run(command, cwd=self.work.folder, capture_output=True, text=True)
        self.assertEqual(other.returncode, 0, other.stderr)
        self.assertEqual({path: path.read_bytes() for path in stage.glob(".writing.*/*")}, left)
        stopped.send_signal(signal.SIGCONT)
        self.assertEqual(stopped.wait(), 0)
        self.check_resumed()
        self.work.output("verify")

    def test_killed_between_two_renames_of_a_commit(self):
        # The state such a kill leaves: an output of a later run beside the receipt of the one before.
        artifact = self.work.path("octree/map.ot")
        artifact.write_bytes(artifact.read_bytes()[:100])
        self.check_resumed()

    def test_full_disk(self):
        for stage in some_of(("octree", "features"), one_in=2):
            with self.subTest(stage):
                folder = self.work.path(stage)
                for path in folder.iterdir():
                    path.unlink()
                mount = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={MIN_TMPFS_BYTES}", "tmpfs",
                                        folder], capture_output=True, text=True)
                if mount.returncode != 0:
                    self.skipTest(f"needs root to mount a small tmpfs: {mount.stderr.strip()}")
                try:
                    result = self.work.make(*GOALS)
                    self.assertNotEqual(result.returncode, 0)
                    self.assertRegex(result.stdout, "[Nn]o space left|free space|cannot write")
                    for path in folder.iterdir():
                        self.assertIn(path.name, {"report_0000.json", "receipt_0000.json", "shard_0000.h5"}
                                      if stage == "features" else
                                      {"report_0_0.json", "receipt_0_0.json", "tile_0_0.ot"})
                finally:
                    subprocess.run(["umount", folder], check=True)
                self.check_resumed()

    def test_read_only_recordings(self):
        read_only = tempfile.mkdtemp(prefix="nightmap-e2e-")
        mount = subprocess.run(["mount", "--bind", "-o", "ro", self.work.folder / "data", read_only],
                               capture_output=True, text=True)
        self.addCleanup(os.rmdir, read_only)
        if mount.returncode != 0:
            self.skipTest(f"needs root to mount read-only: {mount.stderr.strip()}")
        self.addCleanup(subprocess.run, ["umount", read_only])
        self.work.make("clean")
        self.work.output(*GOALS, f"DATA={read_only}", f"SITE={SITE}")
