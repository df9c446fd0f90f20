# SPDX-License-Identifier: Apache-2.0
"""Values of configs: reads TOML, writes one canonical form of it, and gives the text of a variable of make the type of an option."""

import contextlib
import json
import shlex
import tomllib

from nightmap_site.script_errors import os_error_text

MAX_INTEGER = 2**63 - 1
HEADER = "# Written by make; edit configs/ or use SET instead.\n"


class ConfigError(Exception):
    """A mistake in a config or a variable of make; the message names it and the remedy."""


@contextlib.contextmanager
def plain_errors():
    """Turns the exceptions of a wrong config or an unreadable file into a ConfigError."""
    try:
        yield
    except OSError as error:
        raise ConfigError(os_error_text(error, "correct its permissions or its place")) from None
    except RecursionError:
        raise ConfigError("a value of configs/ or SET is nested too deep: correct what you changed last") from None
    except ValueError as error:
        raise ConfigError(str(error)) from None


def load(path):
    try:
        with open(path, "rb") as file:
            return tomllib.load(file)
    except RecursionError:
        raise ConfigError(f"{path}: not valid TOML: nested too deep")
    except UnicodeDecodeError:
        raise ConfigError(f"{path}: not valid TOML: not UTF-8 text; store it as UTF-8")
    except ValueError as error:
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
    """The one text of a config: sorted keys, no comments."""
    return HEADER + "".join(f"{key} = {toml_value(config[key])}\n" for key in sorted(config))


def like(default, value, where):
    """`value` with the type of `default`, so that 1 and 1.0 mean the same to a float option."""
    if isinstance(default, list) and isinstance(value, list):
        return [like(default[0], item, where) if default else _plain(item, where) for item in value]
    if isinstance(default, float) and type(value) is int:
        return float(value)
    if type(value) is int and abs(value) > MAX_INTEGER:
        raise ConfigError(f"{where} is larger than any whole number here: {toml_value(value)[:30]}...")
    if type(default) is not type(value):
        raise ConfigError(f"{where} must be like its default {toml_value(default)}, but is {toml_value(value)[:100]}")
    return value


def _plain(value, where):
    """An item of a list without a default: a number, a text, or a list of them."""
    if isinstance(value, list):
        return [_plain(item, where) for item in value]
    if not isinstance(value, (bool, int, float, str)):
        raise ConfigError(f"{where}: {value!r} is neither a number, a text nor a list")
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
        raise ConfigError(f"SET: '{text}' is not STAGE.KEY=VALUE, as in SET=\"octree.resolution_m=0.1\"")
    if stage not in stages:
        raise ConfigError(f"SET: '{text}': no stage '{stage}'; stages: {', '.join(stages)}")
    return stage, key, value


def words(name, text):
    """The words of a make variable; shell quotation marks keep words together."""
    try:
        return shlex.split(text)
    except ValueError as error:
        raise ConfigError(f"{name}: {text}: {str(error).lower()}")
