# SPDX-License-Identifier: Apache-2.0
"""Attacks on a mapped site: each damages something in a tree of its own and names the command to run there.

A tree is a copy of a workspace of the end-to-end tests (configs, data, maps). `commands` are the stages'
commands as make ran them, so that a new stage is attacked as soon as the pipeline has it."""
import dataclasses
import json
import math
import os
import pathlib
import re
import shlex

from attacked_sites import GOALS
from mutations import WORDS, append_garbage, damage, damage_log, damage_table, damage_yaml, make_special, nest_deeply, replace, replace_word
from workspace import LASER_SITE, SITE

CANARY = "../outside/canary.txt"  # a file beside the tree that no command has any business with

MAX_CPU_TIME_S = 20
SLOWER = 10  # than undamaged inputs, at most
ENOUGH_CPU_TIME_S = 2


@dataclasses.dataclass
class Attack:
    what: str
    command: list
    must_fail: bool = False
    max_cpu_time_s: int = MAX_CPU_TIME_S  # of one process
    as_clean: tuple = ()  # files that are as without the attack when the command succeeds; a folder: all artifacts in it


@dataclasses.dataclass
class StageCommand:
    """A stage's command line, taken apart."""
    program: str
    config: str
    inputs: list   # of [name, path]
    outputs: list  # the receipt is the last
    cpu_time_s: float  # of the run without attack

    @classmethod
    def parse(cls, line, root):
        """Parses a line that make printed in `root`; what the files of --in-list hold are inputs one by one."""
        words = shlex.split(line)
        pairs = list(zip(words[1::2], words[2::2]))
        flags = ("--in", "--in-list", "--out")
        ports = {flag: [value.split("=", 1) for key, value in pairs if key == flag] for flag in flags}
        listed = [[name, path] for name, file in ports["--in-list"] for path in (root / file).read_text().splitlines()]
        cpu_time_s = json.loads((root / dict(ports["--out"])["receipt"]).read_text())["cpu_time_s"]
        return cls(words[0], dict(pairs)["--config"], ports["--in"] + listed, ports["--out"], cpu_time_s)

    def copy(self):
        return StageCommand(self.program, self.config, [[*port] for port in self.inputs], [[*port] for port in self.outputs], self.cpu_time_s)

    def attack(self, what, **more):
        max_cpu_time_s = max(ENOUGH_CPU_TIME_S, math.ceil(SLOWER * self.cpu_time_s))
        return Attack(what, self.words(), max_cpu_time_s=max_cpu_time_s, **more)

    def words(self):
        return ([self.program, "--config", self.config]
                + [word for name, path in self.inputs for word in ("--in", f"{name}={path}")]
                + [word for name, path in self.outputs for word in ("--out", f"{name}={path}")])

    def name(self):
        return pathlib.Path(self.program).name

    def input_files(self, root):
        return [port for port in self.inputs if (root / port[1]).is_file()]


def parse_commands(log, root):
    """The stages' commands in what `make V=1` printed in a tree."""
    lines = re.findall(r"(?ms)^scripts/run_job\.sh \S+ \S+ +(build/run/\w+ .*?) --threads", log)
    commands = [StageCommand.parse(line.replace("\\\n", " "), root) for line in lines]
    return [command for command in commands if not command.name().startswith("synthesize")]  # they write to data


# ---- on one program -----------------------------------------------------------------------------
def special_output(draw, root, command):
    port = draw.choice(command.outputs)
    port[1] = f"maps/special{pathlib.Path(port[1]).suffix}"
    kind = make_special(draw, root / port[1])
    return command.attack(f"output {port[0]} is a {kind}", must_fail="link" not in kind)


