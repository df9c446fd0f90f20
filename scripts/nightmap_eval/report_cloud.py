# SPDX-License-Identifier: Apache-2.0
"""Section of the report on the cloud: its quality by measurements that need no truth."""

from nightmap_eval import html
from nightmap_site.job_results import StageResult

CLOUD_ROWS = (
    ("plane_thickness_median_m", "Thickness of flat surfaces, median per tile (cm)", 100),
    ("plane_thickness_p90_m", "Thickness of flat surfaces, 90 % per tile (cm)", 100),
    ("held_out_rays_agreeing_percent", "Held-out rays that end on the cloud (%)", 1),
    ("held_out_rays_blocked_percent", "Held-out rays that a surface of the cloud blocks (%)", 1),
)


def cloud_section(site):
    """Quality of the cloud without truth; None when point_cloud wrote no such figures."""
    found = StageResult(site.folder_of("point_cloud")).figures()
    rows = [[title, html.number(tuple(scale * part for part in found[key])) if isinstance(found[key], tuple) else scale * found[key]]
            for key, title, scale in CLOUD_ROWS if key in found]  # fmt: skip
    return html.section("Cloud, without truth", html.table(("", ""), rows)) if rows else None
