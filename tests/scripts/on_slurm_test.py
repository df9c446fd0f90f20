# SPDX-License-Identifier: Apache-2.0
"""on_slurm.sh with an srun that does what a test says: runs the program, loses its node, or has it killed."""

import os
import signal
import subprocess
import time

from fake_site import CHECKOUT
from folder_case import FolderTest

# Takes a word of the file `fate` per call: run, lost (nothing runs; srun itself ends with 0, as that of Slurm 22.05 does), begun (the node
# is lost while the program runs), killed.
SRUN = """#!/usr/bin/env bash
echo "$@" >>"$FOLDER/asked"
read -r fate <"$FOLDER/fate"; sed -i 1d "$FOLDER/fate"
while [[ $1 == -* ]]; do shift; done
export SLURMD_NODENAME=n7
case $fate in
  lost) exit 0 ;;
  begun) "${@:1:4}" "$5" true >/dev/null; sed -i '$d' "$5"; exit 1 ;;
  killed) set -- "${@:1:5}" bash -c 'kill -9 $$' ;;
esac
exec "$@"
"""


class OnSlurmTest(FolderTest):
    def setUp(self):
        self.write("bin/srun", SRUN).chmod(0o755)
        self.write("bin/sleep", "#!/bin/sh\n").chmod(0o755)
        self.write("site/lists/needs.txt", "cloud 1 700 0\ncloud_join 2 800 30\n")
        (self.folder / "site/logs").mkdir()
        self.environment = os.environ | {
            "PATH": f"{self.folder / 'bin'}:{os.environ['PATH']}", "FOLDER": str(self.folder), "THREADS": "4",
            "NIGHTMAP_SITE_DIR": str(self.folder / "site"), "NIGHTMAP_RULE": "cloud_0000"}  # fmt: skip

    def command(self, *program):
        return ["bash", str(CHECKOUT / "scripts/on_slurm.sh"), *program]

    def launch(self, *fates, program=("sh", "-c", "echo made; exit 3"), rule="cloud_0000"):
        """The result of a program under these fates, one per attempt, and the options that srun got."""
        self.write("fate", "".join(f"{fate}\n" for fate in fates))
        (self.folder / "asked").unlink(missing_ok=True)
        result = subprocess.run(self.command(*program), env=self.environment | {"NIGHTMAP_RULE": rule}, capture_output=True, text=True)
        self.assertEqual(list((self.folder / "site/logs").iterdir()), [])
        return result, (self.folder / "asked").read_text().splitlines()

    def test_a_program_that_ends_is_not_run_again(self):
        result, asked = self.launch("run")
        self.assertEqual((result.returncode, result.stdout, len(asked)), (3, "made\n", 1))
        self.assertEqual(self.launch("run", program=["true"])[0].returncode, 0)

    def test_the_needs_are_those_of_the_job(self):
        for rule, cores, memory_mb in (("cloud_0000", 1, 700), ("cloud_join", 2, 800), ("cloud_join_1", 2, 800), ("other", 4, 4000)):
            _, [asked] = self.launch("run", rule=rule)
            self.assertIn(f"--cpus-per-task={cores} --mem={memory_mb} ", asked)
            self.assertEqual("--time=30" in asked, cores == 2)
            self.assertNotIn("--exact", asked)
        self.environment["SLURM_JOB_ID"] = "5"
        self.assertIn("--exact", self.launch("run")[1][0])

    def test_a_lost_node_begins_the_program_again(self):
        for fate in ("lost", "begun"):
            result, asked = self.launch(fate, "run", rule="cloud_join")
            self.assertEqual((result.returncode, result.stdout, len(asked)), (3, "made\n", 2))
            self.assertIn("attempt 2 of 3", result.stderr)
            self.assertIn("--time=60", asked[1])
        self.assertIn("lost its node n7", result.stderr)

    def test_three_lost_nodes_are_an_error(self):
        result, asked = self.launch("lost", "begun", "lost")
        self.assertEqual((result.returncode, len(asked)), (1, 3))
        self.assertIn("cloud_0000: Slurm ended it, or lost its node", result.stderr)
        self.assertIn("3 times: sinfo shows", result.stderr)

    def test_a_killed_program_gets_more_memory(self):
        result, asked = self.launch("killed", "run")
        self.assertEqual((result.returncode, result.stdout), (3, "made\n"))
        self.assertIn("--mem=1400 ", asked[1])
        self.assertEqual(self.launch("killed", "killed", "killed")[0].returncode, 137)

    def test_a_signal_cancels_the_step(self):
        for number, code in ((signal.SIGTERM, 143), (signal.SIGINT, 130)):
            self.write("fate", "run\nrun\n")
            self.write("asked", "")
            process = subprocess.Popen(self.command("/bin/sleep", "60"), env=self.environment)
            while not any(path.read_text() for path in (self.folder / "site/logs").glob("*.ended.*")):
                time.sleep(0.01)
            process.send_signal(number)
            self.assertEqual(process.wait(timeout=20), code)
            self.assertEqual(len((self.folder / "asked").read_text().splitlines()), 1)
            self.assertEqual(list((self.folder / "site/logs").iterdir()), [])
