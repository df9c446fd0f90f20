#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""use_objects: makes a file of objects, drawn on the page of a site, the one that its next make takes.

The file becomes the one that [import] of the site's config names as objects; where it names none, DATA/<site>_objects.yaml, and the
config gets that name. A file that stood there and differs is kept as NAME.old.
Exit codes: 0 done; 1 unreadable file; 2 wrong command line or config.
"""

import argparse
import json
import math
import os
import re
import sys
import tomllib
from pathlib import Path

import yaml

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from nightmap_eval.artifacts import write_atomic  # noqa: E402
from nightmap_make.imports import check_import_keys, check_import_path  # noqa: E402
from nightmap_site.script_errors import DataError, printable, run_main  # noqa: E402
from nightmap_site.toml_file import PipelineError, read_toml  # noqa: E402

FORMAT, VERSION = "nightmap objects", "1"
NUMBERS = ("x_m", "y_m", "size_x_m", "size_y_m", "angle_deg")


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", help="objects.yaml, as the page wrote it")
    parser.add_argument("--site", required=True, type=Path, help="config of the site")
    parser.add_argument("--data", required=True, type=Path, help="folder of the recordings")
    parser.add_argument("--profile", help="profile of the site, instead of the one that its config names")
    arguments = parser.parse_args()
    if not arguments.file:
        parser.error("name the file that the page wrote: make use-objects SITE=<site> OBJECTS=~/Downloads/objects.yaml")
    return arguments


def objects_text(path):
    try:
        text = Path(path).expanduser().read_text(encoding="utf-8")
    except (OSError, ValueError, RuntimeError) as error:
        raise DataError(f"OBJECTS={path}: {error}; name the file that the page of the site wrote") from None
    try:
        check_objects(text)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise DataError(f"{path}: {error}; download it again from the page of the site") from None
    return text


def check_objects(text):
    """Raises ValueError or YAMLError for a file that is cut off, or of which an object lacks a key. Its stages check the values."""
    file = yaml.load(text, Loader=yaml.BaseLoader)  # every value is text
    if not isinstance(file, dict) or file.get("format") != FORMAT:
        raise ValueError(f"its format is not \"{FORMAT}\"")
    if file.get("version") != VERSION:
        raise ValueError(f"its version is not {VERSION}")
    objects = file.get("objects")
    if not isinstance(objects, list) or not text.endswith("\n"):
        raise ValueError("it is cut off, or its objects are no list")
    for number, item in enumerate(objects, 1):
        missing = [key for key in ("name", *NUMBERS) if not (isinstance(item, dict) and item.get(key))]
        if missing:
            raise ValueError(f"object {number} has no {', '.join(missing)}")
        if not all(math.isfinite(float(item[key])) for key in NUMBERS):
            raise ValueError(f"object {number} has a number that is not finite")


def with_objects(config, name):
    """The text of a site's config with objects = name below [import]."""
    line = f"objects = {json.dumps(name)}\n"
    header = re.search(r"^[ \t]*\[[ \t]*import[ \t]*\][^\n]*\n", config, re.MULTILINE)
    if header:
        return config[:header.end()] + line + config[header.end():]
    return config.removesuffix("\n") + f"\n\n[import]\n{line}"


def named_in(site, profile, data):
    """The name of the file of objects in DATA, and the text of the config that has to be written for it, or None."""
    tables = read_toml(str(site))
    imports = tables.get("import", {})
    name = imports.get("objects", f"{site.stem}_objects.yaml")
    check_import_keys(site, {"objects": name}, profile or tables.get("profile", "default"), is_asked=False)
    check_import_path(site, data, "objects", name)
    if "objects" in imports:
        return name, None
    config = with_objects(site.read_text(encoding="utf-8"), name)
    if tomllib.loads(config) != tables | {"import": imports | {"objects": name}}:
        raise ValueError("[import] is no table of its own")
    return name, config


def put(path, text):
    """Writes the file of objects; another one that stood there is kept."""
    before = path.read_bytes() if path.is_file() else None
    if before not in (None, text.encode()):
        write_atomic(f"{path}.old", before)
        print(f"{path}.old: the objects that were in use")
    write_atomic(path, text)


def main():
    arguments = parse_arguments()
    text = objects_text(arguments.file)
    try:
        name, config = named_in(arguments.site, arguments.profile, arguments.data)
    except PipelineError as error:
        refuse(error)
    except (ValueError, AttributeError, TypeError) as error:
        refuse(f"{arguments.site}: {error}; write objects = \"...\" below [import] by hand")
    put(arguments.data / name, text)
    if config:
        write_atomic(arguments.site, config)
        print(f"{arguments.site}: [import] names them: objects = \"{name}\"")
    print(f"objects of {arguments.site.stem}: {arguments.data / name}; the next make takes them")


def refuse(error):
    print(f"error: {printable(error)}", file=sys.stderr)
    sys.exit(2)


if __name__ == "__main__":
    run_main(main)
