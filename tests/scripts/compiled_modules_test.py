# SPDX-License-Identifier: Apache-2.0
"""Compiled modules of the scripts where there is no room for them: whole or none, so that a later run can start."""
import marshal
import pathlib
import shutil
import subprocess
import sys

from folder_case import FolderTest


SCRIPTS = pathlib.Path(__file__).resolve().parents[2] / "scripts"
HEADER_BYTES = 16
IMPORT = "import sys; sys.path.insert(0, 'scripts'); import "


class CompiledModulesTest(FolderTest):
    def setUp(self):
        shutil.copytree(SCRIPTS, self.folder / "scripts", ignore=shutil.ignore_patterns("__pycache__"))

    def run_python(self, code, limit="unlimited"):
        command = ["bash", "-c", f'ulimit -f {limit}; exec "$@"', "bash", sys.executable, "-I", "-c", code]
        result = subprocess.run(command, cwd=self.folder, capture_output=True, text=True)
        self.assertEqual((result.returncode, result.stderr), (0, ""))

    def compiled(self):
        return {path.stem.split(".")[0]: path for path in self.folder.rglob("*.pyc*")}

    def check_whole(self):
        for path in self.compiled().values():
            marshal.loads(path.read_bytes()[HEADER_BYTES:])

    def test_no_room(self):
        for first in ("nightmap_site.unit_lists", "nightmap_make.site_state", "nightmap_eval.html"):
            for limit_kb in (0, 4, 8, 16):
                with self.subTest(first, limit_kb=limit_kb):
                    for folder in self.folder.rglob("__pycache__"):
                        shutil.rmtree(folder)
                    code = f"{IMPORT}{first}, nightmap_make.make_run, nightmap_eval.artifacts"
                    self.run_python(code, limit_kb)
                    self.check_whole()
                    self.assertEqual("journal" in self.compiled(), limit_kb >= 8)
                    self.assertNotIn("rules_file", self.compiled())
                    self.run_python(code)
                    self.check_whole()
                    self.assertIn("rules_file", self.compiled())
                    self.assertEqual([path for path in self.folder.rglob("*.pyc.*")], [])
