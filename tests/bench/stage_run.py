# SPDX-License-Identifier: Apache-2.0
"""Runs one program on files of any folder, as the benchmarks of single programs do."""

from command_line import output_of  # first: it makes the packages of scripts/ importable
from nightmap_site.checked_reading import read_text
from nightmap_site.job_results import StageResult

LOCALIZE_OUTPUTS = {"queries": "queries.csv", "trajectory": "queries.tum"}


def localize_inputs(site_dir, data):
    """Inputs of localize on the queries of a site with a map."""
    calibrated = site_dir / "adjust/cameras.json"
    return {"queries": site_dir / "queries/queries.csv", "cameras": site_dir / "queries/query_cameras.json", "data": data,
            "configured": site_dir / "frames/cameras.json",
            "calibrated": calibrated if calibrated.exists() else site_dir / "frames/cameras.json",
            "landmarks": site_dir / "landmarks/landmarks.h5", "vocabulary": site_dir / "vocabulary/vocabulary.h5"}  # fmt: skip


def changed_config(text, options):
    """A config of one `key = value` per line with other values of these options; those it lacks are appended."""
    lines = [line for line in text.splitlines() if line.partition("=")[0].strip() not in options]
    return "".join(f"{line}\n" for line in [*lines, *(f"{key} = {value}" for key, value in options.items())])


def path_of(path, list_path):
    """The path itself, or that of the list that it is written to."""
    if not isinstance(path, list):
        return path
    list_path.write_text("".join(f"{item}\n" for item in path))
    return list_path


class Programs:
    """The programs of a build. `launcher`: words of a command that starts each."""

    def __init__(self, build, threads, launcher=()):
        self.folder, self.threads, self.launcher = build / "run", threads, launcher

    def run(self, program, inputs, outputs, folder, config=None, **options):
        """Returns the run's StageResult. `inputs`: port -> path, or a list of paths. `outputs`: port -> name of a file in
        `folder`, which is made. `config`: file whose values `options` replace; without it the program's own hold. Raises
        DataError when the program fails."""
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "config.toml").write_text(changed_config(read_text(config) if config else "", options))
        command = [*self.launcher, self.folder / program, "--config", folder / "config.toml", "--threads", self.threads,
                   "--log-level", "err"]  # fmt: skip
        for port, path in inputs.items():
            command += ["--in-list" if isinstance(path, list) else "--in", f"{port}={path_of(path, folder / f'{port}.txt')}"]
        for port, name in (outputs | {kind: f"{kind}.json" for kind in ("report", "receipt")}).items():
            command += ["--out", f"{port}={folder / name}"]
        output_of(command)
        return StageResult(folder)
