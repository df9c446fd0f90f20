# SPDX-License-Identifier: Apache-2.0
"""Small sites of every profile in one workspace, so that each program and each kind of input is there to be attacked."""
import re
import shutil

from ros_map_test import CONFIG as MAP_ALONE
from ros_map_test import floor
from wheels_test import WHEELS, write_wheels
from workspace import CAMERA, LASER_SITE, REPOSITORY, SITE, write_laser_site
from PIL import Image

GOALS = {SITE: ("map", "localize", "plan", "drive", "export"), LASER_SITE: ("map",), "table": ("map",),
         "office": ("plan", "START=0.5,-0.2", "GOAL=5.5,0.5"), "carried": ("map",), "labelled": ("map", "localize"), "boards": ("map",),
         "wheeled": ("map",), "posed": ("map",), "upward": ("map",)}  # fmt: skip
if not (REPOSITORY / "configs/ceiling").is_dir():
    del GOALS["upward"]
CLASSES = '["none", "wall", "floor", "ceiling", "door", "table", "chair", "shelf", "cabinet", "bed", "sofa", "poster", "object", "lamp"]'
MODEL = f'classes = {CLASSES}\nmoving = ["chair"]\n'
OFFICE = "image:  map.png\nmode: trinary\nresolution: 0.05\norigin: [-1.5, -2.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
UPWARD = 'layout = "office"\nimage_width_px = 320\nimage_height_px = 240\nfocal_length_px = 160.0\nduration_s = 20.0\n'


def write_table(folder, root):
    """The recording of the laser as CSV; -> the config's text."""
    scans, odometry = [], ["time_s,x_m,y_m,heading_rad"]
    for line in (root / "data" / LASER_SITE / "robot.log").read_text().splitlines():
        words = line.split()
        if words[:1] == ["FLASER"]:
            scans.append(",".join([words[-1], *words[2 : 2 + int(words[1])]]))
        elif words[:1] == ["ODOM"]:
            odometry.append(",".join([words[-1], *words[1:4]]))
    num_beams = scans[0].count(",")
    (folder / "scans.csv").write_text("\n".join([",".join(["time_s", *(f"r{i}" for i in range(num_beams))]), *scans]) + "\n")
    (folder / "odometry.csv").write_text("\n".join(odometry) + "\n")
    text = (root / f"configs/sites/{LASER_SITE}.toml").read_text().replace(f'root = "{LASER_SITE}"', 'root = "table"').split("[robot_truth]")[0]
    for file, message, columns in (("scans.csv", "FLASER", "time_s"), ("odometry.csv", "ODOM", "time_s,x_m,y_m,heading_rad")):
        text = re.sub(rf'format = "carmen"\nfile = .*\nmessage = "{message}"', f'format = "csv"\nfile = "{file}"\ncolumns = "{columns}"', text)
    return text.replace("synthetic = true", "synthetic = false")


def write_carried(folder, root):
    """The recording of the laser, with the robot's way by another system."""
    shutil.copy(root / "maps" / LASER_SITE / "map_frame/trajectory.tum", root / "data" / LASER_SITE)
    text = (root / f"configs/sites/{LASER_SITE}.toml").read_text()
    return f'{text}\n[import]\ntrajectory = "{LASER_SITE}/trajectory.tum"\n'


def write_office(folder, root):
    """A map that another system made, and a scan to locate in it."""
    Image.fromarray(floor()).save(folder / "map.png")
    (folder / "map.yaml").write_text(OFFICE)
    return MAP_ALONE


def write_upward(folder, root):
    """The recording of a camera that looks up; its synthesis is a job of the site."""
    options = root / "configs/sites/upward"
    options.mkdir()
    (options / "synthesize_ceiling.toml").write_text(UPWARD)
    text = (root / "configs/sites/ceiling_office.toml").read_text().replace('root = "ceiling_office"', 'root = "upward"')
    for key, value in (CAMERA | {"fx": 160, "fy": 160}).items():
        text = re.sub(rf"(?m)^{key} *=.*", f"{key} = {value}", text)
    return text


def small(root, profile, tables="", sequence=""):
    """The small building's config under a profile."""
    shutil.copytree(root / f"configs/sites/{SITE}", root / f"configs/sites/{profile[0]}")
    text = (root / f"configs/sites/{SITE}.toml").read_text()
    return text.replace("root =", f'profile = "{profile[1]}"\nroot =', 1).replace("[[sequence]]\n", f"[[sequence]]\n{sequence}", 1) + tables


def write_labelled(folder, root):
    (root / "data/model.toml").write_text(MODEL)
    return small(root, ("labelled", "labels"), '\n[import]\nmodel = "model.toml"\n', 'label_folder = "labels"\n')


def write_boards(folder, root):
    return small(root, ("boards", "moving"))


def write_wheeled(folder, root):
    write_wheels(root / "data" / SITE)
    return small(root, ("wheeled", "wheels"), WHEELS)


def write_posed(folder, root):
    given = root / "data" / SITE / "other"
    given.mkdir()
    for file in ("map_frame/trajectory.tum", "grid/map.yaml", "grid/map.pgm"):
        shutil.copy(root / "maps" / SITE / file, given)
    return small(root, ("posed", "imported"), f'\n[import]\ntrajectory = "{SITE}/other/trajectory.tum"\nmap = "{SITE}/other/map.yaml"\n')


WRITERS = {"table": write_table, "office": write_office, "carried": write_carried, "labelled": write_labelled, "boards": write_boards,
           "wheeled": write_wheeled, "posed": write_posed, "upward": write_upward}  # fmt: skip


def make_sites(work):
    """Makes all sites of a workspace in the order of GOALS; yields (site, what make printed)."""
    write_laser_site(work.folder)
    for site, goals in GOALS.items():
        if site in WRITERS:
            folder = work.folder / "data" / site
            if site in ("table", "office", "upward"):
                folder.mkdir()
            (work.folder / f"configs/sites/{site}.toml").write_text(WRITERS[site](folder, work.folder))
        result = work.make("V=1", f"SITE={site}", *goals)
        if result.returncode != 0:
            raise SystemExit(f"sweep: the chain of {site} fails without any attack:\n{result.stdout[-4000:]}")
        work.as_recorded(site)
        yield site, result.stdout
