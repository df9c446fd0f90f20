#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Resolves the effective config of every stage, for scripts/make_site.py before it writes the rules of a site.

    configs/default/<stage>.toml < configs/<profile>/<stage>.toml < configs/sites/<site>/<stage>.toml
    < --seed < --set STAGE.KEY=VALUE

goes to <out>/<stage>.toml in one canonical form (sorted keys, no comments). A file is rewritten
only when its meaning changed, so a comment or a touch makes nothing stale. When a stage's receipts
show that its outputs were made with exactly the present config, the file gets a modification time
before that run: trying a value and going back costs nothing.

The site config goes in the same way to <out>/site/, which the frames stage reads, and to <out>/queries/, which
the queries stage reads; the latter has one more [[query]] per path of --query. Each keeps its modification time
while the parts that its stage reads do not change.

With --preview DIR the same files are written to DIR, with the times of <out> where the meaning is the
same, so that `make -n`, `-q` and `why` can answer for any SET without touching the real configs.

Prints recordings=FILE and pictures=FILE: files whose modification times are those of the last change of the
recordings and of the query pictures. With --no-recordings it skips the recordings. Exit code 2: a mistake in the
request; the message names the remedy.
"""
import argparse
import calendar
import contextlib
import glob
import hashlib
import json
import os
import re
import shlex
import sys
import time
import tomllib

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from nightmap_site.script_errors import os_error_text, writing  # noqa: E402

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

MAX_INTEGER = 2**63 - 1
# Names of receipts, and the errors that reading a damaged one raises.
RECEIPT = re.compile(r"receipt(?:_[\w-]+)?\.json", re.ASCII)
DAMAGED = (OSError, ValueError, LookupError, TypeError, AttributeError, StopIteration, ArithmeticError, RecursionError)
HEADER = "# Written by scripts/resolve_config.py; edit configs/ or use SET instead.\n"
LEFT_BEHIND_S = 3600  # an older temporary file belongs to no running process


class ConfigError(Exception):
    pass


def load(path):
    try:
        with open(path, "rb") as file:
            return tomllib.load(file)
    except RecursionError:
        raise ConfigError(f"{path}: not valid TOML: nested too deep")
    except UnicodeDecodeError:
        raise ConfigError(f"{path}: not valid TOML: not UTF-8 text; store it as UTF-8")
    except ValueError as error:
        raise ConfigError(f"{path}: not valid TOML: {error}")


def toml_value(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return "[" + ", ".join(toml_value(item) for item in value) + "]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    return repr(value)


def canonical(config):
    return HEADER + "".join(f"{key} = {toml_value(config[key])}\n" for key in sorted(config))


def like(default, value, where):
    """`value` with the type of `default`, so that 1 and 1.0 mean the same to a float option."""
    if isinstance(default, list) and isinstance(value, list):
        return [like(default[0], item, where) if default else plain(item, where) for item in value]
    if isinstance(default, float) and type(value) is int:
        return float(value)
    if type(value) is int and abs(value) > MAX_INTEGER:
        raise ConfigError(f"{where} is larger than any whole number here: {toml_value(value)[:30]}...")
    if type(default) is not type(value):
        raise ConfigError(f"{where} must be like its default {toml_value(default)}, "
                          f"but is {toml_value(value)[:100]}")
    return value


def plain(value, where):
    """An item of a list without a default: a number, a text, or a list of them."""
    if isinstance(value, list):
        return [plain(item, where) for item in value]
    if not isinstance(value, (bool, int, float, str)):
        raise ConfigError(f"{where}: {value!r} is neither a number, a text nor a list")
    return value


def parse_value(text, default):
    """The right side of KEY=VALUE: TOML, or bare text for a string option."""
    if isinstance(default, str) and not text.startswith(('"', "'")):
        return text
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except (ValueError, RecursionError):
        return text


def split_set(text, stages):
    name, equals, value = text.partition("=")
    stage, dot, key = name.partition(".")
    if not (equals and dot and stage and key and value):
        raise ConfigError(f"SET: '{text}' is not STAGE.KEY=VALUE, as in SET=\"octree.resolution_m=0.1\"")
    if stage not in stages:
        raise ConfigError(f"SET: '{text}': no stage '{stage}'; stages: {', '.join(stages)}")
    return stage, key, value


def words(name, groups):
    """The words of a make variable; shell quotation marks keep words together."""
    try:
        return [word for group in groups for word in shlex.split(group)]
    except ValueError as error:
        raise ConfigError(f"{name}: {' '.join(groups)}: {str(error).lower()}")


def check_keys(config, default, where):
    for key in config:
        if key not in default:
            raise ConfigError(f"{where}: unknown key '{key}'; known keys: {', '.join(sorted(default))}")


def layer(folder, stages):
    """(stage, config, path) of each file in a folder; none when the folder does not exist."""
    for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
        if not name.endswith(".toml") or name == "pipeline.toml":
            continue
        if name[:-5] not in stages:
            raise ConfigError(f"{folder}/{name}: no stage '{name[:-5]}'")
        yield name[:-5], load(os.path.join(folder, name)), f"{folder}/{name}"


def default_configs(folder, profile):
    """Program -> file of its defaults; a profile has those of its own programs in configs/<profile>/default/."""
    found = {}
    for place in (os.path.join(folder, "default"), os.path.join(folder, profile, "default")):
        for name in sorted(os.listdir(place)) if os.path.isdir(place) else []:
            if name.endswith(".toml"):
                found[name[:-5]] = os.path.join(place, name)
    return found


def effective_configs(arguments):
    """The effective options per program, and the source of each: a file or a make variable."""
    folder = arguments.configs
    known = [name for name in sorted(os.listdir(folder)) if name != "sites" and os.path.isdir(os.path.join(folder, name))]
    if arguments.profile not in known:  # a path, for example
        raise ConfigError(f"{arguments.profile_from}: no profile {arguments.profile!r} in {folder}; profiles: {', '.join(known)}")
    paths = default_configs(folder, arguments.profile)
    configs = {stage: load(path) for stage, path in paths.items()}
    sources = {stage: dict.fromkeys(config, paths[stage]) for stage, config in configs.items()}
    defaults = {stage: dict(config) for stage, config in configs.items()}
    layers = [] if arguments.profile == "default" else list(layer(os.path.join(folder, arguments.profile), configs))
    layers += layer(arguments.site.removesuffix(".toml"), configs)
    for stage, default in defaults.items():
        if "seed" in default and stage != "synthesize":  # a recording is input, not a draw
            layers.append((stage, {"seed": arguments.seed}, "SEED"))
    for stage, config, where in layers:
        check_keys(config, defaults[stage], where)
        for key, value in config.items():
            configs[stage][key] = like(defaults[stage][key], value, f"{where}: {key}")
            sources[stage][key] = where
    for text in words("SET", arguments.set) + arguments.value:
        stage, key, value = split_set(text, list(configs))
        check_keys({key: value}, defaults[stage], f"SET: {stage}")
        default = defaults[stage][key]
        configs[stage][key] = like(default, parse_value(value, default), f"SET: {stage}.{key}")
        sources[stage][key] = "SET"
    return configs, sources


def receipt_paths(arguments, stage):
    """Receipts in the folders of the jobs that a stage's program does; those of synthesize lie with the recording, not with
    the map. Programs may share a folder."""
    if stage == "synthesize":
        site = os.path.basename(arguments.site).removesuffix(".toml")
        return glob.glob(os.path.join(glob.escape(arguments.data), site, "synthesize_receipt.json"))
    root = glob.escape(os.path.dirname(arguments.out))
    found = [path for folder in arguments.folders.get(stage, [stage]) for path in sorted(glob.glob(os.path.join(root, folder, "receipt*.json")))]
    return [path for path in found if RECEIPT.fullmatch(os.path.basename(path))]


def read_receipt(path):
    """The receipt, whether its run was committed completely, and a modification time (ns) before that run. The receipt is
    renamed last, so a newer output comes from a later run that was killed. Folders may have been moved since, and the
    outputs may be older than the start of the run by a clock that was set back."""
    if not os.path.isfile(path):
        raise ValueError(f"{path}: not a file")
    with open(path, encoding="utf-8") as file:
        receipt = json.load(file)
    report = os.path.basename(path).replace("receipt", "report")
    outputs = [output["path"] for output in receipt["outputs"]]
    then = next(os.path.dirname(output) for output in outputs if os.path.basename(output) == report)
    now = os.path.dirname(path)
    times_ns = [os.stat(os.path.join(now, os.path.relpath(output, then))).st_mtime_ns for output in outputs]
    start_ns = calendar.timegm(time.strptime(receipt["start_time"], "%Y-%m-%dT%H:%M:%SZ")) * 10**9
    return receipt, max(times_ns) <= os.stat(path).st_mtime_ns, min(start_ns, *times_ns)


def made_with(arguments, stage, config):
    """A time (ns) before the earliest run if every receipt of the stage names exactly this config."""
    starts = []
    for path in receipt_paths(arguments, stage):
        try:
            receipt, whole, start_ns = read_receipt(path)
            if receipt["stage"] != stage:
                continue
            if not whole or tomllib.loads(receipt["config"]) != config:
                return None
            starts.append(start_ns)
        except DAMAGED:
            return None
    return min(starts, default=None)


def has_text(path, text):
    """Whether a file of an earlier call holds this text; a damaged file does not."""
    if not os.path.isfile(path):
        return False
    with open(path, "rb") as file:
        return file.read() == text.encode("utf-8", "surrogatepass")


def write(path, text, mtime_ns=None):
    """Writes a temporary file of this run, then renames it. Removes old temporary files, which killed runs left."""
    for left in glob.glob(f"{glob.escape(path)}.*.tmp"):
        with contextlib.suppress(OSError):
            if time.time() - os.stat(left).st_mtime > LEFT_BEHIND_S:
                os.remove(left)
    temporary = f"{path}.{os.getpid()}-{os.urandom(6).hex()}.tmp"
    try:
        with writing(path):
            with open(temporary, "x", encoding="utf-8") as file:
                file.write(text)
            if mtime_ns is not None:
                os.utime(temporary, ns=(mtime_ns, mtime_ns))
            os.replace(temporary, path)
    finally:
        with contextlib.suppress(FileNotFoundError):  # it has its final name
            os.remove(temporary)


def write_if_changed(path, text):
    if not has_text(path, text):
        os.makedirs(os.path.dirname(path), exist_ok=True)
        write(path, text)


def settle(configs, arguments):
    folder = arguments.preview or arguments.out
    os.makedirs(folder, exist_ok=True)
    for stage, config in configs.items():
        text = canonical(config)
        current = os.path.join(arguments.out, stage + ".toml")
        target = os.path.join(folder, stage + ".toml")
        same = has_text(current, text)
        if same and not arguments.preview:
            continue
        mtime_ns = (os.stat(current).st_mtime_ns if same else
                    made_with(arguments, stage, config))
        write(target, text, mtime_ns)


def from_data(path, data):
    """`path` relative to the data folder. `..` out of a folder that is a link leads out of its target."""
    inside = os.path.relpath(path, data)
    if inside.split(os.sep)[0] != os.pardir:
        return inside
    folder, name = os.path.split(os.path.abspath(path))
    return os.path.relpath(os.path.join(os.path.realpath(folder), name), os.path.realpath(data))


def tables(site, name, arguments):
    found = site.get(name, [])
    if not isinstance(found, list):
        raise ConfigError(f"{arguments.site}: '{name}' must be written as [[{name}]]")
    return found


def check_site(arguments):
    """Checks the types of the keys read here; the frames stage checks the whole site config."""
    site = load(arguments.site)

    def check_text(table, names, where):
        for name in names:
            if not isinstance(table.get(name, ""), str):
                raise ConfigError(f"{arguments.site}: {name}{where} must be text in quotation marks")

    check_text(site, ("root", "profile"), "")
    if not isinstance(site.get("synthetic", False), bool):
        raise ConfigError(f"{arguments.site}: synthetic must be true or false")
    imports = site.get("import", {})
    if not isinstance(imports, dict):
        raise ConfigError(f"{arguments.site}: 'import' must be written as [import]")
    check_text(imports, imports, " of [import]")
    for kind in ("sequence", "query", "signal"):
        for table in tables(site, kind, arguments):
            if not isinstance(table, dict):
                raise ConfigError(f"{arguments.site}: '{kind}' must be written as [[{kind}]]")
            check_text(table, ("folder", "pictures", "ground_truth", "label_folder", "file"), f" of [[{kind}]]")


def query_tables(root, arguments):
    """The [[query]] of each path of --query."""
    paths = words("QUERY", arguments.query)
    camera = {"camera": arguments.camera} if arguments.camera else {}
    if arguments.fov_deg:
        try:
            camera["horizontal_fov_deg"] = float(arguments.fov_deg)
        except ValueError:
            raise ConfigError(f"FOV_DEG={arguments.fov_deg}: give a number of degrees")
    if camera and not paths:
        raise ConfigError("CAMERA and FOV_DEG describe the pictures of QUERY: name some")
    for path in paths:
        # Surrogates stand for bytes that are not UTF-8.
        if any(c < " " or c == "\x7f" or "\ud800" <= c <= "\udfff" for c in path):
            raise ConfigError(f"QUERY: the name {path!r} is not UTF-8 or holds control characters: rename it")
        if not os.path.exists(path):
            raise ConfigError(f"QUERY: {path} does not exist: name pictures, folders of them or .txt lists")
    data = os.path.realpath(arguments.data)  # absolute: how many `..` lead out does not depend on where we are
    from_root = [os.path.relpath(os.path.join(data, from_data(path, arguments.data)), os.path.join(data, root))
                 for path in paths]
    return [{"layout": "pictures", "pictures": path} | camera for path in from_root]


# The parts of a site config that each stage reads: without the tables that only the other stage reads.
OF_MAKE = ("profile", "synthetic", "import")  # keys that choose and fill jobs
SITE_PARTS = {"site": ("query", *OF_MAKE), "queries": ("sequence", "signal", "sensor", "hold_out_every", *OF_MAKE)}


def site_part(site, part):
    """The keys of the site that the stage of a part reads. (Queries are numbered after the recordings.)"""
    taken = {key: value for key, value in site.items() if key not in SITE_PARTS[part]}
    return taken | ({"num_sequences": len(site.get("sequence", []))} if part == "queries" else {})


def effective_sites(arguments):
    """Part -> text and tables of the site config; the part of the queries includes those of --query. The text
    keeps the user's lines and names the user's file, so that pipeline/recording/site_config.cc can name both in
    messages."""
    try:
        with open(arguments.site, encoding="utf-8") as file:
            text = file.read()
    except UnicodeDecodeError as error:
        raise ConfigError(f"{arguments.site}: not UTF-8 text ({error.reason}): store it as UTF-8")
    site = load(arguments.site)
    text += f"\n# This was the text of {arguments.site}; QUERY adds:\n"
    queries = query_tables(site.get("root", "."), arguments)
    added = "".join("[[query]]\n" + "".join(f"{key} = {toml_value(query[key])}\n" for key in query)
                    for query in queries)
    asked = site | ({"query": tables(site, "query", arguments) + queries} if queries else {})
    return {"site": (text, site), "queries": (text + added, asked)}


def same_part(path, site, part):
    """Whether an earlier call wrote the same for this stage; a damaged file is not the same."""
    if not os.path.exists(path):
        return False
    try:
        return site_part(load(path), part) == site_part(site, part)
    except (ConfigError, TypeError):
        return False


def settle_site(part, text, site, arguments):
    """Writes the site config of a stage. It keeps its time when its text changed but the stage's keys did not."""
    name = os.path.join(part, os.path.basename(arguments.site))
    folder = arguments.preview or arguments.out
    current, target = os.path.join(arguments.out, name), os.path.join(folder, name)
    same = same_part(current, site, part)
    if same and not arguments.preview and has_text(current, text):
        return
    os.makedirs(os.path.dirname(target), exist_ok=True)
    write(target, text, os.stat(current).st_mtime_ns if same else None)


