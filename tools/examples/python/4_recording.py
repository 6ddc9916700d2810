"""A recording of `colift run --record` as curves: height and tilt of the object, load on the hand.

    build/colift run --record run.mcap
    PYTHONPATH=build/python python3 tools/examples/python/4_recording.py run.mcap [PICTURE.png]
"""
import sys

import colift
import numpy as np

if len(sys.argv) < 2:
    sys.exit(__doc__)
recording = colift.Recording(sys.argv[1])
for sentence in recording.damage:
    print("damaged:", sentence)
for topic, about in sorted(recording.topics.items()):
    print(f"{about['messages']:7d}  {topic}  {about['schema']}")

# %% What was said and felt, as curves; None is NaN, which leaves a gap
def curve(topic, key):
    points = [(t_s, np.nan if message[key] is None else message[key]) for _, t_s, message in recording.messages(topic)]
    return [t_s for t_s, _ in points], [value for _, value in points]


for _, t_s, change in recording.messages("/task/change"):
    print(f"{t_s:7.2f} s  {change['state']:14s} {change['because']}")
time_s, height_m = curve("/load", "height_m")
panels = {
    "Height (mm)": {"palm": (time_s, [1000 * h for h in height_m])},
    "Tilt (deg)": {"object": curve("/load", "tilt_deg")},
    "Vertical load on the hand (N)": {"measured": curve("/load", "load_n")},
}
if "/truth" in recording.topics:  # a simulated rig's
    panels["Vertical load on the hand (N)"]["truth"] = curve("/truth", "robot_force_z_n")

# %% Every frame that the camera gave: how much of it was measured
frames = [(t_s, 100 * np.isfinite(frame.depth).mean()) for _, t_s, frame in recording.frames()]
panels["Pixels with depth (%)"] = {"frame": tuple(zip(*frames))}

picture = sys.argv[2] if len(sys.argv) > 2 else "recording.png"
colift.write_plot(picture, "time since the start (s)", panels)
print(f"{len(frames)} frames in {recording.duration_s:.1f} s; picture:", picture)
