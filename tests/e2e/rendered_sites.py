# SPDX-License-Identifier: Apache-2.0
"""Made-up buildings in pictures of half the size, so that they are rendered in little time. Recordings
and maps are kept in <build>/slam, so that a second run costs only what changed."""
import re

from workspace import BUILD, REPOSITORY, said_by

FOLDER = BUILD / "slam"
HALF_SIZE = "image_width_px = 320\nimage_height_px = 240\nfocal_length_px = 262.5\n"
RECORDING = """
[[{table}]]
layout = "tum"
folder = "{folder}"
camera = "color"
time_offset_s = {offset}
"""


def synthesize(site, config):
    """Renders into data/<site>, unless this program has done so already."""
    folder, program = FOLDER / "data" / site, BUILD / "run/synthesize"
    made = folder / "synthesize.json"
    if made.exists() and made.stat().st_mtime > program.stat().st_mtime:
        return
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "config.toml"
    path.write_text(config + HALF_SIZE)
    said_by([program, "--config", path, "--out", f"site={made}"])


def make_site(site, *arguments):
    """`make` of goals and variables, for a site of these; -> the folder of its results."""
    said_by(["make", "--no-print-directory", f"SITE={site}", f"DATA={FOLDER}/data", f"MAPS={FOLDER}/maps", f"BUILD={BUILD}", *arguments])
    return FOLDER / "maps" / site


def recording(folder, index, table="sequence", has_truth=True):
    """A table of a site config; recordings of different index do not overlap in time."""
    text = RECORDING.format(table=table, folder=folder, offset=100000 * index)
    return text + (f'ground_truth = "{folder}/groundtruth.txt"\n' if has_truth else "")


def write_site(site, recordings):
    """A site of recordings by the camera of `mirror`; -> the folder of its config."""
    text = (REPOSITORY / "configs/sites/mirror.toml").read_text().split("[[sequence]]")[0]
    text = re.sub(r"(?m)^synthetic *=.*\n", "", re.sub(r"(?m)^root *=.*", f'root = "{site}"', text))
    sites = FOLDER / "sites"
    sites.mkdir(parents=True, exist_ok=True)
    (sites / f"{site}.toml").write_text(text + "".join(recordings))
    return sites
