# SPDX-License-Identifier: Apache-2.0
"""The files of other systems that [import] of a site's config names. Their paths stand in the rules of the site."""

import os
import re

from nightmap_site.declaration import import_keys, profiles
from nightmap_site.toml_file import PipelineError

# Neither Make nor a shell interprets these characters.
PATH = re.compile(r"[\w.@+-]+(?:/[\w.@+-]+)*")
MAX_BYTES = 1 << 20  # of a file that names another


def _yaml():
    """The module, only where there is a map: make starts Python without the system's packages, because to find them takes time."""
    import site

    site.main()
    try:
        import yaml
    except ImportError:
        raise PipelineError("the package python3-yaml is missing, which reads ROS maps: run make deps") from None
    return yaml


def image_of_map(text):
    """The picture that the YAML of a ROS map names, or None. Builds no values, which tags could ask for."""
    if "image" not in text:
        return None  # a file of objects, which may be long
    yaml = _yaml()
    try:
        nodes = [node for node in yaml.compose_all(text, Loader=yaml.SafeLoader) if isinstance(node, yaml.MappingNode)]
    except (yaml.YAMLError, ValueError, RecursionError):
        return None  # its stage says why
    named = [value.value for node in nodes for key, value in node.value if key.value == "image"]
    return named[0] if named and isinstance(named[0], str) else None


def network_of_model(text):
    found = re.search(r"""^\s*network\s*=\s*["'](.*?)["']""", text, re.MULTILINE)
    return found and found[1]


# The file that a file names, or None.
NAMED = {".yaml": image_of_map, ".yml": image_of_map, ".toml": network_of_model}


def check_import_keys(site_config, imports, profile, is_asked):
    """Raises PipelineError for a key that nothing reads: one of no profile, or of another profile than the site's. With PROFILE of
    make (is_asked) a site may have the keys of any profile, as to be mapped without what another one takes."""
    taken = import_keys("configs", profile)
    for key in imports:
        if key in taken:
            continue
        where = f"{site_config}: [import] {key}"
        keys_of = {name: import_keys("configs", name) for name in profiles("configs")}
        takers = [name for name, keys in keys_of.items() if key in keys]
        if takers and is_asked:
            continue
        if takers:
            raise PipelineError(f"{where}: the profile '{profile}' takes no {key}: remove it, or name a profile that does: "
                                + " or ".join(f'profile = "{name}"' for name in takers))  # fmt: skip
        import difflib  # takes milliseconds, which every make would spend

        known = sorted(taken) or sorted(set().union(*keys_of.values()))
        nearest = difflib.get_close_matches(key, known, n=1)
        raise PipelineError(f"{where}: there is no such key: " + (f"write {nearest[0]}" if nearest else "the keys are " + ", ".join(known)))


def check_import_path(site_config, data, key, path):
    """Raises PipelineError for a path outside of DATA, or one that Make would interpret."""
    where = f"{site_config}: [import] {key} = {path!r}"
    if os.path.isabs(path) or os.pardir in path.split("/"):
        raise PipelineError(f"{where} leads out of DATA ({data}): give a path below it; a link there may lead anywhere")
    if not PATH.fullmatch(path):
        raise PipelineError(f"{where}: Make reads this path, so it may hold letters, digits and _ . @ + - / only: rename the file "
                            "or make a link to it")  # fmt: skip


def check_imports(site_config, data, imports):
    """Raises PipelineError for a file that is missing, and as check_import_path."""
    for key, path in imports.items():
        check_import_path(site_config, data, key, path)
        if not os.path.isfile(os.path.join(data, path)):
            raise PipelineError(f"{site_config}: [import] {key} = {path!r}: {data}/{path} does not exist, or is no file: give its path "
                                "relative to DATA")  # fmt: skip


def files_of(path):
    named_in = NAMED.get(os.path.splitext(path)[1])
    if not named_in:
        return [path]
    try:
        with open(path, encoding="utf-8-sig", errors="surrogateescape") as file:
            named = named_in(file.read(MAX_BYTES))
    except OSError:
        return [path]
    return [path, os.path.join(os.path.dirname(path), named)] if named and "\0" not in named else [path]
