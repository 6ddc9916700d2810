"""An own cost over many layouts: take the grasp that slips last, instead of the one of the lowest effort. What does it cost?

    PYTHONPATH=build/python python3 tools/examples/python/3_own_cost.py [LAYOUTS] [PICTURE.png]
"""
import os
import sys
from concurrent.futures import ThreadPoolExecutor

import colift
import numpy as np

layouts = int(sys.argv[1]) if len(sys.argv) > 1 else 500
picture = sys.argv[2] if len(sys.argv) > 2 else "own_cost.png"
setup = colift.Setup("decide")  # checked once, used by all threads


def firmest(outcome):
    """Among the feasible grasps that cost at most twice the least: the one with the largest margin against slipping."""
    feasible = [i for i, c in enumerate(outcome.candidates) if c.verdict in ("ok", "chosen")]
    cheap = [i for i in feasible if outcome.costs[i] <= 2 * outcome.costs[outcome.chosen]]
    return max(cheap, key=lambda i: outcome.candidates[i].stability or 0.0)


def layout(seed):
    scene = colift.synthetic_scene("table" if seed % 2 else "box", seed)
    analysis = setup.look(scene["frame"], scene["camera_pose"])
    usual = analysis.decide(scene["contact"])
    if usual.chosen is None:
        return None
    own = analysis.decide(scene["contact"], choice=firmest)
    def figures(outcome):
        return [outcome.costs[outcome.chosen], outcome.candidates[outcome.chosen].stability or np.nan, outcome.shares[outcome.chosen]]
    return figures(usual) + figures(own)


# %% CoLift lets other Python threads run while it computes: one per core
with ThreadPoolExecutor(os.cpu_count()) as pool:
    rows = [row for row in pool.map(layout, range(1, layouts + 1)) if row is not None]
table = np.array(rows)
more = table[:, 3] / table[:, 0] - 1
firmer = table[:, 4] / table[:, 1] - 1
print(f"{len(rows)} of {layouts} layouts have a feasible grasp; another one is taken in {np.mean(more > 0):.0%} of them")
print(f"effort: {np.mean(more):+.0%} on average; margin against slipping: {np.nanmean(firmer):+.0%}; "
      f"share {np.mean(table[:, 2]):.0%} -> {np.mean(table[:, 5]):.0%}")

# %% Sorted, as curves
part = 100 * (np.arange(len(rows)) + 0.5) / len(rows)
colift.write_plot(picture, "part of the layouts (%)", {
    "Effort of the own choice, compared with CoLift's (%)": {"effort": (part, np.sort(100 * more))},
    "Margin against slipping": {"CoLift": (part, np.sort(table[:, 1])), "own": (part, np.sort(table[:, 4]))},
})
print("picture:", picture)
