#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Hashes the artifacts of a site again and compares each with the receipt of the run that made it.

Exit code 1 when a file is missing, altered, or was made from an input that is not there any more.
"""
import ctypes
import ctypes.util
import json
import pathlib
import sys

CHUNK_BYTES = 1 << 20


def load_xxhash():
    name = ctypes.util.find_library("xxhash") or "libxxhash.so.0"
    library = ctypes.CDLL(name)
    library.XXH3_createState.restype = ctypes.c_void_p
    library.XXH3_64bits_reset.argtypes = [ctypes.c_void_p]
    library.XXH3_64bits_update.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_size_t]
    library.XXH3_64bits_digest.argtypes = [ctypes.c_void_p]
    library.XXH3_64bits_digest.restype = ctypes.c_uint64
    library.XXH3_freeState.argtypes = [ctypes.c_void_p]
    return library


def hash_file(library, path):
    """XXH3, 64 bits, as the programs write it in receipts."""
    state = library.XXH3_createState()
    library.XXH3_64bits_reset(state)
    with open(path, "rb") as file:
        while chunk := file.read(CHUNK_BYTES):
            library.XXH3_64bits_update(state, chunk, len(chunk))
    digest = library.XXH3_64bits_digest(state)
    library.XXH3_freeState(state)
    return f"{digest:016x}"


def root_then(receipt_path, receipt):
    """The site folder at the time of the run; it may have been moved since."""
    report = receipt_path.name.replace("receipt", "report")
    return next(pathlib.Path(entry["path"]).parents[1] for entry in receipt["outputs"]
                if pathlib.Path(entry["path"]).name == report)


def check_receipt(receipt_path, hashed):
    """Problems of one run; `hashed` maps a path to its hash now, or None when it is missing."""
    receipt = json.loads(receipt_path.read_text(encoding="utf-8"))
    then, now = root_then(receipt_path, receipt), receipt_path.parents[1]
    problems = []
    for kind in ("outputs", "inputs"):
        for entry in receipt[kind]:
            if "xxh3" not in entry or "config/" in entry["path"]:
                continue
            path = pathlib.Path(entry["path"])
            path = now / path.relative_to(then) if path.is_relative_to(then) else path
            digest = hashed(path)
            if digest is None:
                problems.append(f"{path}: missing")
            elif digest != entry["xxh3"]:
                what = "altered since it was written" if kind == "outputs" else "not the input it was made from"
                problems.append(f"{path}: {what}")
    return [f"{receipt_path}: {problem}" for problem in problems]


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        print(f"usage: {sys.argv[0]} SITE_FOLDER", file=sys.stderr)
        return 2
    receipts = sorted(pathlib.Path(sys.argv[1]).glob("*/receipt*.json"))
    if not receipts:
        print(f"{sys.argv[1]}: no receipts; run make map first", file=sys.stderr)
        return 1
    library, known = load_xxhash(), {}

    def hashed(path):
        if path not in known:
            known[path] = hash_file(library, path) if path.is_file() else None
        return known[path]

    problems = [problem for receipt in receipts for problem in check_receipt(receipt, hashed)]
    for problem in problems:
        print(problem, file=sys.stderr)
    print(f"{len(receipts)} receipts, {len(known)} files: "
          + (f"{len(problems)} problems" if problems else "all as written"))
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
