# SPDX-License-Identifier: Apache-2.0
"""Compares the things of a map with those of a made-up building: boxes of one class match by their intersection over union.

A true thing counts as seen where enough voxels of the map lie on it, whatever class the map gives them: at least MIN_VOXELS
within BESIDE_M of its box whose nearest true surface is of its class. A thing of the map may match any true thing of its
class, seen or not.
"""

import numpy as np

from nightmap_eval.labels.label_accuracy import building_from_map, read_true_building, true_classes
from nightmap_eval.things import iou, read_things
from nightmap_eval.labels.voxel_labels import read_voxel_labels

MIN_IOU = 0.5
MIN_VOXELS = 30
BESIDE_M = 0.05


def evaluate(site):
    """Shares of the true things that are in the map, and of the map's things that are true."""
    things = read_things(site)
    if things is None:
        return {}
    counts = {"num_things": len(things), "has_truth": False}
    building, alignment, voxels = read_true_building(site), building_from_map(site), read_voxel_labels(site)
    truth = None if voxels is None else true_classes(site, voxels)
    if truth is None:
        return counts
    is_seen = seen(building.things, alignment.apply(voxels.centres_m()), truth.nearest, voxels.names)
    found = [(thing.class_name, thing.box.moved(alignment)) for thing in things]
    return counts | {"has_truth": True} | figures(building.things, is_seen, found)


def seen(true_things, points_m, true_labels, names):
    """Whether the map has enough of each true thing. points_m: centres of the voxels in the building's frame."""
    points_of = {name: points_m[true_labels == names.index(name)] for name in {name for name, _ in true_things} if name in names}
    within = ((np.abs(box.to_own_axes(points_of.get(name, points_m[:0]))) <= box.half_size_m + BESIDE_M).all(axis=1)
              for name, box in true_things)  # fmt: skip
    return np.array([np.count_nonzero(mask) >= MIN_VOXELS for mask in within], bool)


def figures(true_things, is_seen, found):
    """true_things, found: (class, box in the building's frame). Things of classes that no true thing has are only counted."""
    classes = {name for name, _ in true_things}
    judged = [thing for thing in found if thing[0] in classes]
    overlaps = overlaps_of(true_things, judged)
    best, is_true = match(overlaps)
    is_nowhere = overlaps.max(axis=0, initial=0) <= 0
    result = {"num_never_seen": int(np.count_nonzero(~is_seen)), "num_of_other_classes": len(found) - len(judged)}
    result |= _summary(best, is_seen, is_true, is_nowhere, np.ones(len(judged), bool))
    by_class = {}
    for name in sorted(classes):
        is_of_class = np.array([thing[0] == name for thing in true_things], bool)
        of_class = np.array([thing[0] == name for thing in judged], bool)
        by_class[name] = _summary(best, is_seen & is_of_class, is_true, is_nowhere, of_class)
    return result | {"classes": by_class}


def overlaps_of(true_things, found):
    """Intersection over union (true, found); 0 between classes."""
    return np.array([[iou(box, other) if name == other_name else 0.0 for other_name, other in found] for name, box in true_things],
                    float).reshape(len(true_things), len(found))  # fmt: skip


def match(overlaps):
    """Pairs one true thing with one found thing, the largest overlap first.

    Returns the overlap of each true thing with its partner, 0 without one, and whether each found thing has a partner that it
    overlaps by MIN_IOU."""
    best, is_true = np.zeros(overlaps.shape[0]), np.zeros(overlaps.shape[1], bool)
    is_taken = is_true.copy()
    for flat in np.argsort(-overlaps, axis=None, kind="stable"):
        i, j = np.unravel_index(flat, overlaps.shape)
        if overlaps[i, j] <= 0:
            break
        if best[i] == 0 and not is_taken[j]:
            best[i], is_taken[j], is_true[j] = overlaps[i, j], True, overlaps[i, j] >= MIN_IOU
    return best, is_true


def _summary(best, chosen, is_true, is_nowhere, among):
    """Figures of the chosen true things and of the found things `among`. A true thing without a partner has overlap 0."""
    num_true, num = int(np.count_nonzero(chosen)), int(np.count_nonzero(among))
    num_found = int(np.count_nonzero(best[chosen] >= MIN_IOU))
    return {
        "num_true": num_true,
        "num_found": num_found,
        "found_percent": 100 * num_found / num_true if num_true else None,
        "iou_median": float(np.median(best[chosen])) if num_true else None,
        "num_judged": num,
        "false_percent": 100 * int(np.count_nonzero(~is_true & among)) / num if num else None,
        "nowhere_percent": 100 * int(np.count_nonzero(is_nowhere & among)) / num if num else None,
    }
