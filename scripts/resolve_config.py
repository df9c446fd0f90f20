#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Resolves the effective config of every stage, for the Makefile to call while it is parsed.

    configs/default/<stage>.toml < configs/<profile>/<stage>.toml < configs/sites/<site>/<stage>.toml
    < --seed < --set STAGE.KEY=VALUE

goes to <out>/<stage>.toml in one canonical form (sorted keys, no comments). A file is rewritten
only when its meaning changed, so a comment or a touch makes nothing stale. When a stage's receipts
show that its outputs were made with the very config that is asked for now, the file gets a time
before that run: trying a value and going back costs nothing.

With --preview DIR the same files are written to DIR (times of <out> kept where the meaning is the
same), so that `make -n`, `-q` and `why` can answer for any SET without touching the real configs.

Prints a file for Make that is as old as the last change of the recordings, and interrupted=RUN for
each run that was killed in the middle of its commit. Exit code 2: a mistake in what was asked; the
message says what to do.
"""
import argparse
import calendar
import glob
import hashlib
import json
import os
import shlex
import sys
import time
import tomllib

HEADER = "# Written by scripts/resolve_config.py; edit configs/ or use SET instead.\n"


class ConfigError(Exception):
    pass


def load(path):
    try:
        with open(path, "rb") as file:
            return tomllib.load(file)
    except tomllib.TOMLDecodeError as error:
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
        return [like(default[0], item, where) if default else item for item in value]
    if isinstance(default, float) and type(value) is int:
        return float(value)
    if type(default) is not type(value):
        raise ConfigError(f"{where} must be like its default {toml_value(default)}, "
                          f"but is {toml_value(value)}")
    return value


def parse_value(text, default):
    """The right side of KEY=VALUE: TOML, or bare text for a string option."""
    if isinstance(default, str) and not text.startswith(('"', "'")):
        return text
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def split_set(text, stages):
    name, equals, value = text.partition("=")
    stage, dot, key = name.partition(".")
    if not (equals and dot and stage and key and value):
        raise ConfigError(f"SET: '{text}' is not STAGE.KEY=VALUE, as in SET=\"octree.resolution_m=0.1\"")
    if stage not in stages:
        raise ConfigError(f"SET: '{text}': no stage '{stage}'; stages: {', '.join(stages)}")
    return stage, key, value


def check_keys(config, default, where):
    for key in config:
        if key not in default:
            raise ConfigError(f"{where}: unknown key '{key}'; known keys: {', '.join(sorted(default))}")


def layer(folder, stages):
    """(stage, config, where it is from) of each file in a folder that need not exist."""
    for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
        if not name.endswith(".toml"):
            continue
        if name[:-5] not in stages:
            raise ConfigError(f"{folder}/{name}: no stage '{name[:-5]}'")
        yield name[:-5], load(os.path.join(folder, name)), f"{folder}/{name}"


def effective_configs(arguments):
    folder = arguments.configs
    names = sorted(os.listdir(os.path.join(folder, "default")))
    configs = {name[:-5]: load(os.path.join(folder, "default", name))
               for name in names if name.endswith(".toml")}
    defaults = {stage: dict(config) for stage, config in configs.items()}
    profile = os.path.join(folder, arguments.profile)
    if arguments.profile == "sites" or not os.path.isdir(profile):
        known = [name for name in sorted(os.listdir(folder)) if name != "sites"]
        raise ConfigError(f"PROFILE={arguments.profile}: no folder {profile}; profiles: {', '.join(known)}")
    layers = [] if arguments.profile == "default" else list(layer(profile, configs))
    layers += layer(arguments.site.removesuffix(".toml"), configs)
    for stage, default in defaults.items():
        if "seed" in default and stage != "synthesize":  # a recording is input, not a draw
            layers.append((stage, {"seed": arguments.seed}, "SEED"))
    for stage, config, where in layers:
        check_keys(config, defaults[stage], where)
        for key, value in config.items():
            configs[stage][key] = like(defaults[stage][key], value, f"{where}: {key}")
    for text in [item for group in arguments.set for item in shlex.split(group)] + arguments.value:
        stage, key, value = split_set(text, list(configs))
        check_keys({key: value}, defaults[stage], f"SET: {stage}")
        default = defaults[stage][key]
        configs[stage][key] = like(default, parse_value(value, default), f"SET: {stage}.{key}")
    return configs


def receipt_paths(arguments, stage):
    """Receipts of a stage's runs; those of synthesize lie with the recording, not with the map."""
    if stage == "synthesize":
        site = os.path.basename(arguments.site).removesuffix(".toml")
        return glob.glob(os.path.join(glob.escape(arguments.data), site, "synthesize_receipt.json"))
    return sorted(glob.glob(os.path.join(glob.escape(os.path.dirname(arguments.out)), stage, "receipt*.json")))


def read_receipt(path):
    """The receipt, and whether its run was committed to the end: the receipt is renamed last, so an
    output newer than it is of a later run that was killed. Folders may have been moved since."""
    with open(path, encoding="utf-8") as file:
        receipt = json.load(file)
    report = os.path.basename(path).replace("receipt", "report")
    outputs = [output["path"] for output in receipt["outputs"]]
    then = next(os.path.dirname(output) for output in outputs if os.path.basename(output) == report)
    now = os.path.dirname(path)
    newest = max(os.path.getmtime(os.path.join(now, os.path.relpath(output, then))) for output in outputs)
    return receipt, newest <= os.path.getmtime(path)