def output_over_input(draw, root, command):
    port, source = draw.choice(command.outputs), draw.choice(command.input_files(root))
    way = draw.choice(("same", "dots", "hard link", "linked folder"))
    port[1] = source[1]
    if way == "dots":
        port[1] = os.path.join(os.path.dirname(source[1]), ".", "..", os.path.dirname(source[1]).split("/")[-1],
                               os.path.basename(source[1]))
    elif way == "hard link":
        port[1] = "maps/another_name"
        os.link(root / source[1], root / port[1])
    elif way == "linked folder":
        (root / "maps/folder").symlink_to(os.path.abspath(root / os.path.dirname(source[1])))
        port[1] = f"maps/folder/{os.path.basename(source[1])}"
    return command.attack(f"output {port[0]} is input {source[0]} ({way})", must_fail=True)


def output_twice(draw, root, command):
    if len(command.outputs) < 2:
        return None
    first, second = draw.sample(command.outputs, 2)
    folder, name = os.path.split(first[1])
    second[1] = draw.choice((first[1], f"./{first[1]}", f"{folder}//{name}", os.path.abspath(root / first[1])))
    return command.attack(f"outputs {first[0]} and {second[0]} are one", must_fail=True)


def special_input(draw, root, command):
    port = draw.choice(command.inputs)
    port[1] = "maps/special" + pathlib.Path(port[1]).suffix
    kind = make_special(draw, root / port[1])
    # An empty folder of recordings: the pictures are missing, which the join of the tiles refuses, not each tile.
    return command.attack(f"input {port[0]} is a {kind}", must_fail=(port[0], kind) != ("data", "folder"))


def wrong_ports(draw, root, command):
    ports = draw.choice((command.inputs, command.outputs))
    way = draw.choice(("missing", "twice", "swapped", "unknown", "odd path"))
    port = draw.choice(ports)
    if way == "missing":
        ports.remove(port)
    elif way == "twice":
        ports.append([*port])
    elif way == "swapped":
        other = draw.choice(ports)
        port[1], other[1] = other[1], port[1]
    elif way == "unknown":
        port[0] = draw.choice(("nothing", "", "report", "data"))
    else:
        port[1] = draw.choice(("", "/", ".", "maps", "maps/no/such/file", "maps/a\nb", "maps/é", "maps/" + "x" * 300))
    return command.attack(f"{way} port {port[0]}")


def damaged_input(draw, root, command):
    files = command.input_files(root)
    if not files:
        return None
    name, path = draw.choice(files)
    what = f"input {name}: {damage(draw, root / path)}"
    if draw.random() < 0.5:  # else most programs compare the file with its receipt, and do not read it
        for receipt in (root / "maps").glob("*/*/receipt*.json"):
            receipt.unlink()
        what += ", no receipts"
    is_artifact = path.startswith("maps/") and "/config/" not in path
    return command.attack(what, as_clean=[path for _, path in command.outputs[:-1]] if is_artifact and "receipts" not in what else ())


def damaged_config(draw, root, command):
    path = root / command.config
    kind = draw.choice((replace_word, replace_word, replace_word, nest_deeply, append_garbage))
    kind(draw, path)
    return command.attack(f"config: {kind.__name__}")


# ---- on the recording ---------------------------------------------------------------------------
def _command_of(commands, name, site=SITE):
    return next(command.copy() for command in commands if command.name() == name and f"/{site}/" in command.config)


def _lists(root):
    return sorted(path for path in (root / "data").glob("*/*.txt"))


def _pictures(root, folder="*"):
    return sorted((root / "data").glob(f"*/{folder}/*.*"))


def damaged_list(draw, root, commands):
    path = draw.choice(_lists(root))
    return _command_of(commands, "frames").attack(f"{path.name}: {damage(draw, path)}")


def _under_make(draw, site, path, what, command):
    """A damaged file of a site under the program that reads it, or under make."""
    if draw.random() < 0.2:
        return Attack(f"{path.name}: {what}", ["make", f"SITE={site}", draw.choice(("map", "check", "inspect"))])
    return command.attack(f"{path.name}: {what}")


