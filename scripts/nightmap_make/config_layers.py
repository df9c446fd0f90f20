# SPDX-License-Identifier: Apache-2.0
"""The effective configs, and the source of each value. A config has the name of its program, or the one that `options` of a job
says. Later layers win; a profile comes after its pieces:

    configs/<folder>/default/<name>.toml < configs/<profile>/<name>.toml < configs/sites/<site>/<name>.toml < SEED < SET NAME.KEY=VALUE
"""

import os

from nightmap_make.config_values import ConfigError, like, load, parse_value, split_set, words
from nightmap_site.declaration import folders, profiles


def effective_configs(request):
    """Name -> its effective options, and name -> key -> source: a file or a make variable."""
    known = profiles(request.configs)
    if request.profile not in known:  # a path, for example
        raise ConfigError(f"{request.profile_from}: no profile {request.profile!r} in {request.configs}; profiles: {', '.join(known)}")
    paths = _default_files(request)
    defaults = {stage: load(path) for stage, path in paths.items()}
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
            raise ConfigError(f"{folder}/{name}: no stage '{name[:-5]}'")
        if name[:-5] in stages:
            yield name[:-5], load(os.path.join(folder, name)), f"{folder}/{name}"


def _check_keys(config, default, where):
    for key in config:
        if key not in default:
            raise ConfigError(f"{where}: unknown key '{key}'; known keys: {', '.join(sorted(default))}")
