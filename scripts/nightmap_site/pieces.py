# SPDX-License-Identifier: Apache-2.0
"""The pieces of a profile: which tables of which configs/<folder>/pipeline.toml make up its pipeline.

A folder declares jobs. Its list `pieces` makes it a profile: names of folders (all that they declare, or, of a profile, all that it is
made of), and "folder.job" for one job. A folder without a list stands for the default profile and itself when it is a profile.
"""

import os
import re

from nightmap_site.toml_file import PipelineError, read_toml

PORTS = ("in", "out", "beside", "section")  # a table that changes a job changes single keys of these
BASE = "pipeline.toml"  # of the folder of configs: what every profile has


class Table:
    """A table of a declaration: changes a job, or declares one if it has a purpose. slot: the job's name in the pipeline."""

    def __init__(self, file, header, keys):
        if not isinstance(keys, dict) or not all(isinstance(keys.get(key, {}), dict) for key in PORTS):
            raise PipelineError(f"{file.path}: [{header}] must be a table of keys, with tables of ports in, out and beside")
        self.file, self.header, self.keys = file, header, dict(keys)
        self.slot, self.given = self.keys.pop("slot", header), self.keys.pop("given", None)
        self.declares = "purpose" in keys


class DeclarationFile:
    """pieces: its list, or None. slots: job -> the folder whose job it is where several of the pieces have one. without: goal -> why the
    profile has no job of it."""

    def __init__(self, configs, folder):
        self.folder, self.path = folder, os.path.join(configs, folder, "pipeline.toml")
        tables = read_toml(self.path) if os.path.exists(self.path) else {}
        self.pieces, self.slots, self.without = tables.pop("pieces", None), tables.pop("slots", {}), tables.pop("without", {})
        self.goals, self.clashes = tables.pop("goals", {}), tables.pop("clash", [])
        self.tables = [Table(self, header, keys) for header, found in tables.items()
                       for keys in (found if isinstance(found, list) else [found])]  # fmt: skip
        wrong = [piece for piece in _flat(self.pieces or (), None) if not isinstance(piece, str)]
        if not isinstance(self.pieces, (list, type(None))) or wrong:
            raise PipelineError(f"{self.path}: pieces is a list of folders of configs, of \"folder.job\", and of tables with given, a key of "
                                f"[import], pieces, and perhaps else: {wrong[:1] or self.pieces}")  # fmt: skip

    def chosen(self, imports):
        """Names of the pieces for a site whose [import] has these keys; None: of all sites."""
        return _flat(self.pieces or (), imports)


def _flat(pieces, imports):
    found = []
    for piece in pieces if isinstance(pieces, list) else [pieces] if pieces else []:
        if isinstance(piece, dict) and isinstance(piece.get("given"), str) and set(piece) <= {"given", "pieces", "else"}:
            is_given = imports is None or piece["given"] in imports
            found += _flat(piece.get("pieces", []), imports) if is_given else []
            found += _flat(piece.get("else", []), imports) if imports is None or not is_given else []
        else:
            found.append(piece)
    return found


class Pieces:
    """tables: slot -> the tables that make its job, in order. files: those that tables come from, in order, the profile's own the last.
    imports: the keys of [import] of the site; None: whatever a site may have. Raises PipelineError."""

    def __init__(self, configs, profile, imports):
        self._configs, self._imports, self._files = configs, imports, {}
        self.files = [self._file("")]
        base = _append({}, self._file("").tables)
        own = self._file(profile if re.fullmatch(r"[\w-]+", profile) else "default")  # a path is refused later, as no profile
        tables = self._expanded(own, base, ["default"] if self._has("default") and profile != "default" else [], ())
        judging = [table.slot for table in self._file("").tables if "script" in table.keys]  # they read all other results
        self.tables = {slot: tables[slot] for slot in sorted(tables, key=judging.__contains__)}

    def _has(self, folder):
        return os.path.exists(os.path.join(self._configs, folder, "pipeline.toml"))

    def _file(self, folder):
        if folder not in self._files:
            self._files[folder] = file = DeclarationFile(self._configs, folder)
            file.tables = [table for table in file.tables if self._imports is None or table.given in (None, *self._imports)]
        return self._files[folder]

    def _expanded(self, file, tables, before, within):
        """slot -> tables: those given, those of the pieces that a file lists, and then its own. before: the pieces of a file without
        a list."""
        listed = [*before, file.folder] if file.pieces is None else file.chosen(self._imports)
        own = [table for table in file.tables if file.folder in listed or not table.declares]
        for piece in listed:
            folder, _, job = piece.partition(".")
            if folder == file.folder:
                more = _jobs(file, job, piece, file) if job else []
                own += more
                tables |= {table.slot: [] for table in (more if job else own) if table.slot not in tables}  # their place in the order
            elif not self._has(folder) or folder in within and self._file(folder).pieces is not None:
                raise PipelineError(f"{file.path}: pieces: {piece!r} is no folder of {self._configs} with a pipeline.toml, or lists this one")
            elif job:
                self._join(tables, _append({}, _jobs(self._file(folder), job, piece, file)), file)
                self._use(self._file(folder))
            else:
                self._join(tables, self._expanded(self._file(folder), {}, [], (*within, file.folder)), file)
        self._use(file)
        return _append(tables, (table for table in own if table not in tables.get(table.slot, [])))

    def _use(self, file):
        self.files += [] if file in self.files else [file]

    def _join(self, tables, found, by):
        """Adds the tables of a piece. Where another one has the same job, the list's file names the folder whose job it is."""
        for slot, new in found.items():
            old = tables.get(slot, [])
            ours, theirs = ([table for table in of if table.declares] for of in (old, new))
            if not set(ours) <= set(theirs) and not set(theirs) <= set(ours) and self._imports is not None:
                of = {table.file.folder: old for table in ours} | {table.file.folder: new for table in theirs}
                if by.slots.get(slot) not in of:
                    raise PipelineError(f"{by.path}: {' and '.join(of)} both have a job {slot}: say whose it is, like {slot} = "
                                        f"\"{list(of)[-1]}\" in [slots]")  # fmt: skip
                old, new = of[by.slots[slot]], []
            first, second = (new, old) if theirs and not ours else (old, new)  # what a job gets besides follows it
            tables[slot] = [*first, *(table for table in second if table not in first)]


def _append(tables, more):
    for table in more:
        tables.setdefault(table.slot, []).append(table)
    return tables


def _jobs(file, job, piece, by):
    found = [table for table in file.tables if table.header == job and table.declares]
    if not found:
        raise PipelineError(f"{by.path}: pieces: {piece!r}: {file.path} declares no job {job}")
    return found
