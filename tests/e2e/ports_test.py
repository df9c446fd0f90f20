# SPDX-License-Identifier: Apache-2.0
"""Ports of programs, as they print them, against those that the jobs of every profile give them."""
import collections
import functools
import subprocess
import unittest
from types import SimpleNamespace

from workspace import BUILD, REPOSITORY  # finds the scripts, so first

from describe_pipeline import variants
from nightmap_site.declaration import profiles
from nightmap_site.pipeline import read_pipeline

CONFIGS = str(REPOSITORY / "configs")
KINDS = {"file", "folder", "by_hash"}
NEEDED, REPEATABLE = {"one", "many"}, {"many", "any_number"}


@functools.cache
def ports_of(program):
    """(direction, name) -> (kind, number)."""
    printed = subprocess.run([BUILD / "bin" / program, "--print-ports"], capture_output=True, text=True, check=True).stdout
    return {(direction, name): (kind, number) for direction, name, kind, number in map(str.split, printed.splitlines())}


def mistakes(job, ports):
    """In words: what a job gives its program, against the program's ports."""
    sources = collections.defaultdict(list)
    for reference in job.inputs:
        sources["in", reference.port].append(reference)
    outputs = {("out", name) for name in job.outputs}
    for direction, name in {*sources, *outputs} - {*ports}:
        yield f"{direction}.{name} is no port"
    for port, (kind, number) in ports.items():
        given = sources[port] or port in outputs
        if number in NEEDED and not given:
            yield f"{'.'.join(port)} is missing"
        if number not in REPEATABLE and len(sources[port]) + sum(bool(source.units) for source in sources[port]) > 1:
            yield f"{'.'.join(port)} takes one path"
        if number in NEEDED and any(source.if_made for source in sources[port]):
            yield f"{'.'.join(port)} may be missing"
        if (kind == "by_hash") != any(source.by_hash for source in sources[port]) and sources[port]:
            yield f"{'.'.join(port)}: by hash for the job or the program alone"


class PortsTest(unittest.TestCase):
    def test_jobs_give_their_programs_the_ports_that_these_have(self):
        tried = set()
        for profile in profiles(CONFIGS):
            for given in variants(CONFIGS, profile):
                for job in read_pipeline(CONFIGS, profile, given).jobs.values():
                    if job.program:
                        tried.add(job.program)
                        with self.subTest(profile=profile, given=given, job=job.name):
                            self.assertEqual(list(mistakes(job, ports_of(job.program))), [])
        self.assertGreater(len(tried), 30)

    def test_a_program_prints_kinds_and_numbers(self):
        self.assertLessEqual({kind for kind, _ in ports_of("features").values()}, KINDS)
        self.assertEqual(ports_of("features")["out", "receipt"], ("file", "optional"))

    def test_each_mistake_is_found(self):
        def reference(port, **changes):
            return SimpleNamespace(port=port, **({"units": None, "if_made": False, "by_hash": False} | changes))

        def found(ports, *inputs, outputs=("o",)):
            return list(mistakes(SimpleNamespace(inputs=inputs, outputs=outputs), {("out", "o"): ("file", "one")} | ports))

        one, many = {("in", "a"): ("file", "one")}, {("in", "a"): ("file", "many")}
        self.assertEqual(found(one, reference("a")), [])
        self.assertEqual(found(many, reference("a"), reference("a", units="all")), [])
        self.assertEqual(found({}, reference("a")), ["in.a is no port"])
        self.assertEqual(found({}, outputs=("o", "b")), ["out.b is no port"])
        self.assertEqual(found({}, outputs=()), ["out.o is missing"])
        self.assertEqual(found(many), ["in.a is missing"])
        self.assertEqual(found(one, reference("a"), reference("a")), ["in.a takes one path"])
        self.assertEqual(found(one, reference("a", units="all")), ["in.a takes one path"])
        self.assertEqual(found(one, reference("a", if_made=True)), ["in.a may be missing"])
        self.assertEqual(found(one, reference("a", by_hash=True)), ["in.a: by hash for the job or the program alone"])
