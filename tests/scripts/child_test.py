# SPDX-License-Identifier: Apache-2.0
"""request.Child: a signal to make ends the program that it runs, whenever it comes, and no other is started."""

import os
import signal
import subprocess
import sys
import unittest

import fake_site  # noqa: F401  (finds the scripts)
from nightmap_make.child import PASSED_ON, Child

SIGTERM_CODE = -signal.SIGTERM & 0xff
# Runs programs until a signal comes; prints the codes.
LOOP = "from nightmap_make.child import Child\nimport os\nchild = Child()\nchild.pass_signals_on()\nprint('begun', flush=True)\ncode = 0\n" \
       "while code == 0:\n    code = child.run(['true'], os.environ)\nprint(code)\n"


class ChildTest(unittest.TestCase):
    def setUp(self):
        for number in PASSED_ON:
            self.addCleanup(signal.signal, number, signal.getsignal(number))
        self.child = Child()
        self.child.pass_signals_on()

    def run_shell(self, text):
        return self.child.run(["sh", "-c", text], os.environ)

    def test_exit_codes(self):
        self.assertEqual([self.run_shell(f"exit {code}") for code in (0, 1, 3)], [0, 1, 3])
        self.assertEqual(self.run_shell("kill -KILL $$"), -signal.SIGKILL & 0xff)

    def test_a_signal_ends_what_runs_and_nothing_follows(self):
        for number in PASSED_ON:
            with self.subTest(number):
                self.child = Child()
                self.child.pass_signals_on()
                self.assertEqual(self.run_shell(f"kill -{number} {os.getpid()}; exec sleep 60"), -number & 0xff)
                self.assertEqual(self.run_shell("exit 0"), -number & 0xff)

    def test_a_signal_between_two_programs_is_remembered(self):
        self.assertEqual(self.run_shell("exit 0"), 0)
        os.kill(os.getpid(), signal.SIGTERM)
        self.assertEqual(self.run_shell("exit 0"), SIGTERM_CODE)

    def test_a_program_gets_signals_that_were_blocked_at_its_start(self):
        self.assertEqual(self.run_shell("kill -TERM $$; exit 0"), SIGTERM_CODE)

    def test_at_any_moment(self):
        """Programs start and end hundreds of times a second, so that many signals come while one ends."""
        for delay_s in [0.001 * k for k in range(40)]:
            process = subprocess.Popen([sys.executable, "-c", LOOP], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                       env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)})  # fmt: skip
            process.stdout.readline()
            try:
                process.wait(delay_s)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGTERM)
            said, _ = process.communicate(timeout=60)
            self.assertEqual((said, process.returncode), (f"{SIGTERM_CODE}\n", 0))
