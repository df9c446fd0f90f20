# SPDX-License-Identifier: Apache-2.0
"""The check before a run: each program checks its own config and what it reads of the site's config, clashes
between programs, and room on the disk. It takes a second at most and changes nothing in the folder of the site."""

import os
import re

from nightmap_make.changed_files import digest
from nightmap_make.imports import files_of
from nightmap_make.input_files import file_state
from nightmap_site.script_errors import writing
from nightmap_site.toml_file import PipelineError

SEVERAL = 8  # programs checked at the same time
# Words of the loader and the libraries that are given no memory before a program's main begins.
LACKS_MEMORY = re.compile(r"failed to map segment|[Cc]annot allocate memory|Resource temporarily unavailable|bad_alloc")
MESSAGE = re.compile(r"\S+ error \w+: (?P<path>[^:]*):(?:(?P<line>\d+):)? (?P<reason>.*)")


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


def check(build, configs, clashes, is_preview):
    """Lets programs check their configs (name -> ConfigText), then looks for clashes between them; what passed once is not checked
    again. Raises PipelineError with one line per wrong config. A preview writes nothing into the folder of the programs."""
    states = {}
    for name, config in configs.items():
        status = os.stat(os.path.join(build, "run", config.program))
        states[name] = f"{config.program} {status.st_mtime_ns} {status.st_size}\n{config.state()}"
    passed = _stamp(build, "all", f"{states} {clashes}")
    if os.path.exists(passed):
        return
    # With all that they import a hundredth of a second, which a make that does nothing saves.
    import tempfile

    from nightmap_make.clashes import check_clashes

    stamps = {name: _stamp(build, name, state) for name, state in states.items()}
    to_check = {name: configs[name] for name, stamp in stamps.items() if not os.path.exists(stamp)}
    with tempfile.TemporaryDirectory(dir=None if is_preview else build) as scratch:
        wrong = _run_checks(build, scratch, to_check)
    if not is_preview:  # so that the next check is of the corrected config alone
        _remember(stamps[name] for name in to_check.keys() - wrong.keys())
    if wrong:
        raise PipelineError("\n".join(sorted(set(wrong.values()))))
    check_clashes(clashes, configs)
    if not is_preview:
        _remember([passed])


def _stamp(build, name, state):
    return os.path.join(build, "checked", f"{name}_{digest(state)[:24]}")


def _remember(stamps):
    for stamp in stamps:
        os.makedirs(os.path.dirname(stamp), exist_ok=True)
        with open(stamp, "w", encoding="utf-8"):
            pass


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
    key = config.text.split("\n")[int(found["line"]) - 1].partition(" = ")[0]
    return f"{config.place_of(key) if key in config.sources else name}: {name}.{found['reason']}"


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