def damaged_log(draw, root, commands):
    """A robot's log, under what reads it."""
    path = root / "data" / LASER_SITE / "robot.log"
    what = draw.choice((damage, damage_log, damage_log))(draw, path)
    return _under_make(draw, LASER_SITE, path, what, _command_of(commands, "frames", LASER_SITE))


def damaged_table(draw, root, commands):
    """A CSV of scans or odometry, under what reads it."""
    site = draw.choice([site for site in ("table", "upward") if (root / "data" / site).is_dir()])
    path = draw.choice(sorted((root / "data" / site).glob("*.csv")))
    what = draw.choice((damage, damage_table, damage_table))(draw, path)
    return _under_make(draw, site, path, what, _command_of(commands, "frames", site))


def damaged_map(draw, root, commands):
    """A ROS map that another system made, under what reads it."""
    path = root / "data/office" / draw.choice(("map.yaml", "map.yaml", "map.png"))
    what = (draw.choice((damage, damage_yaml, damage_yaml)) if path.suffix == ".yaml" else damage)(draw, path)
    return _under_make(draw, "office", path, what, _command_of(commands, "import_grid", "office"))


def picture_outside(draw, root, commands):
    """A list, or a link in the recording, that leads out of it."""
    name = draw.choice(("rgb.txt", "depth.txt"))
    path = next(path for path in _lists(root) if path.name == name)
    lines = path.read_text().splitlines()
    at = draw.randrange(3, len(lines))
    time, name = lines[at].split()
    picture = path.parent / name
    outside = root.parent / "outside" / f"picture{picture.suffix}"
    if draw.random() < 0.5:
        lines[at] = f"{time} {os.path.dirname(name)}/../../../../outside/{outside.name}"
        replace(path, "\n".join(lines).encode() + b"\n")
        what = "a list leads out"
    else:
        picture.unlink()
        picture.symlink_to(outside)
        what = "a link leads out"
    return _command_of(commands, "frames").attack(f"{path.name}: {what}", must_fail="list" in what)


def special_picture(draw, root, commands):
    path = draw.choice(_pictures(root))
    path.unlink()
    return _command_of(commands, "frames").attack(f"picture is a {make_special(draw, path)}")


def damaged_picture(draw, root, commands):
    path = draw.choice(_pictures(root))
    if draw.random() < 0.2:
        path.unlink()
        os.link(root.parent / "outside/bomb.png", path)
        return _command_of(commands, "frames").attack("picture is a decompression bomb")
    name = draw.choice(("frames", "frames", "features", "localize", "point_cloud"))
    return _command_of(commands, name).attack(f"picture: {damage(draw, path)}")


# ---- on make and its scripts --------------------------------------------------------------------
LOOKS = (["-n", "map"], ["-q", "map"], ["why"], ["verify"], ["-n", "report"], ["-q", "localize"])


def damaged_site(draw, root, commands):
    """The site's own config, or a file that make and its scripts read."""
    path = draw.choice(sorted((root / "configs/sites").glob("small.toml")) + sorted((root / "configs/sites/small").iterdir()))
    return Attack(f"{path.name}: {damage(draw, path)}", ["make", *draw.choice(LOOKS)])


def damaged_results(draw, root, commands):
    """Any file below maps, under goals that only look."""
    files = sorted(path for path in (root / "maps").rglob("*") if path.is_file())
    path = draw.choice(files if draw.random() < 0.5 else [path for path in files if path.suffix in (".json", ".txt", ".mk", ".toml")])
    return Attack(f"{path.relative_to(root)}: {damage(draw, path)}", ["make", *draw.choice(LOOKS)])


