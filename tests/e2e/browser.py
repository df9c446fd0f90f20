# SPDX-License-Identifier: Apache-2.0
"""A page as a browser shows it: opened by headless Chromium, without network."""
import os
import re
import shutil
import subprocess
import tempfile
from html.parser import HTMLParser

WEBGL = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")  # in software
CONSOLE = re.compile(r":CONSOLE[:(]|net::ERR_")  # what a page says in the log of Chromium


class _Shown(HTMLParser):
    def __init__(self):
        super().__init__()
        self.parts, self.hidden = [], 0

    def handle_starttag(self, tag, _):
        self.hidden += tag in ("style", "script")

    def handle_endtag(self, tag):
        self.hidden -= tag in ("style", "script")

    def handle_data(self, data):
        if not self.hidden:
            self.parts.append(data)


def program_of(test):
    """Path of the browser. The test is skipped where there is none, and fails in CI."""
    program = shutil.which("chromium")
    if program is None:
        if os.environ.get("CI") == "true":
            test.fail("no chromium: run scripts/install_deps.sh")
        test.skipTest("no chromium: run scripts/install_deps.sh")
    return program


def shown_text(test, page):
    """Text of the rendered page. The test fails when the page has an error, and is skipped where there is no browser."""
    program = program_of(test)
    with tempfile.TemporaryDirectory(prefix="nightmap-e2e-") as profile:
        command = [program, "--headless", "--no-sandbox", *WEBGL, "--enable-logging=stderr",
                   f"--user-data-dir={profile}", "--dump-dom", page.resolve().as_uri()]  # fmt: skip
        result = subprocess.run(command, capture_output=True, text=True, timeout=120)
    test.assertEqual(result.returncode, 0, result.stderr)
    test.assertEqual([line for line in result.stderr.splitlines() if CONSOLE.search(line)], [])
    parser = _Shown()
    parser.feed(result.stdout)
    return "\n".join(parser.parts)
