# SPDX-License-Identifier: Apache-2.0
"""TOML files of declarations and configs, and the error that a wrong one is."""

import functools
import tomllib


class PipelineError(Exception):
    """A mistake in the declaration, a config or a variable of make, which the message names with the remedy: nothing was run. Exit
    code 2."""


def read_toml(path):
    """The tables of a file, to be left as they are; the dictionary of them is the caller's own."""
    try:
        with open(path, "rb") as file:
            return dict(_parsed(file.read()))
    except FileNotFoundError:
        raise PipelineError(f"{path}: there is no such file") from None
    except RecursionError:
        raise PipelineError(f"{path}: not valid TOML: nested too deep") from None
    except UnicodeDecodeError:
        raise PipelineError(f"{path}: not valid TOML: not UTF-8 text; store it as UTF-8") from None
    except ValueError as error:
        raise PipelineError(f"{path}: not valid TOML: {error}") from None


@functools.cache  # the pipeline is read once per profile
def _parsed(data):
    return tomllib.loads(data.decode())
