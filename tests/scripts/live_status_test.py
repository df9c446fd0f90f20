# SPDX-License-Identifier: Apache-2.0
"""live_status.py and the lock: what a make says of another that goes on."""

import json
from types import SimpleNamespace

from folder_case import FolderTest
from nightmap_make import live_status
from nightmap_make.journal import last_run
from nightmap_make.lock import SiteLock, is_held


class LiveStatusTest(FolderTest):
    def setUp(self):
        self.write("logs/journal.txt", "1000 make begin map\n1000 frames begin\n1005 frames end 0\n1005 features_0000 begin\n"
                                       "1010 features_0001 begin\n1011 features_0000 end 1\n")  # fmt: skip

    def rule(self, name, job, receipt):
        outputs = (("receipt", str(self.folder / job / receipt)),)
        return SimpleNamespace(name=name, job=SimpleNamespace(name=job, program=job, script=None), outputs=outputs)

    def receipt(self, path, wall_time_s):
        self.write(path, json.dumps({"stage": path.split("/")[0], "wall_time_s": wall_time_s}))

    def lines(self):
        rules = [self.rule(f"features_{unit}", "features", f"receipt_{unit}.json") for unit in ("0001", "0002", "0003")]
        rules.append(self.rule("loops", "loops", "receipt.json"))
        return "\n".join(live_status.lines(str(self.folder), last_run(str(self.folder)), rules, 1030))

    def test_what_is_done_runs_waits_and_failed(self):
        said = self.lines()
        self.assertRegex(said, r"make map goes on since \d\d:\d\d:\d\d, .*: 1 jobs done, 1 run, 3 wait")
        self.assertRegex(said, r"features_0001 +20 s\n")
        self.assertIn("features_0000: failed, exit code 1", said)
        self.assertNotIn("left:", said)

    def test_time_left_is_that_of_earlier_runs_and_of_the_others_of_a_job(self):
        self.receipt("features/receipt_0001.json", 50)
        self.receipt("features/receipt_0002.json", 70)
        self.write("features/receipt_0003.json", "{")
        self.write("logs/features_0001.ended.1", "on n3\n")
        said = self.lines()  # 30 s of 0001, 70 s, and the mean of both
        self.assertRegex(said, r"features_0001 +n3 +20 s of about 50 s\n")
        self.assertIn("left: about 3 min, by earlier runs with 1 jobs at a time, without loops, of which no time is known", said)

    def test_durations(self):
        self.assertEqual([live_status.duration(seconds) for seconds in (3, 99, 200, 7200)], ["3 s", "99 s", "3 min", "2.0 h"])

    def test_the_lock_is_seen_and_names_its_holder(self):
        site = str(self.folder / "site")
        self.assertFalse(is_held(site))
        lock = SiteLock(site)
        self.assertTrue(is_held(site))
        self.assertRegex(live_status.holder(site), r"^\d+ on \S+$")
        lock.release()
        self.assertFalse(is_held(site))
