# SPDX-License-Identifier: Apache-2.0
"""Names and words that pages may use: goals and variables of make, options of programs, messages of programs and scripts."""

import ast
import re
import tomllib

from fake_site import CHECKOUT  # finds the scripts, so first

from describe_pipeline import variants
from nightmap_site.declaration import profiles
from nightmap_site.pipeline import read_pipeline

CONFIGS = CHECKOUT / "configs"
MAKEFILES = ("Makefile", "scripts/development.mk")
GAP = "\0"  # a placeholder of a message
LITERAL = r'"((?:[^"\\\n]|\\.)*)"'
OPTIONS = {path.stem: set(tomllib.loads(path.read_text(encoding="utf-8"))) for path in CONFIGS.glob("*/default/*.toml")}


def text_of(name):
    return (CHECKOUT / name).read_text(encoding="utf-8")


def goals():
    """Commands of make: those that declarations bring, and those of the makefiles."""
    declared = {goal for profile in profiles(str(CONFIGS)) for goal in read_pipeline(str(CONFIGS), profile).goals}
    return declared | {goal for file in MAKEFILES for goal in re.findall(r"(?m)^([a-z_-]+):[^=\n]*##", text_of(file))} | {"why", "status"}


def variables():
    names = re.findall(r"(?m)^## ([A-Z][A-Z_]*(?: [A-Z][A-Z_]*)?) ", text_of("Makefile"))
    return {word for name in names for word in name.split()}


def flags_of(script):
    """Words that may be options of the command line of one script: those that stand in quotes in it or in what it imports."""
    text = text_of(script)
    for name in re.findall(r"(?m)^(?:from|import) (\w+)", text):
        modules = [*(CHECKOUT / "scripts").glob(f"{name}.py"), *(CHECKOUT / "tests/bench").rglob(f"{name}.py")]
        text += "".join(module.read_text(encoding="utf-8") for module in modules)
    return {"help"} | set(re.findall(r"\"(?:--)?([a-z][\w-]*)\"", text))


def flags():
    """Options of all command lines: of programs and scripts."""
    files = [*(CHECKOUT / "pipeline/program").glob("*.cc"), *(CHECKOUT / "scripts").rglob("*.*"), *(CHECKOUT / "tests").rglob("*.py")]
    texts = (path.read_text(encoding="utf-8") for path in files if path.suffix in (".cc", ".py", ".sh", ".mk") and not path.name.startswith("doc"))
    return {flag for text in texts for flag in re.findall(r"--([a-z][\w-]*)", text)}


def ports():
    """Job or program -> names of the inputs and outputs of the job, in any profile; wing -> its jobs."""
    found = {path.parent.name: set(tomllib.loads(path.read_text(encoding="utf-8"))) for path in CONFIGS.glob("*/pipeline.toml")}
    for profile in profiles(str(CONFIGS)):
        for given in variants(str(CONFIGS), profile):
            for job in read_pipeline(str(CONFIGS), profile, given).jobs.values():
                names = {*job.outputs, *job.beside, *(reference.port for reference in job.inputs)}
                for name in {job.name, job.program} - {None}:
                    found.setdefault(name, set()).update(names)
    return found


def messages():
    """Texts in the sources of programs and scripts, with GAP for what is put in when they are printed."""
    for folder in ("pipeline", "stages"):
        for path in [*(CHECKOUT / folder).rglob("*.cc"), *(CHECKOUT / folder).rglob("*.h")]:
            yield from texts_of_cpp(path.read_text(encoding="utf-8"))
    for path in (CHECKOUT / "scripts").rglob("*.py"):
        yield from texts_of_python(path.read_text(encoding="utf-8"))
    for path in (CHECKOUT / "scripts/nightmap_eval/page").glob("*.html"):
        yield from path.read_text(encoding="utf-8").splitlines()
    for path in [*(CHECKOUT / "scripts").glob("*.sh"), *(CHECKOUT / "scripts").glob("*.mk"), CHECKOUT / "Makefile"]:
        yield from re.sub(r"\$\{[^}]*\}|\$\((?!error)[^()]*\)|\$\w+", GAP, path.read_text(encoding="utf-8")).splitlines()


def texts_of_cpp(text):
    for found in re.finditer(rf"{LITERAL}(?:\s*{LITERAL})*", text):
        whole = "".join(re.findall(LITERAL, found[0]))
        yield re.sub(r"\{[^{}]*\}", GAP, re.sub(r"\\(.)", r"\1", whole))


def texts_of_python(text):
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.JoinedStr):
            yield "".join(str(part.value) if isinstance(part, ast.Constant) else GAP for part in node.values)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield re.sub(r"\{[^{}]*\}", GAP, node.value)