def file_state(path):
    """(path, size, modification time, change time) of a file, or the kind of error when it is not readable (a broken
    link, say). The frames stage decides whether that matters. The change time tells of a file replaced by one of the
    same size with its old modification time; a link, a chmod or a copy changes it too, and `frames` finds the same bytes."""
    try:
        status = os.stat(path)
    except OSError as error:
        return path, error.errno, 0, 0
    return path, status.st_size, status.st_mtime_ns, status.st_ctime_ns


def folder_id(folder):
    """What all paths of a folder have in common; None when it does not exist."""
    if not os.path.exists(folder):
        return None
    status = os.stat(folder)
    return status.st_dev, status.st_ino


def recording_files(folder, seen):
    """The state of every file below a folder, without hidden ones. `seen` holds the folders visited: links may
    form a circle."""
    try:
        if folder_id(folder) in seen:
            return
        seen.add(folder_id(folder))
        entries = sorted(os.scandir(folder), key=lambda entry: entry.name)
    except OSError:
        yield file_state(folder) + ("not readable",)
        return
    for entry in entries:
        if entry.name.startswith("."):
            continue
        if is_folder(entry):
            yield from recording_files(entry.path, seen)
        else:
            yield file_state(entry.path)


def is_folder(entry):
    try:
        return entry.is_dir()
    except OSError:  # a link to itself
        return False


