# SPDX-License-Identifier: Apache-2.0
"""The check before a run: each program checks its own config and what it reads of the site's config; conditions between
programs and room on the disk are checked here. It takes a second at most and changes nothing in the folder of the site."""

import ast
import hashlib
import operator
import os
import re

from nightmap_make.imports import files_of
from nightmap_make.input_files import file_state
from nightmap_site.declaration import PipelineError
from nightmap_site.script_errors import writing

SEVERAL = 8  # programs checked at the same time
# What the loader and the libraries say that are given no memory before a program's main begins.
LACKS_MEMORY = re.compile(r"failed to map segment|[Cc]annot allocate memory|Resource temporarily unavailable|bad_alloc")
MESSAGE = re.compile(r"\S+ error \w+: (?P<path>[^:]*):(?:(?P<line>\d+):)? (?P<reason>.*)")
OPERATORS = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
             ast.Gt: operator.gt, ast.Lt: operator.lt, ast.GtE: operator.ge, ast.LtE: operator.le}  # fmt: skip


class ConfigText:
    """The effective config that a program takes: its text, and sources: key -> file or make variable that set it. sites: port ->
    text of the site's config that the program reads there. imports: port -> path of a file that [import] names."""

    def __init__(self, program, values, text, sources, sites, imports):
        self.program, self.values, self.text, self.sources, self.sites, self.imports = program, values, text, sources, sites, imports

    def state(self):
        """A text that tells whether a check of the same program would say the same."""
        files = [file_state(file) for path in self.imports.values() for file in files_of(path)]
        return f"{self.text}\n{sorted(self.sites.items())}\n{sorted(self.imports)} {files}"

    def place_of(self, key):
        """FILE:LINE of a key, or the make variable."""
        source = self.sources[key]
        if not os.path.isfile(source):
            return source
        with open(source, encoding="utf-8") as file:
            for number, line in enumerate(file, 1):
                if re.match(rf"\s*[\"']?{re.escape(key)}[\"']?\s*=", line):
                    return f"{source}:{number}"
        return source

    def key_at(self, line):
        return self.text.split("\n")[line - 1].partition(" = ")[0]


def check_configs(build, configs, is_preview):
    """Lets programs check their configs (name -> ConfigText), each text once. Raises PipelineError with one line per wrong
    config. A preview writes nothing into the folder of the programs."""
    folder = os.path.join(build, "checked")
    to_check = {}
    for name, config in configs.items():
        path = os.path.join(build, "run", config.program)
        status = os.stat(path)
        state = f"{config.program} {status.st_mtime_ns} {status.st_size}\n{config.state()}"
        stamp = os.path.join(folder, f"{name}_{hashlib.sha256(state.encode('utf-8', 'surrogatepass')).hexdigest()[:24]}")
        if not os.path.exists(stamp):
            to_check[name] = stamp
    if not to_check:
        return
    import tempfile  # with all that it imports a hundredth of a second, which a make that does nothing saves

    if not is_preview:
        os.makedirs(folder, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=None if is_preview else build) as scratch:
        wrong = _run_checks(build, scratch, {name: configs[name] for name in to_check})
    # So that the next check is of the corrected config alone.
    for name in to_check.keys() - wrong.keys() if not is_preview else ():
        with open(to_check[name], "w", encoding="utf-8"):
            pass
    if wrong:
        raise PipelineError("\n".join(sorted(set(wrong.values()))))


def _run_checks(build, scratch, configs):
    """Name -> complaint, of each config that its program refuses."""
    waiting, running, wrong = list(configs), {}, {}
    while waiting or running:
        while waiting and len(running) < SEVERAL:
            name = waiting.pop(0)
            running[_start_check(build, scratch, name, configs[name])] = name
        pid, status = os.wait()
        name = running.pop(pid)
        if os.waitstatus_to_exitcode(status) != 0:
            wrong[name] = _complaint(os.path.join(scratch, f"{name}.log"), name, configs[name])
    return wrong


