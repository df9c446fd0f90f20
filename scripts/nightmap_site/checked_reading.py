# SPDX-License-Identifier: Apache-2.0
"""Reads text, JSON and TOML that may be damaged: every error names the file and the remedy.

Every start of make uses this file, so it imports little.
"""

import json
import math
import os
from contextlib import contextmanager

from nightmap_site.script_errors import DataError

REMEDY = "delete the file and run make again"
NUMBER = (int, float)
# Exceptions of code that uses a damaged file.
_DAMAGE = (LookupError, TypeError, ValueError, AttributeError, ArithmeticError, RecursionError)


@contextmanager
def using(path, remedy=REMEDY):
    """A context for code that uses the content of one file only: turns its exceptions into errors that name the file."""
    try:
        yield
    except RecursionError:
        raise DataError(f"{path}: nested too deep; {remedy}") from None
    except _DAMAGE as error:
        raise DataError(f"{path}: damaged ({type(error).__name__}: {error}); {remedy}") from None


def read_text(path, remedy=REMEDY):
    if os.path.exists(path) and not os.path.isfile(path):
        raise DataError(f"{path}: not a file; remove it and run make again")
    try:
        with open(path, encoding="utf-8") as file:
            return file.read()
    except UnicodeDecodeError:
        raise DataError(f"{path}: not a text file; {remedy}") from None


def _refuse(constant):
    raise ValueError(f"{constant} is not a number")


def read_json(path, remedy=REMEDY):
    return _parsed(path, remedy, lambda text: json.loads(text, parse_constant=_refuse))


def read_toml(path, remedy=REMEDY):
    import tomllib  # a slow import, and most callers read no TOML

    return _parsed(path, remedy, tomllib.loads)


def _parsed(path, remedy, parse):
    text = read_text(path, remedy)
    try:
        return parse(text)
    except json.JSONDecodeError as error:
        raise DataError(f"{path}:{error.lineno}: {error.msg}; {remedy}") from None
    except RecursionError:
        raise DataError(f"{path}: nested too deep; {remedy}") from None
    except ValueError as error:
        raise DataError(f"{path}: {error}; {remedy}") from None


def read_csv(path, required=()):
    """Rows as dictionaries. Raises DataError on a missing column or a row of another length."""
    import csv
    import io

    rows = csv.DictReader(io.StringIO(read_text(path), newline=""))
    try:
        missing = [name for name in required if name not in (rows.fieldnames or [])]
        if missing:
            raise DataError(f"{path}: no column {', '.join(missing)}; {REMEDY}")
        result = list(rows)
    except csv.Error as error:
        raise DataError(f"{path}:{rows.line_num}: {error}; {REMEDY}") from None
    for number, row in enumerate(result, 2):
        if None in row or None in row.values():
            raise DataError(f"{path}:{number}: another number of columns than the header; {REMEDY}")
    return result


def read_object(path, shape, remedy=REMEDY):
    """A JSON file whose content is like `shape`, see check."""
    content = read_json(path, remedy)
    check(content, shape, str(path), remedy)
    return content


def check(value, shape, where, remedy=REMEDY):
    """Raises DataError unless a value is like its shape: a type or several (None is type(None)); a list with
    the shape of each item; a dictionary with the shape of each key, which may be missing when it starts
    with '?'. Numbers are finite. Other keys are not checked."""
    if isinstance(shape, dict):
        _check_type(value, dict, where, remedy)
        for key, part in shape.items():
            name = key.removeprefix("?")
            if name in value:
                check(value[name], part, f"{where}: {name}", remedy)
            elif name == key:
                raise DataError(f"{where}: no {name!r}; {remedy}")
    elif isinstance(shape, list):
        _check_type(value, list, where, remedy)
        for item in value:
            check(item, shape[0], where, remedy)
    else:
        _check_type(value, shape, where, remedy)


def _check_type(value, types, where, remedy):
    types = types if isinstance(types, tuple) else (types,)
    right = isinstance(value, types) and (not isinstance(value, bool) or bool in types)
    if not right or (isinstance(value, float) and not math.isfinite(value)):
        names = " or ".join("null" if kind is type(None) else kind.__name__ for kind in types)
        raise DataError(f"{where}: {str(value)[:40]!r} is not of type {names}; {remedy}")
