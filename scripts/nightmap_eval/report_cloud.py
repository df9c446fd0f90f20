# SPDX-License-Identifier: Apache-2.0
"""Section of the report on the cloud: how good it is by its own measurements."""

from nightmap_eval import html
from nightmap_eval.job_results import StageResult

CLOUD_ROWS = (
    ("plane_thickness_median_m", "Thickness of flat places, median of a tile (cm)", 100),
    ("plane_thickness_p90_m", "Thickness of flat places, 90 % of a tile (cm)", 100),
    ("held_out_rays_agreeing_percent", "Held-out rays that end on the cloud (%)", 1),
    ("held_out_rays_blocked_percent", "Held-out rays that a surface of the cloud blocks (%)", 1),
)


def cloud_section(site_dir):
    """How good the cloud is by its own measurements; None when point_cloud left no such figures."""
    found = StageResult(site_dir / "point_cloud").figures()
    rows = [[title, _scaled(found[key], scale)] for key, title, scale in CLOUD_ROWS if key in found]
    return html.section("Cloud, without truth", html.table(("", ""), rows)) if rows else None


def _scaled(value, scale):
    """A figure in another unit; several tiles have a range."""
    if isinstance(value, tuple):
        return " to ".join(html.number(scale * part) for part in value)
    return scale * value
