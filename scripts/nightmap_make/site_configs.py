# SPDX-License-Identifier: Apache-2.0
"""The copies of a site's config, config/site/ for frames and config/queries/ for the program that lists the queries, and
config/asked/ with the [[query]] tables of QUERY.

Each keeps its time while the tables that its stage reads do not change. A copy has the user's lines and names the user's file, so
that pipeline/recording/site_config.cc can name both in messages.
"""

import contextlib
import math
import os

from nightmap_make.changed_files import settle
from nightmap_make.config_values import toml_value, words
from nightmap_site.toml_file import PipelineError, read_toml

OF_MAKE = ("profile", "synthetic", "import")  # keys that choose and fill jobs
OF_SCANS = ("signal", "sensor")
# Part -> the keys that only the other stage, or make, reads.
NOT_READ = {"site": ("query", *OF_MAKE), "queries": ("sequence", *OF_SCANS, "robot_truth", "hold_out_every", *OF_MAKE), "asked": ()}
TEXT_KEYS = ("mask", "folder", "pictures", "scans", "ground_truth", "label_folder", "moving_folder", "confidence_folder", "file")


def tables(site, name, path):
    """The tables [[name]] of the site's config, which lies at `path`."""
    found = site.get(name, [])
    if not isinstance(found, list):
        raise PipelineError(f"{path}: '{name}' must be written as [[{name}]]")
    return found


def check_site(path):
    """Checks the types of the keys that Make's scripts read; the frames stage checks the whole site config."""
    site = read_toml(path)
    _check_text(path, site, ("root", "profile"), "")
    if not isinstance(site.get("synthetic", False), bool):
        raise PipelineError(f"{path}: synthetic must be true or false")
    for name in ("import", "robot_truth"):
        table = site.get(name, {})
        if not isinstance(table, dict):
            raise PipelineError(f"{path}: '{name}' must be written as [{name}]")
        _check_text(path, table, table, f" of [{name}]")
    for kind in ("camera", "sequence", "query", "signal"):
        for table in tables(site, kind, path):
            if not isinstance(table, dict):
                raise PipelineError(f"{path}: '{kind}' must be written as [[{kind}]]")
            _check_text(path, table, TEXT_KEYS, f" of [[{kind}]]")


def _check_text(path, table, names, where):
    for name in names:
        if not isinstance(table.get(name, ""), str):
            raise PipelineError(f"{path}: {name}{where} must be text in quotation marks")


def site_parts(request):
    path = request.site
    try:
        with open(path, encoding="utf-8") as file:
            text = file.read()
    except UnicodeDecodeError as error:
        raise PipelineError(f"{path}: not UTF-8 text ({error.reason}): store it as UTF-8")
    site = read_toml(path)
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
        return _of_part(read_toml(path), part, asks) == _of_part(site, part, asks)
    except (PipelineError, TypeError):
        return False


def _of_part(site, part, asks):
    """The keys of the site that the stage of a part reads. (Queries are numbered after the recordings.)"""
    read = OF_SCANS if (part, asks) == ("queries", "scans") else ()
    taken = {key: value for key, value in site.items() if key in read or key not in NOT_READ[part]}
    return taken | ({"num_sequences": len(site.get("sequence", []))} if part == "queries" else {})


def asked_queries(request, root):
    """The [[query]] of each path of QUERY; root: of the site's config. CAMERA and FOV_DEG describe pictures; NEAR, NEAR_RADIUS and TURN
    describe scans."""
    paths = words("QUERY", request.query)
    key, about = ("scans", _of_scans(request, paths)) if request.asks == "scans" else ("pictures", _of_pictures(request, paths))
    for path in paths:
        _check_path(path, request.asks)
    data = os.path.realpath(request.data)  # absolute: how many `..` lead out does not depend on where we are
    from_root = [os.path.relpath(os.path.join(data, _from_data(path, request.data)), os.path.join(data, root)) for path in paths]
    layout = {"layout": "pictures"} if key == "pictures" else {}
    return [layout | {key: path} | about for path in from_root]


def tables_text(queries):
    return "".join("[[query]]\n" + "".join(f"{key} = {toml_value(query[key])}\n" for key in query) for query in queries)


def _of_pictures(request, paths):
    if request.near or request.near_radius or request.turn:
        raise PipelineError(f"NEAR, NEAR_RADIUS and TURN describe laser scans; site {request.site_name} with profile {request.profile} "
                          "is asked for pictures: leave them out, or choose profile laser")  # fmt: skip
    if (request.camera or request.fov_deg) and not paths:
        raise PipelineError("CAMERA and FOV_DEG describe the pictures of QUERY: name some")
    camera = {"camera": request.camera} if request.camera else {}
    if request.fov_deg:
        try:
            camera["horizontal_fov_deg"] = float(request.fov_deg)
        except ValueError:
            raise PipelineError(f"FOV_DEG={request.fov_deg}: give a number of degrees")
    return camera


def _of_scans(request, paths):
    if request.camera or request.fov_deg:
        raise PipelineError(f"CAMERA and FOV_DEG describe pictures; site {request.site_name} with profile {request.profile} is asked "
                          "for laser scans: leave them out")  # fmt: skip
    if (request.near or request.near_radius or request.turn) and not paths:
        raise PipelineError("NEAR, NEAR_RADIUS and TURN describe the laser scans of QUERY: name a log of them")
    if request.turn not in ("", "0", "1"):
        raise PipelineError(f"TURN={request.turn}: give 1 where the robot turned on the spot, else 0")
    turn = {"turn": True} if request.turn == "1" else {}
    if not request.near:
        if request.near_radius:
            raise PipelineError("NEAR_RADIUS is the radius around NEAR: give NEAR=\"x,y\", too")
        return turn
    near = {"near_m": _numbers("NEAR", request.near, 2, "x and y in the map in metres, as in NEAR=\"3.5,-2\"")}
    if not request.near_radius:
        return turn | near
    [radius_m] = _numbers("NEAR_RADIUS", request.near_radius, 1, "a number of metres above 0")
    if radius_m <= 0:
        raise PipelineError(f"NEAR_RADIUS={request.near_radius}: give a number of metres above 0")
    return turn | near | {"near_radius_m": radius_m}


def _numbers(name, text, count, what):
    numbers = []
    with contextlib.suppress(ValueError):
        numbers = [float(word) for word in text.split(",")]
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise PipelineError(f"{name}={text}: give {what}")
    return numbers


def _check_path(path, asks):
    # Surrogates stand for bytes that are not UTF-8.
    if any(c < " " or c == "\x7f" or "\ud800" <= c <= "\udfff" for c in path):
        raise PipelineError(f"QUERY: the name {path!r} is not UTF-8 or holds control characters: rename it")
    if not os.path.exists(path):
        what = "logs of laser scans" if asks == "scans" else "pictures, folders of them or .txt lists"
        raise PipelineError(f"QUERY: {path} does not exist: name {what}")
    if asks == "scans" and os.path.isdir(path):
        raise PipelineError(f"QUERY: {path} is a folder: name logs of laser scans")


def _from_data(path, data):
    """`path` relative to the data folder. `..` out of a folder that is a link leads out of its target."""
    inside = os.path.relpath(path, data)
    if inside.split(os.sep)[0] != os.pardir:
        return inside
    folder, name = os.path.split(os.path.abspath(path))
    return os.path.relpath(os.path.join(os.path.realpath(folder), name), os.path.realpath(data))
