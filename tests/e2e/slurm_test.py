# SPDX-License-Identifier: Apache-2.0
"""Sites made on a Slurm cluster of this machine: the same bytes as without one, also when a node is lost in the middle."""
import os
import random
import signal
import subprocess
import time
import unittest

import slurm_cluster
from accuracy import FOLDER, make
from labels_test import use_labels
from workspace import BUILD, LASER_SITE, REPOSITORY, SITE, Workspace, artifact_hashes, environment, write_laser_site

ALLOCATED = ("salloc", "--quiet", "--nodes=2", "--exclusive", "--mem=0", "--no-kill")
LAUNCH = ("LAUNCH=scripts/on_slurm.sh", "THREADS=2")
WAIT_S = 600  # a loaded machine is slow


def setUpModule():
    missing = slurm_cluster.missing_programs()
    if missing and os.environ.get("CI") != "true":
        raise unittest.SkipTest(f"needs {', '.join(missing)}: run scripts/install_deps.sh tests")


class SlurmTest(unittest.TestCase):
    def setUp(self):
        self.cluster = slurm_cluster.Cluster()
        self.addCleanup(self.cluster.stop)

    def begin(self, folder, *arguments, allocated=ALLOCATED):
        """Begins a make in an allocation of both nodes that outlives one of them, or in none."""
        command = [*allocated, "make", "--no-print-directory", "-j4", *LAUNCH, *arguments]
        return subprocess.Popen(command, cwd=folder, env=environment() | self.cluster.environment, text=True, start_new_session=True,
                                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)  # fmt: skip

    def end(self, process, code=0):
        said, _ = process.communicate()
        self.assertEqual(process.returncode, code, said[-8000:])
        return said

    def journal(self, site_dir):
        path = site_dir / "logs/journal.txt"
        return path.read_text().splitlines() if path.exists() else []

    def wait_for(self, condition, process):
        until = time.monotonic() + WAIT_S
        while not condition():
            if process.poll() is not None or time.monotonic() > until:
                self.fail(f"never: {process.communicate()[0][-8000:] if process.poll() is not None else 'in time'}")
            time.sleep(0.05)


class LostNodeTest(SlurmTest):
    def working_nodes(self, site_dir):
        """Nodes on which programs run: their files say `on NODE`, and no exit code yet."""
        texts = []
        for path in (site_dir / "logs").glob("*.ended.*"):
            try:
                texts.append(path.read_text())
            except FileNotFoundError:  # the program has ended
                continue
        return sorted({text.split()[1] for text in texts if len(text.split()) == 2})

    def test_the_demo_is_the_same_when_a_node_is_lost_at_a_random_moment(self):
        local = make("demo", FOLDER / "data", "map", "localize")  # the folder of demo_test, which also plans in it
        maps = Workspace().removed_after(self).folder / "maps"
        num_jobs = sum(path.parent.name not in ("plan", "drive") for path in local.glob("*/receipt*.json"))  # each begins and ends
        process = self.begin(REPOSITORY, "SITE=demo", f"DATA={FOLDER}/data", f"MAPS={maps}", f"BUILD={BUILD}", "map", "localize")
        after = random.randrange(8, 2 * num_jobs - 8)
        with self.subTest(after_events=after):
            self.wait_for(lambda: len(self.journal(maps / "demo")) > after and self.working_nodes(maps / "demo"), process)
            self.cluster.lose(random.choice(self.working_nodes(maps / "demo") or slurm_cluster.NODES))
            self.end(process)
            expected = {name: one for name, one in artifact_hashes(local).items() if not name.startswith(("plan/", "drive/"))}
            self.assertEqual(artifact_hashes(maps / "demo"), expected)
            self.assertEqual(list((maps / "demo/logs").glob("*.ended*")), [])


class InterruptedTest(SlurmTest):
    def test_ctrl_c_cancels_the_jobs_and_the_next_make_goes_on(self):
        work = Workspace.made("map").removed_after(self)
        before, journal = work.hashes(), work.folder / "cluster" / SITE
        words = (f"SITE={SITE}", "MAPS=cluster", "map")
        process = self.begin(work.folder, *words, allocated=())  # each program a job of its own
        self.wait_for(lambda: len(self.journal(journal)) > 12, process)
        os.killpg(process.pid, signal.SIGINT)
        process.communicate(timeout=WAIT_S)
        self.assertNotEqual(process.returncode, 0)
        self.wait_for_no_job()
        self.assertEqual(list((journal / "logs").glob("*.ended*")), [])
        self.end(self.begin(work.folder, *words, allocated=()))
        self.assertEqual(artifact_hashes(work.folder / "cluster" / SITE), before)

    def test_a_signal_to_make_alone_cancels_the_jobs(self):
        work = Workspace.made("map").removed_after(self)
        journal = work.folder / "cluster" / SITE
        process = self.begin(work.folder, f"SITE={SITE}", "MAPS=cluster", "map", allocated=())
        self.wait_for(lambda: len(self.journal(journal)) > 12, process)
        os.kill(process.pid, signal.SIGTERM)
        process.communicate(timeout=WAIT_S)
        self.wait_for_no_job()

    def wait_for_no_job(self):
        until = time.monotonic() + WAIT_S
        while said := subprocess.run(["squeue", "--noheader"], env=environment() | self.cluster.environment, text=True,
                                     capture_output=True).stdout.strip():
            self.assertLess(time.monotonic(), until, said)
            time.sleep(0.2)


class ProfilesTest(SlurmTest):
    """Small sites of other profiles."""

    def check(self, work, site, *arguments):
        local = work.output(f"SITE={site}", *arguments)
        self.assertIn(f"map of {site}", local)
        before = work.hashes(site)
        self.end(self.begin(work.folder, f"SITE={site}", "MAPS=cluster", *arguments))
        self.assertEqual(artifact_hashes(work.folder / "cluster" / site), before)

    def test_laser(self):
        work = Workspace().removed_after(self)
        write_laser_site(work.folder)
        self.check(work, LASER_SITE, "map")

    def test_labels(self):
        work = Workspace().removed_after(self)
        use_labels(work)
        self.check(work, SITE, "map")

    def test_ceiling(self):
        self.check(Workspace().removed_after(self), "ceiling_office", "map", "SET=synthesize_ceiling.duration_s=20")
