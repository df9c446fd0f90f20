#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""use_objects: makes a file of objects, drawn on the page of a site, the one that its next make takes.

The file becomes the one that [import] of the site's config names as objects; where it names none, DATA/<site>_objects.yaml, and the
config gets that name.
Exit codes: 0 done; 1 unreadable file; 2 wrong command line or config.
"""

import argparse
import json
import os
import re
import sys
import tomllib
from pathlib import Path

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from nightmap_site.declaration import PipelineError, read_toml  # noqa: E402
from nightmap_site.script_errors import DataError, run_main  # noqa: E402

FORMAT = "format: nightmap objects\n"


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", help="objects.yaml, as the page wrote it")
    parser.add_argument("--site", required=True, type=Path, help="config of the site")
    parser.add_argument("--data", required=True, type=Path, help="folder of the recordings")
    arguments = parser.parse_args()
    if not arguments.file:
        parser.error("name the file that the page wrote: make use-objects SITE=<site> OBJECTS=~/Downloads/objects.yaml")
    return arguments


def objects_text(path):
    try:
        text = Path(path).expanduser().read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        raise DataError(f"OBJECTS={path}: {error}; name the file that the page of the site wrote") from None
    if not text.startswith(FORMAT):
        raise DataError(f"{path}: begins otherwise than with \"{FORMAT.strip()}\"; download it from the page of the site")
    return text


def with_objects(config, name):
    """The text of a site's config with objects = name below [import]."""
    line = f"objects = {json.dumps(name)}\n"
    header = re.search(r"^[ \t]*\[[ \t]*import[ \t]*\][^\n]*\n", config, re.MULTILINE)
    if header:
        return config[:header.end()] + line + config[header.end():]
    return config.removesuffix("\n") + f"\n\n[import]\n{line}"


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    new = path.with_name(f"{path.name}.new")
    new.write_text(text, encoding="utf-8")
    new.replace(path)


def main():
    arguments = parse_arguments()
    text = objects_text(arguments.file)
    try:
        tables = read_toml(str(arguments.site))
        name = tables.get("import", {}).get("objects")
        if name is None:
            name = f"{arguments.site.stem}_objects.yaml"
            config = with_objects(arguments.site.read_text(encoding="utf-8"), name)
            if tomllib.loads(config) != tables | {"import": tables.get("import", {}) | {"objects": name}}:
                raise ValueError("[import] is no table of its own")
            write(arguments.data / name, text)
            write(arguments.site, config)
            print(f"{arguments.site}: [import] names them: objects = \"{name}\"")
        else:
            write(arguments.data / name, text)
    except PipelineError as error:
        raise DataError(str(error)) from None
    except (ValueError, AttributeError, TypeError) as error:
        raise DataError(f"{arguments.site}: {error}; write objects = \"...\" below [import] by hand") from None
    print(f"objects of {arguments.site.stem}: {arguments.data / name}; the next make takes them")


if __name__ == "__main__":
    run_main(main)
