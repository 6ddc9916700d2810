"""A decision from two depth images of one camera: the object alone, then with the person who holds it.

    PYTHONPATH=build/python python3 tools/examples/python/1_decide.py BEFORE.png WITH_PARTNER.png PICTURE.png

Each PNG is 16-bit depth with a camera.json beside it. Without files: a synthetic table with a Kinect's noise.
"""
import sys

import colift

if len(sys.argv) > 2:
    before, after = (colift.Frame.read(file) for file in sys.argv[1:3])
    camera_pose = None  # unknown: results are in the camera's frame
else:
    scene = colift.synthetic_scene("table", seed=22)
    before, after, camera_pose = scene["frame"], scene["frame_with_partner"], scene["camera_pose"]

# %% What is there to carry?
analysis = colift.look(before, camera_pose)
print(analysis.reason)

# %% Where is the person, and where should the robot grasp?
outcome = analysis.decide(after)
print(outcome.partner_reason)
print(outcome.reason)
for candidate, cost, share in zip(outcome.candidates, outcome.costs, outcome.shares):
    if candidate.verdict in ("ok", "chosen"):
        print(f"{candidate.id:4d}  {candidate.verdict:7s} {share:5.0%} {cost:9.2f} N^2  {candidate.position.round(3)} m")

# %% The same as a picture
picture = sys.argv[-1] if len(sys.argv) > 1 else "decision.png"
outcome.write(picture)
print("picture:", picture)
sys.exit(0 if outcome.chosen is not None else 1)