def picture_files(path):
    """The pictures of a folder, list or file, and cameras.csv beside them."""
    if os.path.isdir(path):
        try:
            names = [name for name in os.listdir(path) if not name.startswith(".")]
        except OSError as error:
            raise ConfigError(f"{path}: {error.strerror}: make the folder readable")
        return [file for file in (os.path.join(path, name) for name in names) if os.path.isfile(file)]
    names = ["cameras.csv"]
    if path.lower().endswith(".txt") and os.path.isfile(path):
        with open(path, encoding="utf-8", errors="surrogateescape") as file:
            names += [line.strip() for line in file if line.strip() and not line.lstrip().startswith("#")]
    beside = [os.path.join(os.path.dirname(path), name) for name in names]
    return [path] + [file for file in beside if os.path.isfile(file)]


def look_for(path, arguments):
    if os.path.exists(path):
        return
    raise ConfigError(f"site {os.path.basename(arguments.site)[:-5]}: {path} does not exist. "
                      f"datasets.md says where to get each recording; DATA={arguments.data} "
                      "is the folder it is looked for in")


class InputFiles:
    """The files that tables of the site's config name: of its recordings, or of its query pictures."""

    def __init__(self, name, site, parts, arguments):
        def in_data(path):
            return os.path.join(arguments.data, os.path.normpath(os.path.join(site.get("root", "."), path)))

        self.name = name
        self.pictures = {in_data(part["pictures"]) for part in parts if "pictures" in part}
        self.folders = {in_data(part.get("folder", ".")) for part in parts if not {"pictures", "file"} & set(part)}
        self.extra = {in_data(part[key]) for part in parts for key in ("ground_truth", "file") if part.get(key)}

    def named(self):
        return sorted(self.folders | self.extra | self.pictures)

    def states(self, maps):
        """The state of each file. The folder of the results may lie inside a recording, and is no part of it."""
        files = {file_state(path) for path in self.extra.union(*map(picture_files, self.pictures))}
        seen = {folder_id(maps)} - {folder_id(folder) for folder in self.folders}
        for folder in sorted(self.folders):
            files.update(recording_files(folder, seen))
        return files


