#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""sweep: attacks the programs and scripts with wrong ports, special files, damaged artifacts and hostile lists.

Maps small made-up sites of every profile once, then runs each attack in a copy of it. A run is a violation when a program
ends by a signal or an undocumented exit code, takes longer than the limit, prints a traceback or an exception's
bare text, succeeds where it must refuse, or touches anything that is not in MAPS. The same seed and index
give the same attack: `--only INDEX` repeats one and shows what was printed.
Exit codes: 0 no violation; 1 violations, each listed; 2 wrong command line.
"""
import argparse
import collections
import concurrent.futures
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "e2e"))

from workspace import NO_ARTIFACTS, SITE, Workspace, environment  # noqa: E402  first: it finds the scripts
from attacked_sites import make_sites  # noqa: E402
from attacks import ON_A_SITE, ON_A_STAGE, draw_attack, parse_commands  # noqa: E402
from mutations import write_bomb  # noqa: E402

MAX_TIME_S = 180  # a run that waits for ever ends here, one of a busy machine does not
EXIT_CODES = (0, 1, 2, 3)
# Words of a library or language, in place of a message to the user.
BARE_TEXTS = re.compile(r"Traceback \(most recent|terminate called|Segmentation fault|Aborted|core dumped|stack smashing"
                        r"|runtime error:|_M_range_check|std::|json\.exception|\[Errno \d|Error 1[34]\d\b|out of memory")


def copy_tree(source, target):
    """A copy by hard links: attacks replace files, and a program that writes in place shows in the source.
    Logs and locks are written in place by right."""
    def copy(source_file, target_file):
        (shutil.copy2 if "logs" in source_file.split(os.sep) or source_file.endswith(".lock") else os.link)(source_file, target_file)

    shutil.copytree(source, target, symlinks=True, copy_function=copy)


def artifacts(root, site):
    """Paths of the artifacts of a site."""
    return [str(path.relative_to(root)) for path in sorted((root / site).glob("*/*"))
            if path.is_file() and not str(path.relative_to(root / site)).startswith(NO_ARTIFACTS) and "receipt" not in path.name
            and path.name != "hashes.csv" and not path.name.endswith(".sources.csv")]  # fmt: skip


def read(path):
    return path.read_bytes() if path.is_file() else None


def make_outside(folder, bomb):
    """Files beside a tree, for attacks to lead to."""
    folder.mkdir()
    os.link(bomb, folder / "bomb.png")
    (folder / "canary.txt").write_text("1.0 stay out\n")
    for suffix in (".png", ".jpg"):
        (folder / f"picture{suffix}").write_bytes(b"a picture of somebody else")


def state(root, leave_out):
    """(path, type, size, time) of all that is below a folder, but for one of its folders."""
    found = set()
    for folder, folders, files in os.walk(root):
        if os.path.join(folder, "") == os.path.join(leave_out, ""):
            folders.clear()
            continue
        for name in folders + files:
            path = os.path.join(folder, name)
            if path != str(leave_out):
                try:
                    status = os.lstat(path)
                except FileNotFoundError:  # some program still runs: it is told as what it touched
                    found.add((path, "vanished"))
                    continue
                is_file = not os.path.isdir(path) or os.path.islink(path)
                found.add((path, status.st_mode, *((status.st_size, status.st_mtime_ns) if is_file else ())))
    return found


def run_command(attack, root):
    """Exit code (None after the time limit), output and time of a command and all that it starts."""
    start = time.monotonic()
    limited = ["bash", "-c", f'ulimit -t {attack.max_cpu_time_s}; exec "$@"', "bash", *map(os.fspath, attack.command)]
    process = subprocess.Popen(limited, cwd=root, env=environment(), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, start_new_session=True)
    try:
        output, _ = process.communicate(timeout=MAX_TIME_S)
        code = process.returncode
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        output, code = process.communicate()[0], None
    return code, output.decode("utf-8", errors="replace"), time.monotonic() - start


def find_violations(attack, code, output, time_s, touched):
    found = []
    if code is None:
        found.append(f"still running after {time_s:.0f} s")
    elif code < 0:
        found.append(f"ended by signal {-code}")
    elif code not in EXIT_CODES:
        found.append(f"exit code {code}")
    elif code == 0 and attack.must_fail:
        found.append("succeeded where it must refuse")
    found += [f"printed '{bare}'" for bare in sorted(set(match.group() for match in BARE_TEXTS.finditer(output)))]
    if code and code > 0 and not output.strip() and "-q" not in attack.command:
        found.append(f"exit code {code} without a word")
    return found + [f"touched {path}" for path in sorted(touched)]


class Sweep:
    def __init__(self, seed, kind=""):
        self.seed, self.kind = seed, kind
        self.base = Workspace()
        self.commands = [command for _, log in make_sites(self.base) for command in parse_commands(log, self.base.folder)]
        self.bomb = self.base.folder / "bomb.png"
        write_bomb(self.bomb)
        self.before = state(self.base.folder, "")

    def close(self):
        self.base.remove()

    def attack(self, index):
        """(attack, exit code, violations, output) of one run."""
        folder = pathlib.Path(tempfile.mkdtemp(prefix="nightmap-sweep-"))
        try:
            root = folder / "tree"
            copy_tree(self.base.folder, root)
            make_outside(folder / "outside", self.bomb)
            attack = draw_attack(random.Random(f"{self.seed}:{index}"), root, self.commands, self.kind)
            if "make" in attack.command:
                at = attack.command.index("make") + 1
                names_site = any(word.startswith("SITE=") for word in attack.command)
                attack.command[at:at] = ["--no-print-directory", *(() if names_site else (f"SITE={SITE}",))]
            before = state(folder, root / "maps")
            code, output, time_s = run_command(attack, root)
            touched = {os.path.relpath(item[0], folder) for item in before ^ state(folder, root / "maps")}
            others = self.other_results(attack, root) if code == 0 else []
            return attack, code, find_violations(attack, code, output, time_s, touched) + others, output
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def other_results(self, attack, root):
        """Results that differ from those without the attack."""
        names = [name for place in attack.as_clean for name in ([place] if (root / place).is_file() else artifacts(self.base.folder, place))]
        return [f"succeeded with another {name}" for name in names if read(root / name) != read(self.base.folder / name)]

    def touched_base(self):
        """Files of the workspace itself that some attack's program wrote in place."""
        return sorted(item[0] for item in self.before ^ state(self.base.folder, ""))