def damaged_run(draw, root, commands):
    """A damaged artifact, under a make that it makes run again: it heals, refuses, or ends as without the attack."""
    site = draw.choice([path for path in (root / "maps").iterdir() if path.name != "special"])
    others = ("config", "logs", "lists", ".preview", *(() if "localize" in GOALS[site.name] else ("queries",)))
    files = [path for path in sorted(site.glob("*/*")) if path.is_file() and path.parent.name not in others and "receipt" not in path.name]
    path = draw.choice(files)
    what = f"{path.relative_to(root)}: {damage(draw, path)}"
    return Attack(what, ["make", f"SITE={site.name}", *GOALS[site.name]], as_clean=(str(site.relative_to(root)),))


def damaged_evaluation(draw, root, commands):
    """A file that the evaluation reads, under the evaluation."""
    files = [path for path in sorted((root / "maps").glob("*/*/*.*")) + sorted((root / "data").glob("*/*.*"))
             if path.suffix in (".json", ".csv", ".tum", ".txt", ".ply", ".h5", ".yaml")]
    path = draw.choice(files)
    site = root / "maps" / path.relative_to(root).parts[1]
    return Attack(f"{path.relative_to(root)}: {damage(draw, path)}",
                  ["/usr/bin/python3", "scripts/evaluate.py", "--site-dir", str(site.relative_to(root)), "--data", "data",
                   "--out", f"{site.relative_to(root)}/evaluate/metrics.json"])


def hostile_recording(draw, root, commands):
    """Names and things in the recording's folder that only make looks at."""
    folder = draw.choice([path for path in (root / "data").rglob("*") if path.is_dir()])
    kind = draw.choice(("special", "name"))
    if kind == "special":
        kind = make_special(draw, folder / "special")
    else:
        (pathlib.Path(os.fsdecode(os.fsencode(folder) + draw.choice((b"/\xff\xfe.png", b"/a\nb.png", b"/$(touch owned).png",
                                                                     b"/a b.png"))))).write_bytes(b"x")
    return Attack(f"recording holds a {kind}", ["make", *draw.choice(LOOKS)])


EXECUTABLE = ("$(shell touch owned)", "a$(touch owned)b", "`touch owned`", "'; touch owned; '", '"; touch owned; "', "a\ntouch owned\n", "a>owned",
              "$$(touch owned)", "a & touch owned")  # fmt: skip
FOLDERS = ("SITE", "DATA", "MAPS", "BUILD", "SITES")
TEXTS = ("START", "GOAL", "QUERY", "SET", "SEED", "PROFILE", "CAMERA", "FOV_DEG", "THREADS", "LOG_LEVEL", "V", "CASES", "FIGURES", "SANITIZED")


def hostile_variable(draw, root, commands):
    """A variable of make, from its command line or the environment."""
    name = draw.choice(FOLDERS + TEXTS)
    value = draw.choice(EXECUTABLE)
    if name in TEXTS and draw.random() < 0.5:
        value = draw.choice((*(word for word in WORDS if "\0" not in word), "1,2", "nan,nan", "1e308,1e308", "x" * 100000,
                             "plan.start='a", "octree.resolution_m=1e-300", CANARY, "[" * 1000))
    goals = draw.choice(LOOKS + (["maps/small/frames/shards.txt"],))
    command = draw.choice((["make", f"{name}={value}", *goals], ["env", f"{name}={value}", "make", *goals]))
    return Attack(f"{name}={value[:40]!r}", command, must_fail=name in FOLDERS)


def hostile_value(draw, root, commands):
    """Text that make or a shell would execute, in the place of a value of the site's config, or of a file to import."""
    path = root / "configs/sites/small.toml"
    text = json.dumps(draw.choice(EXECUTABLE))
    lines = path.read_text().splitlines()
    if draw.random() < 0.3:
        lines.insert(0, f"profile = {draw.choice((json.dumps('imported'), text))}")
        lines += ["[import]", f"{draw.choice(('map', 'trajectory'))} = {text}"]
        what = "an import"
    else:
        at = draw.choice([number for number, line in enumerate(lines) if re.match(r"\w+ *=", line)])
        key = lines[at].partition("=")[0].strip()
        lines[at] = f"{key} = {draw.choice((text, f'[{text}]'))}"
        what = key
    replace(path, "\n".join(lines).encode() + b"\n")
    return Attack(f"site config: {what} = {text}", ["make", *draw.choice(LOOKS + (["maps/small/frames/shards.txt"],))])


