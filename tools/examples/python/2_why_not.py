"""Why not candidate 7? Every candidate has a verdict, a cost by terms, and sentences that say what stands against it.

    PYTHONPATH=build/python python3 tools/examples/python/2_why_not.py [ID] [PICTURE.png]
"""
import sys

import colift

wanted = int(sys.argv[1]) if len(sys.argv) > 1 else 7
scene = colift.synthetic_scene("table", seed=22)
outcome = colift.decide(scene["frame"], scene["frame_with_partner"], scene["camera_pose"])

# %% In words
try:
    why = outcome.why(wanted)
except colift.Error as error:
    sys.exit(str(error))
print(why["text"])

# %% In figures: the terms of its cost beside those of the chosen one
chosen = outcome.why(outcome.candidates[outcome.chosen].id)
for term in chosen["terms"]:
    print(f"{term:15s} chosen {chosen['terms'][term]:9.3f} N^2   candidate {wanted} {why.get('terms', {}).get(term, float('nan')):9.3f} N^2")

# %% What would have to change? Its share over the share that is asked for
asked, got = [], []
for percent in range(20, 81, 5):
    other = colift.decide(scene["frame"], scene["frame_with_partner"], scene["camera_pose"], share=percent / 100)
    asked.append(percent)
    got.append(100 * other.shares[other.chosen] if other.chosen is not None else float("nan"))
picture = sys.argv[2] if len(sys.argv) > 2 else "why_not.png"
own = next(100 * s for c, s in zip(outcome.candidates, outcome.shares) if c.id == wanted)
colift.write_plot(picture, "share that is asked for (%)",
                  {"Share of the chosen grasp (%)": {"chosen": (asked, got), "as asked": (asked, asked), f"candidate {wanted}": own}})
print("picture:", picture)
