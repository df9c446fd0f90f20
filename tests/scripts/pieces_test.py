# SPDX-License-Identifier: Apache-2.0
"""Pipelines that are composed: what a list of pieces brings, what is joined, and what is refused."""

from pathlib import Path


from folder_case import FolderTest
from nightmap_site.declaration import folders, import_keys, profiles
from nightmap_site.pipeline import read_pipeline
from nightmap_site.toml_file import PipelineError


def job(name, more="", **inputs):
    return f'[{name}]\npurpose = "p"\nout.o = "o"\n' + "".join(f'in.{port} = "{text}"\n' for port, text in inputs.items()) + more


FILES = {
    "": "[goals]\nmap = { purpose = \"m\" }\ndraw = { purpose = \"d\" }\n" + job("report", 'script = "r.py"\n'),
    "eye": job("look") + job("see", a="look.o") + "[merge]\nin.eye = \"see.o\"\n",
    "ear": job("listen") + "[merge]\nin.ear = \"listen.o\"\n",
    "graph": job("merge"),
    "draw": job("paint", 'goal = "draw"\n', a="merge.o", b="listen.o if any", c="import.frame if any", d="import.paper else look.o"),
    "default": 'pieces = ["eye", "graph", "draw"]\n',
    "deaf": 'pieces = ["default", "deaf"]\n' + job("rest", a="merge.o") + "[paint]\nkB_per_frame = 3\n",
    "both": 'pieces = ["eye", "ear", "graph", "draw"]\n',
}


class PiecesTest(FolderTest):
    def setUp(self):
        for folder, text in FILES.items():
            self.write(folder, text)

    def write(self, folder, text):
        super().write(Path(folder, "pipeline.toml"), text)

    def read(self, profile="default", imports=()):
        return read_pipeline(str(self.folder), profile, imports)

    def inputs(self, name, profile, imports=()):
        return {(given.port, given.text) for given in self.read(profile, imports).jobs[name].inputs}

    def refused(self, text, said, profile="own", imports=()):
        self.write("own", text)
        with self.assertRaisesRegex(PipelineError, said):
            self.read(profile, imports)

    def test_a_profile_is_its_pieces_in_their_order(self):
        self.assertEqual(list(self.read().jobs), ["look", "see", "merge", "paint", "report"])
        self.assertEqual(list(self.read("both").jobs), ["look", "see", "listen", "merge", "paint", "report"])
        self.assertEqual(list(self.read("eye").jobs), list(self.read().jobs))  # a piece without a list

    def test_a_job_reads_what_its_pieces_add_to_it(self):
        self.assertEqual(self.inputs("merge", "default"), {("eye", "see.o")})
        self.assertEqual(self.inputs("merge", "both"), {("eye", "see.o"), ("ear", "listen.o")})

    def test_what_the_pipeline_or_the_site_lacks_is_not_read(self):
        common = {("a", "merge.o"), ("d", "look.o")}
        self.assertEqual(self.inputs("paint", "default"), common)
        self.assertEqual(self.inputs("paint", "both"), common | {("b", "listen.o")})
        self.assertEqual(self.inputs("paint", "default", ("frame", "paper")), {("a", "merge.o"), ("c", "import.frame"), ("d", "import.paper")})
        self.assertEqual(import_keys(str(self.folder), "both"), {"frame", "paper"})

    def test_a_profile_stands_for_all_that_it_is_made_of(self):
        self.write("own", 'pieces = ["deaf", "ear"]\n')
        pipeline = self.read("own")
        self.assertEqual(set(pipeline.jobs), {"look", "see", "listen", "merge", "paint", "rest", "report"})
        self.assertEqual(pipeline.jobs["paint"].kB_per_frame, 3)
        self.assertEqual(folders(str(self.folder), "own", ()), ["eye", "graph", "draw", "default", "deaf", "ear", "own"])
        self.assertEqual(profiles(str(self.folder)), ["both", "deaf", "default", "ear", "own"])

    def test_own_jobs_are_there_if_the_list_names_them(self):
        text = job("first") + job("second") + "[see]\nkB_per_frame = 2\n[listen]\nkB_per_frame = 2\n"
        for listed, own in (('"own"', {"first", "second"}), ('"own.second"', {"second"}), ('"graph"', set())):
            with self.subTest(listed):
                self.write("own", f'pieces = ["eye", {listed}]\n{text}')
                jobs = self.read("own").jobs
                self.assertEqual(set(jobs) - {"merge", "report"}, {"look", "see"} | own)
                self.assertEqual(jobs["see"].kB_per_frame, 2)  # and `listen`, of another profile, is none of this one

    def test_imports_choose(self):
        self.write("own", 'pieces = ["eye.look", { given = "sight", pieces = ["own"], else = ["eye.see", "graph"] }]\n'
                   + job("import_sight", 'slot = "see"\nprogram = "open"\n', a="import.sight"))  # fmt: skip
        self.assertEqual(list(self.read("own").jobs), ["look", "see", "merge", "report"])
        pipeline = self.read("own", ("sight",))
        self.assertEqual([job.program for job in pipeline.jobs.values()], ["look", "open", None])
        self.assertEqual(import_keys(str(self.folder), "own"), {"sight"})
        self.assertRegex(pipeline.jobs["see"].where("in.a"), r"own/pipeline.toml:5: \[import_sight\]")

    def test_the_profile_says_whose_job_it_is(self):
        self.write("other", job("see", 'program = "squint"\n'))
        pieces = 'pieces = ["eye", "graph", "other"]\n'
        self.refused(pieces, "own/pipeline.toml: eye and other both have a job see: say whose it is, like see = \"other\" in \\[slots\\]")
        for folder, program in (("other", "squint"), ("eye", "see")):
            self.write("own", f'{pieces}[slots]\nsee = "{folder}"\n')
            self.assertEqual(self.read("own").jobs["see"].program, program)

    def test_a_command_without_jobs_has_its_reason(self):
        self.write("own", 'pieces = ["eye", "graph"]\n[without]\ndraw = "no brush"\n')
        self.assertEqual({name: goal.why_without for name, goal in self.read("own").goals.items()}, {"map": None, "draw": "no brush"})

    def test_mistakes_are_named(self):
        self.refused('pieces = ["eyes"]\n', "own/pipeline.toml: pieces: 'eyes' is no folder of")
        self.refused('pieces = ["eye.sea"]\n', "own/pipeline.toml: pieces: 'eye.sea': .*eye/pipeline.toml declares no job sea")
        self.refused('pieces = ["own.sea"]\n', "declares no job sea")
        self.refused('pieces = ["eye", "graph"]\n[sea]\nkB_per_frame = 1\n', r"own/pipeline.toml:2: \[sea\] needs a purpose")
        self.refused('pieces = ["eye", 5]\n', "own/pipeline.toml: pieces is a list of folders .*5")
        self.refused('pieces = [{ when = "a", pieces = [] }]\n', "pieces is a list of folders .*when")
        self.refused('pieces = "eye"\n', "pieces is a list of folders")
        self.refused(job("see", a="sea.o if any"), r"own/pipeline.toml:4: \[see\]: in.a: no job 'sea'")
        self.write("deaf", 'pieces = ["own"]\n')
        self.refused('pieces = ["deaf"]\n', "deaf/pipeline.toml: pieces: 'own' is no folder .*lists this one")