def hostile_query(draw, root, commands):
    """A picture to locate that is none, or much more than one."""
    folder = root / "pictures"
    folder.mkdir()
    picture = pathlib.Path(os.fsdecode(os.fsencode(folder) + draw.choice((b"/a.png", b"/a b.jpg", b"/\xff.png", b"/a\nb.png"))))
    kind = draw.choice(("special", "damaged", "bomb", "list"))
    if kind == "special":
        kind = make_special(draw, picture)
    elif kind == "bomb":
        os.link(root.parent / "outside/bomb.png", picture)
    else:
        picture.write_bytes(draw.choice(_pictures(root)).read_bytes())
        if kind == "damaged":
            damage(draw, picture)
        else:
            (folder / "list.txt").write_bytes(os.fsencode(picture.name) + b"\n" + draw.choice((b"\x00\xff", b"/dev/zero\n", b"a.png\n")))
    query = "pictures/list.txt" if kind == "list" else draw.choice(("pictures", f"'{picture.relative_to(root)}'"))
    return Attack(f"query {kind}: {query!r}", ["make", "localize", f"QUERY={query}", "FOV_DEG=62"])


def damaged_lists(draw, root, commands):
    """A list that make reads, of shards, tiles or floors: it is made again, or is an error."""
    lists = [path for folder in ("frames", "queries", "tiles", "grid") for path in sorted((root / "maps/small").glob(f"{folder}/*"))
             if path.suffix in (".mk", ".txt", ".json", ".csv") and not path.name.startswith(("receipt", "report"))]
    path = draw.choice(lists)
    return Attack(f"{path.relative_to(root)}: {damage(draw, path)}", ["make", draw.choice(("map", "-n")), "map"])


def hostile_path(draw, root, commands):
    """A path that is not on the grid, for the simulated robot."""
    command = _command_of(commands, "drive")
    path = root / dict(command.inputs)["csv"]
    header, *rows = path.read_text().splitlines()
    column = draw.randrange(len(header.split(",")))
    shift = draw.choice((2.2, -5, 1e6, -1e9, 1e300, 0))
    first = draw.randrange(len(rows))
    for at in range(first, draw.choice((first + 1, len(rows)))):
        words = rows[at].split(",")
        words[column] = repr(float(words[column]) + shift) if shift else draw.choice(WORDS)
        rows[at] = ",".join(words)
    replace(path, "\n".join([header, *rows]).encode() + b"\n")
    return command.attack(f"path: column {header.split(',')[column]} {shift:+}")


ON_A_STAGE = (special_output, output_over_input, output_twice, special_input, wrong_ports, damaged_input, damaged_input,
              damaged_input, damaged_config)
ON_A_SITE = (damaged_log, damaged_table, damaged_map, damaged_list, picture_outside, special_picture, damaged_picture, damaged_site, damaged_results,
             damaged_run, damaged_evaluation, damaged_lists, hostile_recording, hostile_query, hostile_variable,
             hostile_value, hostile_path)


def draw_attack(draw, root, commands, only=""):
    """One attack, drawn and carried out in the tree at `root` up to its command; `only`: of the kind of this name."""
    kinds = [kind for kind in ON_A_STAGE + ON_A_SITE if only in ("", kind.__name__)]
    attack = None
    while attack is None:
        kind = draw.choice(kinds)
        if kind in ON_A_STAGE:
            command = draw.choice(commands).copy()
            attack = kind(draw, root, command)
            name = f"{command.name()}: {kind.__name__}"
        else:
            attack, name = kind(draw, root, commands), kind.__name__
    attack.what = f"{name}: {attack.what}"
    return attack
