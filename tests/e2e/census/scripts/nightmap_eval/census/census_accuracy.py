# SPDX-License-Identifier: Apache-2.0
"""The share of frames that became keyframes."""
import json


def evaluate(site):
    census = json.loads(site.made("census", "census").read_text(encoding="utf-8"))
    return {"keyframe_share": census["num_keyframes"] / census["num_frames"]}