def input_files(sites, arguments):
    """Recordings and pictures. Make itself handles a recording that synthesize makes, including its queries; synthesize
    never makes plain pictures."""
    _, site = sites["site"]
    if not arguments.no_recordings:
        parts = [] if arguments.synthetic else tables(site, "sequence", arguments) + tables(site, "signal", arguments)
        yield InputFiles("recordings", site, parts, arguments)
    _, site = sites["queries"]
    queries = [query for query in tables(site, "query", arguments) if "pictures" in query or not arguments.synthetic]
    yield InputFiles("pictures", site, queries, arguments)


def settle_files(files, arguments):
    """Writes a file whose time is that of the last change of some recordings or queries; returns its path.

    A folder's time does not show that a file was replaced in place, so the sizes and both times of all
    files count. (The stages then compare contents: a touch reruns nothing after them.)"""
    maps = os.path.dirname(os.path.dirname(arguments.out))
    states = {(os.path.relpath(path, arguments.data), *rest) for path, *rest in files.states(maps)}
    digest = hashlib.sha256(repr(sorted(states)).encode()).hexdigest()
    text = f"{len(states)} files {digest}\n"
    current = os.path.join(arguments.out, files.name)
    same = has_text(current, text)
    if same and not arguments.preview:
        return current
    target = os.path.join(arguments.preview or arguments.out, files.name)
    write(target, text, os.stat(current).st_mtime_ns if same else None)
    return target


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--configs", default="configs")
    parser.add_argument("--site", required=True, help="site config (TOML)")
    parser.add_argument("--data", required=True)
    parser.add_argument("--profile", default="default")
    parser.set_defaults(profile_from="PROFILE", folders={})
    parser.add_argument("--seed", default="0")
    parser.add_argument("--set", action="append", default=[], help="several, separated by spaces")
    parser.add_argument("--value", action="append", default=[], help="one STAGE.KEY=VALUE; it may contain spaces")
    parser.add_argument("--query", action="append", default=[], help="pictures to add to the site, as in make's QUERY")
    parser.add_argument("--camera", help="of --query")
    parser.add_argument("--fov-deg", help="of --query")
    parser.add_argument("--out", required=True)
    parser.add_argument("--preview", help="write here instead, with the times of --out")
    parser.add_argument("--no-recordings", action="store_true", help="check only the queries, not the recordings")
    parser.add_argument("--synthetic", action="store_true", help="the recording is made by synthesize")
    return parser.parse_args()