def run_sweep(seed, num_runs, num_parallel, report=print, kind=""):
    """(number of runs by exit code, list of violations)"""
    sweep = Sweep(seed, kind)
    codes, violations, lock = collections.Counter(), [], threading.Lock()

    def run(index):
        attack, code, found, _ = sweep.attack(index)
        with lock:
            codes[code] += 1
            for text in found:
                violations.append(f"{index}: {attack.what}: {text}")
                report(violations[-1])
            if sum(codes.values()) % 100 == 0:
                report(f"{sum(codes.values())} of {num_runs} runs, {len(violations)} violations")

    try:
        with concurrent.futures.ThreadPoolExecutor(num_parallel) as pool:
            list(pool.map(run, range(num_runs)))
        for path in sweep.touched_base():
            violations.append(f"a run wrote {path} in place")
            report(violations[-1])
    finally:
        sweep.close()
    return codes, violations


def show_one(seed, index, kind):
    sweep = Sweep(seed, kind)
    try:
        attack, code, found, output = sweep.attack(index)
    finally:
        sweep.close()
    print(output, f"{attack.what}\n{' '.join(attack.command)[:2000]}\nexit code {code}", *found, sep="\n")
    return 1 if found else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--runs", type=int, default=2000, help="number of attacks (default 2000)")
    parser.add_argument("--seed", type=int, default=0, help="of the attacks (default 0)")
    parser.add_argument("--parallel", type=int, default=os.cpu_count(), help="attacks at a time (default: one per core)")
    parser.add_argument("--only", type=int, metavar="INDEX", help="repeat one attack and show what it printed")
    parser.add_argument("--kind", default="", choices=[kind.__name__ for kind in ON_A_STAGE + ON_A_SITE], help="attacks of one kind only")
    arguments = parser.parse_args()
    if arguments.only is not None:
        return show_one(arguments.seed, arguments.only, arguments.kind)
    start = time.monotonic()
    codes, violations = run_sweep(arguments.seed, arguments.runs, arguments.parallel, kind=arguments.kind)
    counts = ", ".join(f"{count} with exit code {code}" for code, count in sorted(codes.items(), key=str))
    print(f"{sum(codes.values())} runs in {time.monotonic() - start:.0f} s ({counts}): {len(violations)} violations")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main())
