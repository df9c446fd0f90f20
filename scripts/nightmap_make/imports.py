# SPDX-License-Identifier: Apache-2.0
"""The files of other systems that [import] of a site's config names. Their paths stand in the rules of the site."""

import os
import re

from nightmap_site.declaration import PipelineError, import_keys

# Neither Make nor a shell interprets these characters.
PATH = re.compile(r"[\w.@+-]+(?:/[\w.@+-]+)*")
# The file that such a file names: the image of a ROS map, the network of a model.
NAMED = {
    ".yaml": re.compile(r"""^\s*image\s*:\s*["']?(.*?)["']?\s*(?:\s#.*)?$""", re.MULTILINE),
    ".toml": re.compile(r"""^\s*network\s*=\s*["'](.*?)["']""", re.MULTILINE),
}
NAMED[".yml"] = NAMED[".yaml"]


def check_import_keys(site_config, imports, profile, is_asked):
    """Raises PipelineError for a key that nothing reads: one of no profile, or of another profile than the site's. With PROFILE of
    make (is_asked) a site may have the keys of any profile, as to be mapped without what another one takes."""
    taken = import_keys("configs", profile)
    for key in imports:
        if key in taken:
            continue
        where = f"{site_config}: [import] {key}"
        profiles = {name: import_keys("configs", name) for name in sorted(os.listdir("configs"))}
        takers = [name for name, keys in profiles.items() if key in keys]
        if takers and is_asked:
            continue
        if takers:
            raise PipelineError(f"{where}: the profile '{profile}' takes no {key}: remove it, or name a profile that does: "
                                + " or ".join(f'profile = "{name}"' for name in takers))  # fmt: skip
        import difflib  # takes milliseconds, which every make would spend

        known = sorted(taken) or sorted(set().union(*profiles.values()))
        nearest = difflib.get_close_matches(key, known, n=1)
        raise PipelineError(f"{where}: there is no such key: " + (f"write {nearest[0]}" if nearest else "the keys are " + ", ".join(known)))


def check_imports(site_config, data, imports):
    """Raises PipelineError for a file that is missing, outside of DATA, or whose name Make would interpret."""
    for key, path in imports.items():
        where = f"{site_config}: [import] {key} = {path!r}"
        if os.path.isabs(path) or os.pardir in path.split("/"):
            raise PipelineError(f"{where} leads out of DATA ({data}): give a path below it; a link there may lead anywhere")
        if not PATH.fullmatch(path):
            raise PipelineError(f"{where}: Make reads this path, so it may hold letters, digits and _ . @ + - / only: rename the file "
                                "or make a link to it")  # fmt: skip
        if not os.path.isfile(os.path.join(data, path)):
            raise PipelineError(f"{where}: {data}/{path} does not exist, or is no file: give its path relative to DATA")


def files_of(path):
    """The file, and the one that it names."""
    pattern = NAMED.get(os.path.splitext(path)[1])
    if not pattern:
        return [path]
    try:
        with open(path, encoding="utf-8", errors="surrogateescape") as file:
            found = pattern.search(file.read(1 << 16))
    except OSError:
        return [path]
    return [path, os.path.join(os.path.dirname(path), found[1])] if found and "\0" not in found[1] else [path]
