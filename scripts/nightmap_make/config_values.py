# SPDX-License-Identifier: Apache-2.0
"""Values of configs: reads TOML, writes one canonical form of it, and gives the text of a variable of make the type of an option."""

import contextlib
import json
import os
import shlex
import tomllib

from nightmap_site.declaration import folders, profiles
from nightmap_site.script_errors import os_error_text
from nightmap_site.toml_file import PipelineError, read_toml

MAX_INTEGER = 2**63 - 1
HEADER = "# Written by make; edit configs/ or use SET instead.\n"


@contextlib.contextmanager
def plain_errors():
    """Turns the exceptions of a wrong config or an unreadable file into a PipelineError."""
    try:
        yield
    except OSError as error:
        raise PipelineError(os_error_text(error, "correct its permissions or its place")) from None
    except RecursionError:
        raise PipelineError("a value of configs/ or SET is nested too deep: correct what you changed last") from None
    except ValueError as error:
        raise PipelineError(str(error)) from None


def toml_value(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return "[" + ", ".join(toml_value(item) for item in value) + "]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    return repr(value)


def canonical(config):
    """The one text of a config: sorted keys, no comments."""
    return HEADER + "".join(f"{key} = {toml_value(config[key])}\n" for key in sorted(config))


def like(default, value, where):
    """`value` with the type of `default`, so that 1 and 1.0 mean the same to a float option."""
    if isinstance(default, list) and isinstance(value, list):
        return [like(default[0], item, where) if default else _plain(item, where) for item in value]
    if isinstance(default, float) and type(value) is int:
        return float(value)
    if type(value) is int and abs(value) > MAX_INTEGER:
        raise PipelineError(f"{where} is larger than any whole number here: {toml_value(value)[:30]}...")
    if type(default) is not type(value):
        raise PipelineError(f"{where} must be like its default {toml_value(default)}, but is {toml_value(value)[:100]}")
    return value


def _plain(value, where):
    """An item of a list without a default: a number, a text, or a list of them."""
    if isinstance(value, list):
        return [_plain(item, where) for item in value]
    if not isinstance(value, (bool, int, float, str)):
        raise PipelineError(f"{where}: {value!r} is neither a number, a text nor a list")
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
    """(stage, key, text of the value) of STAGE.KEY=VALUE."""
    name, equals, value = text.partition("=")
    stage, dot, key = name.partition(".")
    if not (equals and dot and stage and key and value):
        raise PipelineError(f"SET: '{text}' is not STAGE.KEY=VALUE, as in SET=\"octree.resolution_m=0.1\"")
    if stage not in stages:
        raise PipelineError(f"SET: '{text}': no stage '{stage}'; stages: {', '.join(stages)}")
    return stage, key, value


def words(name, text):
    """The words of a make variable; shell quotation marks keep words together."""
    try:
        return shlex.split(text)
    except ValueError as error:
        raise PipelineError(f"{name}: {text}: {str(error).lower()}")


def effective_configs(request):
    """Name -> its effective options, and name -> key -> source: a file or a make variable. A config has the name of its program, or the
    one that `options` of a job says. Later layers win; a profile comes after its pieces:

    configs/<folder>/default/<name>.toml < configs/<profile>/<name>.toml < configs/sites/<site>/<name>.toml < SEED < SET NAME.KEY=VALUE"""
    known = profiles(request.configs)
    if request.profile not in known:  # a path, for example
        raise PipelineError(f"{request.profile_from}: no profile {request.profile!r} in {request.configs}; profiles: {', '.join(known)}")
    paths = _default_files(request)
    defaults = {stage: read_toml(path) for stage, path in paths.items()}
    configs = {stage: dict(config) for stage, config in defaults.items()}
    sources = {stage: dict.fromkeys(config, paths[stage]) for stage, config in configs.items()}
    for stage, config, where in _layers(request, defaults):
        _check_keys(config, defaults[stage], where)
        for key, value in config.items():
            configs[stage][key] = like(defaults[stage][key], value, f"{where}: {key}")
            sources[stage][key] = where
    for text in words("SET", request.set) + request.ends:
        stage, key, value = split_set(text, list(configs))
        _check_keys({key: value}, defaults[stage], f"SET: {stage}")
        default = defaults[stage][key]
        configs[stage][key] = like(default, parse_value(value, default), f"SET: {stage}.{key}")
        sources[stage][key] = "SET"
    return configs, sources


def _has_options(name):
    return name.endswith(".toml") and name != "pipeline.toml"


def _default_files(request):
    """Name -> file of its defaults, of the default profile's folders and of those of the profile."""
    found, of_default = {}, folders(request.configs, "default", ())
    for place in dict.fromkeys(os.path.join(request.configs, name, "default") for name in ("", *of_default, *_folders(request))):
        for name in sorted(os.listdir(place)) if os.path.isdir(place) else []:
            if _has_options(name):
                found[name[:-5]] = os.path.join(place, name)
    return found


def _folders(request):
    """Those of the pieces that the profile is made of, and its own, the last."""
    return folders(request.configs, request.profile, request.imports)


def makes_recordings(program):
    """Whether the program makes up what other sites bring along: "synthesize", and those of profiles by their names."""
    return program.startswith("synthesize")


def _layers(request, defaults):
    """(stage, config, source) of profile, site and seed."""
    places = [os.path.join(request.configs, name) for name in _folders(request) if name != "default"]
    layers = [layer for place in [*places, request.site.removesuffix(".toml")] for layer in _folder(place, defaults, request.configs)]
    for stage, default in defaults.items():
        if "seed" in default and not makes_recordings(request.program_of(stage)):  # a recording is input, not a draw
            layers.append((stage, {"seed": int(request.seed)}, "SEED"))
    return layers


def _folder(folder, stages, configs):
    """(stage, config, path) of each file in a folder; none when the folder does not exist. Values of programs that only other profiles
    run are for those."""
    for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
        if not _has_options(name):
            continue
        if name[:-5] not in stages and not any(os.path.exists(f"{configs}/{other}/default/{name}") for other in os.listdir(configs)):
            raise PipelineError(f"{folder}/{name}: no stage '{name[:-5]}'")
        if name[:-5] in stages:
            yield name[:-5], read_toml(os.path.join(folder, name)), f"{folder}/{name}"


def _check_keys(config, default, where):
    for key in config:
        if key not in default:
            raise PipelineError(f"{where}: unknown key '{key}'; known keys: {', '.join(sorted(default))}")
