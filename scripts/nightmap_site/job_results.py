# SPDX-License-Identifier: Apache-2.0
"""Results that the stages report: receipts (time, memory) and reports (counts)."""

from nightmap_site.checked_reading import NUMBER, read_object
from nightmap_site.pipeline import closure, read_pipeline
from nightmap_site.receipts import WrittenFiles
from nightmap_site.site import CONFIGS
from nightmap_site.unit_lists import CurrentRuns

_NOT_FIGURES = ("format", "version", "stage", "config", "num_skipped", "skipped")
# The fields that reports and receipts must have, see nightmap_site.checked_reading.check.
REPORT = {"?skipped": [str]}
RECEIPT = {
    "?wall_time_s": NUMBER, "?cpu_time_s": NUMBER, "?peak_memory_bytes": NUMBER, "?build_type": str,
    "?parts": [{"name": str, "wall_time_s": NUMBER, "?cpu_time_s": NUMBER}],
}  # fmt: skip


class StageResult:
    """One stage of a site, over all its shards. `prefix` begins the names of its reports and receipts."""

    def __init__(self, folder, prefix=""):
        self.name, runs, written = folder.name, CurrentRuns(folder.parent), WrittenFiles()
        reports, receipts = (
            [path for path in sorted(folder.glob(f"{prefix}{kind}*.json")) if runs.has(path)] for kind in ("report", "receipt")
        )
        for path in reports:
            written.require(path)
        self.reports = [read_object(path, REPORT) for path in reports]
        self.receipts = [read_object(path, RECEIPT) for path in receipts]

    @property
    def num_runs(self):
        return max(len(self.reports), len(self.receipts))

    def wall_time_s(self):
        """Sum over the shards; None without receipts."""
        times = [receipt["wall_time_s"] for receipt in self.receipts if "wall_time_s" in receipt]
        return sum(times) if times else None

    def cpu_time_s(self):
        """CPU time of all cores, summed over the shards; None when a receipt lacks it."""
        times = [receipt.get("cpu_time_s") for receipt in self.receipts]
        return sum(times) if times and None not in times else None

    def part_time_s(self, name):
        """Sum of one part over the shards; 0 if no part has that name."""
        parts = [part for receipt in self.receipts for part in receipt.get("parts", [])]
        return sum(part["wall_time_s"] for part in parts if part["name"] == name)

    def peak_memory_bytes(self):
        """Largest over the shards; None without receipts."""
        return max((receipt["peak_memory_bytes"] for receipt in self.receipts if "peak_memory_bytes" in receipt), default=None)

    def skipped(self):
        return [reason for report in self.reports for reason in report.get("skipped", [])]

    def figures(self):
        """Figures of the reports: sums of counts over the shards, ranges of the others."""
        values = {}
        for report in self.reports:
            for name, value in report.items():
                if name not in _NOT_FIGURES and isinstance(value, (int, float, str, bool)):
                    values.setdefault(name, []).append(value)
        return {name: _together(name, items) for name, items in values.items()}


def _together(name, items):
    if name.startswith("num_") and not any(isinstance(item, str) for item in items):
        return sum(items)
    if len(set(items)) == 1:
        return items[0]
    if any(isinstance(item, str) for item in items):
        return ", ".join(sorted(set(map(str, items))))
    return (min(items), max(items))


def folders_up_to(folder):
    """Folders of the jobs that what is in `folder` is made by, from the lists of frames on, in the order of the pipeline."""
    pipeline = read_pipeline(CONFIGS)
    needed = closure(pipeline, goals=(), folders=(folder,))
    return list(dict.fromkeys(job.folder for job in pipeline.jobs.values() if job.name in needed))


def read_stages(site):
    """Results of the stages that ran, in the order of the pipeline."""
    folders = dict.fromkeys(site.folder / job.folder for job in site.pipeline.jobs.values() if job.program)
    results = [StageResult(folder) for folder in folders if folder.is_dir()]
    return [result for result in results if result.num_runs]
