#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""bench_night: time, memory and error of the programs that map a site as a whole, against its number of frames.

Composes sites of 10,000 to 430,000 frames out of the artifacts of a mapped one (night/compose.py): copies side by side, along which
the way leads twice. Runs the programs from the vocabulary to the queries on them, one after the other, with their default configs.
Queries are those of the mapped site, in the first copy. A site takes 45 kB of disk per frame, its landmarks as much again; it is
deleted when it is measured.
Prints two Markdown tables, of cost and of errors; with --page they go between `<!-- bench_night:begin -->` and
`<!-- bench_night:end -->`. A program that fails, such as for want of memory, is a row that says so.
Exit codes: 0 done; 1 no site could be composed; 2 wrong command line.
"""

import itertools
import tempfile
from pathlib import Path

import matplotlib
from command_line import markdown, parser_of, put_into_page  # first: it makes the packages of scripts/ importable
from nightmap_site.script_errors import DataError, run_main
from stage_run import Programs

from night import run, score
from night.compose import NUM_VISITS, Composer, link_data
from night.source import Source

TITLES = ["program", "frames", "wall (s)", "CPU (s)", "memory (MiB)", "files (MB)", "CPU per frame, ratio", "memory per frame, ratio"]
ERRORS = ["frames", "copies", "without pose", "ATE (m)", "RPE over 10 m (cm)", "RPE over 10 m (deg)", "of odometry alone (cm)", "loops",
          "false loops", "revisits closed (%)", "queries located", "their error (cm)", "in a wrong place"]  # fmt: skip


def size_mb(folder):
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) / 1e6


def reason_of(error):
    """The last line that a program said (between its command and "the run failed"), up to the first path."""
    said = [line for line in error.splitlines() if line][1:-1]
    words = said[-1].partition(" error ")[2].split() if said else ["killed"]
    return " ".join(itertools.takewhile(lambda word: "/" not in word, words))


SHELL = ("sh", "-c", '"$@"; exit $?', "sh")  # starts programs, so that their peak memory is not that of Python before them


def limited_programs(arguments):
    limit = ("prlimit", f"--as={round(arguments.memory * 2**30)}") if arguments.memory else ()
    return Programs(arguments.build, arguments.threads, (*SHELL, *limit))


def costs_of(jobs, folder, run_job):
    """Runs the jobs up to the first that fails. Returns name -> (wall s, CPU s, memory MiB, files MB), and name -> reason of that one."""
    costs = {}
    for job in jobs:
        try:
            result = run_job(job)
        except DataError as error:
            return costs, {job.name: reason_of(str(error))}
        costs[job.name] = (result.wall_time_s(), result.cpu_time_s(), result.peak_memory_bytes() / 2**20, size_mb(folder / job.name))
    return costs, {}


class Site:
    """A composed site and what its programs cost."""

    def __init__(self, arguments, source, unit, count, folder):
        self.arguments, self.folder = arguments, folder
        self.composer = Composer(source, unit, count, Programs(arguments.build, arguments.threads))
        self.truth = self.composer.write(folder)
        link_data(folder / "data", arguments.data, NUM_VISITS * self.composer.num_copies)
        self.costs, self.failure = {}, {}

    def map(self):
        """Runs the programs up to the first that fails."""
        programs = limited_programs(self.arguments)
        self.costs, self.failure = costs_of(run.jobs_of_whole(), self.folder,
                                            lambda job: run.run(job, programs, self.folder, self.arguments.site_dir, self.arguments.data))

    def errors(self):
        """A row of the second table."""
        composer, folder = self.composer, self.folder
        cells = [f"{composer.num_frames:,}", str(composer.num_copies)]
        if "map_frame" not in self.costs:
            return cells + ["n/a"] * (len(ERRORS) - len(cells))
        way = score.trajectory_figures(folder / "map_frame/trajectory.tum", self.truth, composer.visit_frames)
        loops = score.loop_figures(folder / "loops/loops.h5", folder / "pose_graph/graph.h5", self.truth, composer.visit_frames)
        odometry_m, _ = score.odometry_errors(run.first_visit(folder), self.truth)
        return cells + [str(way["num_without"]), f"{way['ate_m']:.3f}", f"{100 * way['rpe_m']:.2f}", f"{way['rpe_deg']:.3f}",
                        f"{100 * odometry_m:.2f}", f"{loops['num_accepted']:,}", str(loops["num_false"]), f"{loops['closed_percent']:.1f}",
                        *self.query_errors()]  # fmt: skip

    def query_errors(self):
        if "localize" not in self.costs:
            return ["n/a"] * 3
        figures = score.query_figures(self.folder / "localize/queries.csv", self.arguments.site_dir / "queries/query_ground_truth.tum",
                                      self.folder / "map_frame/trajectory.tum", self.truth, self.composer.copy_of_frames() == 0)
        return [f"{figures['num_located']} of {figures['num_queries']}", f"{100 * figures['median_m']:.2f}", str(figures["num_wrong"])]


def programs_of(sites):
    """Names of the programs that ran, or failed, in order."""
    return list(dict.fromkeys(name for _, costs, failure in sites for name in (*costs, *failure)))


def cost_rows(sites):
    """A row per program and size. Ratios are to the first size."""
    rows = []
    for program in programs_of(sites):
        first = None
        for num_frames, costs, failure in sites:
            if program in failure:
                rows.append([program, f"{num_frames:,}", f"failed: {failure[program]}", *["n/a"] * (len(TITLES) - 3)])
            if program not in costs:
                continue
            wall_s, cpu_s, memory_mib, files_mb = costs[program]
            per_frame = cpu_s / num_frames, memory_mib / num_frames
            first = first or per_frame
            rows.append([program, f"{num_frames:,}", f"{wall_s:.1f}", f"{cpu_s:.1f}", f"{memory_mib:.0f}", f"{files_mb:.0f}",
                         *(f"{now / then:.2f}" for now, then in zip(per_frame, first, strict=True))])  # fmt: skip
    return rows


def plot(path, sites):
    """Time per frame and memory of each program against the number of frames."""
    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, 2, figsize=(10, 4), layout="constrained")
    for program in programs_of(sites):
        done = [(num_frames, costs[program]) for num_frames, costs, _ in sites if program in costs]
        if not done:
            continue
        frames = [num_frames for num_frames, _ in done]
        axes[0].loglog(frames, [1e3 * cost[1] / num for num, cost in done], marker="o", label=program)
        axes[1].loglog(frames, [cost[2] for _, cost in done], marker="o", label=program)
    for axis, title in zip(axes, ("CPU time per frame (ms)", "peak memory (MiB)"), strict=True):
        axis.set(xlabel="frames", title=title)
        axis.grid(visible=True, which="both", alpha=0.3)
    axes[0].legend()
    figure.savefig(path)


def add_limits(parser):
    parser.add_argument("--memory", type=float, metavar="GIB", default=4, help="limit of each program's address space; 0: none")
    parser.add_argument("--folder", type=Path, help="folder of the composed sites instead of one in the folder of temporary files")


def parse_arguments():
    parser = parser_of(__doc__, "data", "build", "threads", "page")
    parser.add_argument("site_dir", type=Path, help="maps/SITE of one camera, mapped up to localize")
    parser.add_argument("--frames", type=int, nargs="+", default=[10_000, 20_000, 50_000, 100_000])
    parser.add_argument("--unit", type=int, nargs=2, metavar=("FIRST", "LAST"),
                        help="shards of a copy; without it those that lead farthest, at most a quarter of the smallest size")  # fmt: skip
    add_limits(parser)
    parser.add_argument("--plot", type=Path, help="picture of the growth, SVG or PNG")
    return parser.parse_args()


def main():
    arguments = parse_arguments()
    source = Source(arguments.site_dir)
    longest = max(map(len, source.rows))
    unit = tuple(arguments.unit or source.choose_unit(max(1, min(arguments.frames) // 4 // longest)))
    sites, errors = [], []
    for count in arguments.frames:
        with tempfile.TemporaryDirectory(dir=arguments.folder, ignore_cleanup_errors=True) as folder:
            site = Site(arguments, source, unit, count, Path(folder) / "site")
            site.map()
            sites.append((site.composer.num_frames, site.costs, site.failure))
            errors.append(site.errors())
        text = markdown(TITLES, cost_rows(sites)) + "\n" + markdown(ERRORS, errors, 0)
        print(text, flush=True)
    if arguments.plot:
        plot(arguments.plot, sites)
    put_into_page(arguments, "bench_night", text)


if __name__ == "__main__":
    run_main(main)
