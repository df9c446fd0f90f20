# SPDX-License-Identifier: Apache-2.0
"""QUERY, CAMERA and FOV_DEG of make: the [[query]] tables of the pictures to locate in one run."""

import os

from nightmap_make.config_values import ConfigError, toml_value, words


def asked_queries(request, root):
    """The [[query]] of each path of QUERY; root: of the site's config."""
    paths, camera = words("QUERY", request.query), _camera(request)
    if camera and not paths:
        raise ConfigError("CAMERA and FOV_DEG describe the pictures of QUERY: name some")
    for path in paths:
        _check_path(path)
    data = os.path.realpath(request.data)  # absolute: how many `..` lead out does not depend on where we are
    from_root = [os.path.relpath(os.path.join(data, _from_data(path, request.data)), os.path.join(data, root)) for path in paths]
    return [{"layout": "pictures", "pictures": path} | camera for path in from_root]


def tables_text(queries):
    """TOML text of [[query]] tables."""
    return "".join("[[query]]\n" + "".join(f"{key} = {toml_value(query[key])}\n" for key in query) for query in queries)


def _camera(request):
    camera = {"camera": request.camera} if request.camera else {}
    if request.fov_deg:
        try:
            camera["horizontal_fov_deg"] = float(request.fov_deg)
        except ValueError:
            raise ConfigError(f"FOV_DEG={request.fov_deg}: give a number of degrees")
    return camera


def _check_path(path):
    # Surrogates stand for bytes that are not UTF-8.
    if any(c < " " or c == "\x7f" or "\ud800" <= c <= "\udfff" for c in path):
        raise ConfigError(f"QUERY: the name {path!r} is not UTF-8 or holds control characters: rename it")
    if not os.path.exists(path):
        raise ConfigError(f"QUERY: {path} does not exist: name pictures, folders of them or .txt lists")


def _from_data(path, data):
    """`path` relative to the data folder. `..` out of a folder that is a link leads out of its target."""
    inside = os.path.relpath(path, data)
    if inside.split(os.sep)[0] != os.pardir:
        return inside
    folder, name = os.path.split(os.path.abspath(path))
    return os.path.relpath(os.path.join(os.path.realpath(folder), name), os.path.realpath(data))
