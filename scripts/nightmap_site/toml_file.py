# SPDX-License-Identifier: Apache-2.0
"""TOML files of declarations and configs, and the error that a wrong one is."""

import functools
import tomllib


class PipelineError(Exception):
    """The declaration or a config is wrong: a usage error, exit code 2."""


def read_toml(path):
    """The tables of a file, to be left as they are; the dictionary of them is the caller's own."""
    try:
        with open(path, "rb") as file:
            return dict(_parsed(file.read()))
    except FileNotFoundError:
        raise PipelineError(f"{path}: there is no such file") from None
    except (ValueError, RecursionError) as error:
        raise PipelineError(f"{path}: not valid TOML: {error}") from None


@functools.cache  # the pipeline is read once per profile
def _parsed(data):
    return tomllib.loads(data.decode())
