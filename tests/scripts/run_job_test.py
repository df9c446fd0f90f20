# SPDX-License-Identifier: Apache-2.0
"""run_job.sh says what a program cannot say itself: that it was short of memory."""
import pathlib
import subprocess

from folder_case import FolderTest


RUN_JOB = pathlib.Path(__file__).resolve().parents[2] / "scripts/run_job.sh"
LOADER = "echo a: error while loading shared libraries: b.so: failed to map segment from shared object; exit 127"
MISSING = "echo a: error while loading shared libraries: b.so: cannot open shared object file: No such file; exit 127"


class RunJobTest(FolderTest):
    def setUp(self):
        self.logs = self.folder / "logs"
        self.logs.mkdir()

    def run_job(self, command, limit="true"):
        job = ["bash", "-c", f'{limit}; "$@"', "bash", RUN_JOB, self.logs.parent, "stage", "bash", "-c", command]
        result = subprocess.run(job, capture_output=True, text=True)
        lines = (self.logs / "stage.log").read_text().splitlines()
        self.assertEqual(lines[-1], f"nightmap: stage failed, exit code {result.returncode}")  # the report reads the last line
        self.assertEqual((self.logs / "journal.txt").read_text().split()[-1], str(result.returncode))
        return result.returncode, result.stderr

    def check_says_memory(self, command, code, text, limit="true"):
        returncode, messages = self.run_job(command, limit)
        self.assertEqual(returncode, code)
        self.assertIn(f"nightmap: stage: {text}", messages)
        self.assertIn("THREADS=1", messages)

    def test_a_program_without_memory_for_its_libraries(self):
        self.check_says_memory(LOADER, 127, "out of memory")

    def test_a_library_that_memory_ends(self):
        self.check_says_memory("echo 'what():  std::bad_alloc'; exit 134", 134, "out of memory")
        self.check_says_memory("echo 'what():  Resource temporarily unavailable'; exit 134", 134, "out of memory")
        self.check_says_memory("exit 139", 139, "ended by signal 11", "ulimit -v 4000000")

    def test_a_program_that_the_kernel_kills(self):
        self.check_says_memory("kill -9 $$", 137, "killed by signal 9, as the kernel does where memory runs out")

    def test_other_failures_are_not_called_memory(self):
        for command in ("exit 1", "exit 2", "exit 127", MISSING, "exit 134", "exit 139"):
            with self.subTest(command):
                self.assertNotIn("memory", self.run_job(command)[1])
