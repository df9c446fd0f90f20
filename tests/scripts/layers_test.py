# SPDX-License-Identifier: Apache-2.0
"""Layers of the scripts: nightmap_make and nightmap_eval stand on nightmap_site and know nothing of each other."""
import ast
import pathlib
import unittest

SCRIPTS = pathlib.Path(__file__).resolve().parents[2] / "scripts"
NEVER_BEFORE_MAKE = {"numpy", "h5py", "matplotlib", "PIL"}  # slow imports, and every start of make waits for its own


def imports_of(path):
    """Names of the modules that a file imports, anywhere in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def file_of(module):
    """The module's file, or that of the package; None when it is none of the scripts."""
    path = SCRIPTS / module.replace(".", "/")
    return next((file for file in (path.with_suffix(".py"), path / "__init__.py") if file.is_file()), None)


def reached_from(package):
    """Top names of all modules that a package imports, and the scripts that it imports, with what they import."""
    names, files, waiting = set(), set(), sorted((SCRIPTS / package).rglob("*.py"))
    while waiting:
        file = waiting.pop()
        if file in files:
            continue
        files.add(file)
        for module in imports_of(file):
            names.add(module.partition(".")[0])
            waiting += [found for found in [file_of(module)] if found]
    return names - {package}


class LayersTest(unittest.TestCase):
    def test_site_knows_no_other_script(self):
        self.assertEqual([name for name in reached_from("nightmap_site") if file_of(name)], [])

    def test_make_stands_on_site(self):
        reached = reached_from("nightmap_make")
        self.assertIn("nightmap_site", reached)
        self.assertNotIn("nightmap_eval", reached)

    def test_eval_stands_on_site(self):
        self.assertEqual([name for name in reached_from("nightmap_eval") if file_of(name)], ["nightmap_site"])

    def test_wings_know_the_verdict_the_page_and_what_all_share(self):
        wings = {path.name for path in (SCRIPTS / "nightmap_eval").iterdir() if any(path.glob("*.py"))}
        self.assertLessEqual({"camera", "labels", "laser", "verdict"}, wings)
        for path in (SCRIPTS / "nightmap_eval").rglob("*.py"):
            used = {module.split(".")[1] for module in imports_of(path) if module.startswith("nightmap_eval.")} & wings
            self.assertLessEqual(used, {path.parent.name, "verdict", "page"}, path.relative_to(SCRIPTS))

    def test_make_starts_fast(self):
        self.assertEqual(NEVER_BEFORE_MAKE & reached_from("nightmap_make"), set())