def refuse(error):
    message = str(error).encode("utf-8", "backslashreplace").decode()
    print(f"nightmap: {message}", file=sys.stderr)
    return 2


def check(arguments):
    """Reads the configs, the source of each value, and text and tables of each part of the site config. Writes
    nothing."""
    if not (str(arguments.seed).isascii() and str(arguments.seed).isdigit() and len(str(arguments.seed)) < 19):
        raise ConfigError(f"SEED={arguments.seed}: give a whole number")
    arguments.seed = int(arguments.seed)
    if not os.path.exists(arguments.site):
        folder = os.path.dirname(arguments.site)
        known = sorted(os.listdir(folder)) if os.path.isdir(folder) else []
        raise ConfigError(f"no site config {arguments.site}; sites: "
                          + ", ".join(name[:-5] for name in known if name.endswith(".toml")))
    configs, sources = effective_configs(arguments)
    check_site(arguments)
    sites = effective_sites(arguments)
    for files in input_files(sites, arguments):
        for path in files.named():
            look_for(path, arguments)
    return configs, sources, sites


def settle_all(configs, sites, arguments):
    """Writes the changed files. Returns files whose times are those of the last change of `recordings` and `pictures`."""
    settle(configs, arguments)
    for part, (text, site) in sites.items():
        settle_site(part, text, site, arguments)
    return {files.name: settle_files(files, arguments) for files in input_files(sites, arguments)}


@contextlib.contextmanager
def plain_errors():
    """Turns the exceptions of a wrong config or an unreadable file into a ConfigError."""
    try:
        yield
    except OSError as error:
        raise ConfigError(os_error_text(error, "correct its permissions or its place")) from None
    except RecursionError:
        raise ConfigError("a value of configs/ or SET is nested too deep: correct what you changed last") from None
    except ValueError as error:
        raise ConfigError(str(error)) from None


def main():
    arguments = parse_arguments()
    try:
        with plain_errors():
            configs, _, sites = check(arguments)
            inputs = settle_all(configs, sites, arguments)
    except ConfigError as error:
        return refuse(error)
    print(*(f"{name}={path}" for name, path in inputs.items()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
