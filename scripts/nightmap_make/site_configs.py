# SPDX-License-Identifier: Apache-2.0
"""The copies of a site's config, config/site/ for frames and config/queries/ for the program that lists the queries, and
config/asked/ with the [[query]] tables of QUERY.

Each keeps its time while the tables that its stage reads do not change. A copy has the user's lines and names the user's file, so
that pipeline/recording/site_config.cc can name both in messages.
"""

import os

from nightmap_make.changed_files import settle
from nightmap_make.config_values import ConfigError, load
from nightmap_make.query_variable import asked_queries, tables_text

OF_MAKE = ("profile", "synthetic", "import")  # keys that choose and fill jobs
OF_SCANS = ("signal", "sensor")
# Part -> the keys that only the other stage, or make, reads.
NOT_READ = {"site": ("query", *OF_MAKE), "queries": ("sequence", *OF_SCANS, "robot_truth", "hold_out_every", *OF_MAKE), "asked": ()}
TEXT_KEYS = ("mask", "folder", "pictures", "scans", "ground_truth", "label_folder", "moving_folder", "confidence_folder", "file")


def tables(site, name, path):
    """The tables [[name]] of the site's config, which lies at `path`."""
    found = site.get(name, [])
    if not isinstance(found, list):
        raise ConfigError(f"{path}: '{name}' must be written as [[{name}]]")
    return found


def check_site(path):
    """Checks the types of the keys that Make's scripts read; the frames stage checks the whole site config."""
    site = load(path)
    _check_text(path, site, ("root", "profile"), "")
    if not isinstance(site.get("synthetic", False), bool):
        raise ConfigError(f"{path}: synthetic must be true or false")
    imports = site.get("import", {})
    if not isinstance(imports, dict):
        raise ConfigError(f"{path}: 'import' must be written as [import]")
    _check_text(path, imports, imports, " of [import]")
    truth = site.get("robot_truth", {})
    if not isinstance(truth, dict):
        raise ConfigError(f"{path}: 'robot_truth' must be written as [robot_truth]")
    _check_text(path, truth, truth, " of [robot_truth]")
    for kind in ("camera", "sequence", "query", "signal"):
        for table in tables(site, kind, path):
            if not isinstance(table, dict):
                raise ConfigError(f"{path}: '{kind}' must be written as [[{kind}]]")
            _check_text(path, table, TEXT_KEYS, f" of [[{kind}]]")


def _check_text(path, table, names, where):
    for name in names:
        if not isinstance(table.get(name, ""), str):
            raise ConfigError(f"{path}: {name}{where} must be text in quotation marks")


def site_parts(request):
    path = request.site
    try:
        with open(path, encoding="utf-8") as file:
            text = file.read()
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: not UTF-8 text ({error.reason}): store it as UTF-8")
    site = load(path)
    text += f"\n# This was the text of {path}\n"
    queries = asked_queries(request, site.get("root", "."))
    return {"site": (text, site), "queries": (text, site), "asked": (tables_text(queries), {"query": queries})}


def settle_site(part, text, site, request):
    name = os.path.join(part, os.path.basename(request.site))
    current, target = os.path.join(request.config_dir, name), os.path.join(request.work_dir, name)
    settle(current, target, text, means_same=lambda path: _is_same_part(path, site, part, request.asks))


def _is_same_part(path, site, part, asks):
    """Whether an earlier call wrote the same for this stage; a damaged file is not the same."""
    if not os.path.exists(path):
        return False
    try:
        return _of_part(load(path), part, asks) == _of_part(site, part, asks)
    except (ConfigError, TypeError):
        return False


def _of_part(site, part, asks):
    """The keys of the site that the stage of a part reads. (Queries are numbered after the recordings.)"""
    read = OF_SCANS if (part, asks) == ("queries", "scans") else ()
    taken = {key: value for key, value in site.items() if key in read or key not in NOT_READ[part]}
    return taken | ({"num_sequences": len(site.get("sequence", []))} if part == "queries" else {})