def made_with(arguments, stage, config):
    """Start (ns) of the earliest run, when every receipt of the stage names exactly this config."""
    starts = []
    for path in receipt_paths(arguments, stage):
        try:
            receipt, whole = read_receipt(path)
            if not whole or tomllib.loads(receipt["config"]) != config:
                return None
            starts.append(calendar.timegm(time.strptime(receipt["start_time"], "%Y-%m-%dT%H:%M:%SZ")))
        except (OSError, ValueError, KeyError, StopIteration):
            return None
    return min(starts) * 10**9 if starts else None


def interrupted(arguments, stages):
    """Runs (stage and suffix of the receipt) that were killed between two renames of a commit."""
    for stage in stages:
        for path in receipt_paths(arguments, stage):
            try:
                _, whole = read_receipt(path)
            except (OSError, ValueError, KeyError, StopIteration):
                whole = False
            if not whole:
                suffix = os.path.basename(path).removesuffix(".json").partition("receipt")[2]
                yield stage + suffix


def write(path, text, mtime_ns=None):
    temporary = f"{path}.{os.getpid()}.tmp"
    with open(temporary, "w", encoding="utf-8") as file:
        file.write(text)
    if mtime_ns is not None:
        os.utime(temporary, ns=(mtime_ns, mtime_ns))
    os.replace(temporary, path)


def settle(configs, arguments):
    folder = arguments.preview or arguments.out
    os.makedirs(folder, exist_ok=True)
    for stage, config in configs.items():
        text = canonical(config)
        current = os.path.join(arguments.out, stage + ".toml")
        target = os.path.join(folder, stage + ".toml")
        same = os.path.exists(current) and open(current, encoding="utf-8").read() == text
        if same and not arguments.preview:
            continue
        mtime_ns = (os.stat(current).st_mtime_ns if same else
                    made_with(arguments, stage, config))
        write(target, text, mtime_ns)
    settle_site(arguments, folder)


def settle_site(arguments, folder):
    """The site config, copied when its meaning changed."""
    name = os.path.join("site", os.path.basename(arguments.site))
    current, target = os.path.join(arguments.out, name), os.path.join(folder, name)
    same = os.path.exists(current) and load(current) == load(arguments.site)
    if same and not arguments.preview:
        return
    os.makedirs(os.path.dirname(target), exist_ok=True)
    with open(current if same else arguments.site, encoding="utf-8") as file:
        write(target, file.read(), os.stat(current).st_mtime_ns if same else None)


def recording_files(folder):
    """(path, size, time) of every file below a folder, hidden ones left out."""
    for entry in os.scandir(folder):
        if entry.name.startswith("."):
            continue
        if entry.is_dir():
            yield from recording_files(entry.path)
        else:
            status = entry.stat()
            yield entry.path, status.st_size, status.st_mtime_ns


def settle_recordings(arguments):
    """A file whose time says when the site's recordings changed last; its path.

    A folder's time does not tell of a file that was replaced in place, so the sizes and times of all
    files count. (The frames stage then compares contents: a touch reruns nothing after it.)"""
    site = load(arguments.site)
    root = os.path.join(arguments.data, site.get("root", "."))
    parts = site.get("sequence", []) + site.get("query", [])
    folders = {os.path.normpath(os.path.join(root, part.get("folder", "."))) for part in parts}
    extra = {os.path.normpath(os.path.join(root, part[key])) for part in parts
             for key in ("ground_truth", "accelerometer") if part.get(key)}
    for path in sorted(folders | extra):
        if not os.path.exists(path):
            raise ConfigError(f"site {os.path.basename(arguments.site)[:-5]}: {path} does not exist. "
                              f"datasets.md says where to get each recording; DATA={arguments.data} "
                              "is the folder it is looked for in")
    files = {(path, os.stat(path).st_size, os.stat(path).st_mtime_ns) for path in extra}
    for folder in folders:
        files.update(recording_files(folder))
    files = {(os.path.relpath(path, arguments.data), *rest) for path, *rest in files}
    digest = hashlib.sha256(repr(sorted(files)).encode()).hexdigest()
    text = f"{len(files)} files {digest}\n"
    current = os.path.join(arguments.out, "recordings")
    same = os.path.exists(current) and open(current, encoding="utf-8").read() == text
    if same and not arguments.preview:
        return current
    target = os.path.join(arguments.preview or arguments.out, "recordings")
    write(target, text, os.stat(current).st_mtime_ns if same else None)
    return target


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--configs", default="configs")
    parser.add_argument("--site", required=True, help="site config (TOML)")
    parser.add_argument("--data", required=True)
    parser.add_argument("--profile", default="default")
    parser.add_argument("--seed", default="0")
    parser.add_argument("--set", action="append", default=[], help="several, separated by spaces")
    parser.add_argument("--value", action="append", default=[], help="one STAGE.KEY=VALUE, spaces and all")
    parser.add_argument("--out", required=True)
    parser.add_argument("--preview", help="write here instead, with the times of --out")
    parser.add_argument("--synthetic", action="store_true", help="the recording is made by synthesize")
    return parser.parse_args()


def main():
    arguments = parse_arguments()
    try:
        if not arguments.seed.isdigit():
            raise ConfigError(f"SEED={arguments.seed}: give a whole number")
        arguments.seed = int(arguments.seed)
        if not os.path.exists(arguments.site):
            known = sorted(os.listdir(os.path.dirname(arguments.site)))
            raise ConfigError(f"no site config {arguments.site}; sites: "
                              + ", ".join(name[:-5] for name in known if name.endswith(".toml")))
        configs = effective_configs(arguments)
        settle(configs, arguments)
        inputs = [] if arguments.synthetic else [settle_recordings(arguments)]
    except (ConfigError, OSError, ValueError) as error:
        print(f"nightmap: {error}", file=sys.stderr)
        return 2
    print(*inputs, *("interrupted=" + run for run in interrupted(arguments, configs)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
