"""The shipped emulated robot (config/emulated.yaml) with another processor for its driver and its far end."""

import os
import re

SHIPPED = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../config/emulated.yaml")


def write(folder, cpu):
    """Writes it into `folder`, both on the processor `cpu` (-1: any), and says where."""
    with open(SHIPPED) as f:
        text, found = re.subn(r"(fri: \{[^}]*cpu: )-?\d+", rf"\g<1>{cpu}", f.read())
    assert found == 1, "config/emulated.yaml says no fri.cpu"
    path = os.path.join(folder, "robot.yaml")
    with open(path, "w") as f:
        f.write(text)
    return path