def _start_check(build, scratch, name, config):
    log = os.path.join(scratch, f"{name}.log")
    command = [os.path.join(build, "run", config.program), "--check-config", "--config", _write(scratch, f"{name}.toml", config.text)]
    for port, text in config.sites.items():
        command += ["--in", f"{port}={_write(scratch, f'{name}_{port}.toml', text)}"]
    for port, path in config.imports.items():
        command += ["--in", f"{port}={path}"]
    actions = [(os.POSIX_SPAWN_OPEN, fd, log, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644) for fd in (1, 2)]
    return os.posix_spawn(command[0], command, os.environ, file_actions=actions)


def _write(folder, name, text):
    path = os.path.join(folder, name)
    with writing(path), open(path, "w", encoding="utf-8", errors="surrogatepass") as file:
        file.write(text)
    return path


def _complaint(log, name, config):
    with open(log, encoding="utf-8", errors="replace") as file:
        text = file.read().strip()
    if LACKS_MEMORY.search(text):
        return f"{name}: out of memory while it checked its config; raise the limit (ulimit -v) or free memory, and run make again"
    found = MESSAGE.search(text)
    if not found:
        return f"{name}: {text or 'its check of the config failed without a message; if memory is limited (ulimit -v), raise it'}"
    if os.path.dirname(found["path"]) != os.path.dirname(log):  # of the site's config, whose copy names the user's file
        return ":".join(filter(None, (found["path"], found["line"]))) + f": {found['reason']}"
    if found["line"] is None:
        return f"configs/*/{name}.toml: {found['reason']}"
    key = config.key_at(int(found["line"]))
    return f"{config.place_of(key) if key in config.sources else name}: {name}.{found['reason']}"


def check_clashes(clashes, configs):
    """Raises PipelineError when a declared clash holds; names the place of every value in it."""
    wrong = []
    for clash in clashes:
        names = []
        tree = ast.parse(clash["when"], mode="eval").body
        programs = {node.value.id for node in ast.walk(tree) if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name)}
        if not programs <= set(configs):
            continue  # the profile leaves one of the programs out
        if _value(tree, configs, names):
            values = [f"{program}.{key} = {configs[program].values[key]} ({configs[program].place_of(key)})" for program, key in names]
            wrong.append(f"{'; '.join(dict.fromkeys(values))}: {clash['remedy']}")
    if wrong:
        raise PipelineError("\n".join(wrong))


def _value(node, configs, names):
    """The value of an expression of numbers, PROGRAM.KEY, + - * / and comparisons."""
    match node:
        case ast.Constant():
            return node.value
        case ast.BinOp():
            return OPERATORS[type(node.op)](_value(node.left, configs, names), _value(node.right, configs, names))
        case ast.Compare(ops=[op], comparators=[right]):
            return OPERATORS[type(op)](_value(node.left, configs, names), _value(right, configs, names))
        case ast.BoolOp(op=ast.And()):
            return all(_value(part, configs, names) for part in node.values)
        case ast.Attribute(value=ast.Name(id=program), attr=key):
            names.append((program, key))
            return configs[program].values[key]
    raise PipelineError(f"configs/pipeline.toml: clash: cannot evaluate {ast.unparse(node)}")


def size_bytes(folder):
    """Bytes of the files in a folder, and in its folders; 0 when it does not exist."""
    total = 0
    for place, _, names in os.walk(folder):
        total += sum(os.lstat(os.path.join(place, name)).st_size for name in names)
    return total


def check_disk(folder, needed_bytes, what):
    """Raises PipelineError when the disk lacks the room that a run needs."""
    while not os.path.isdir(folder):
        folder = os.path.dirname(folder) or "."
    disk = os.statvfs(folder)
    free_bytes = disk.f_bavail * disk.f_frsize
    if needed_bytes > free_bytes:
        raise PipelineError(f"{folder}: {free_bytes / 1e9:.2f} GB are free, and {what} needs about {needed_bytes / 1e9:.2f} GB: "
                            "make room, or set MAPS to a folder of another disk")  # fmt: skip
