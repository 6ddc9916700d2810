"""The page that walk_bring_up.py writes: each command of docs/bring-up.md with what it printed, shortened."""

import collections
import platform
import re

Record = collections.namedtuple("Record", "item shown here text code says end words")  # shown: "" for what was not carried out; the emulator and its words

TITLES = {"arm": "The arm", "hand": "The hand", "camera": "The Kinect", "run": "The first run", "stop": "After a stop",
          "emulated": "The same without a robot"}
LINES, FEW, WIDTH = 12, 8, 150  # of what was expected, of the rest
LEFT_OUT = r"^(memory: |scheduling: |kernel: |.*# (run's )?default$|\s*\w+:$)"
SAME = ((r"@colift-walk-[\w-]+", "@colift-kinect"), (r"\bpid \d+", "pid ..."), (r"127\.0\.0\.1:\d+ to 127\.0\.0\.1:\d+", "127.0.0.1:PORT to 127.0.0.1:49938"),
        (r"socketcand:127\.0\.0\.1:\d+", "socketcand:127.0.0.1:29536"), (r"UDP port \d+", "UDP port 49938"), (r"to 127\.0\.0\.1:\d{4,}", "to 127.0.0.1:49938"),
        (r"\(port \d+\)", "(port 29536)"), (r"flight-[\d-]+\.mcap", "flight-TIME.mcap"), (r"\d{4}-\d\d-\d\dT[\d:]+Z", "TIME"), (r"\(\d{4}-\d\d-\d\d\)", "(DATE)"))


def same(text, folders):
    """Without what is another one each time."""
    for folder, name in folders.items():
        text = re.sub(re.escape(folder) + r"(/(arm|hand|camera|run|emulated)\b)?", name, text)
    text = text.replace(platform.release(), "KERNEL")
    for pattern, by in SAME:
        text = re.sub(pattern, by, text)
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text)


def shortened(text, says):
    """Those that were expected, then the first and the last."""
    lines = [line for line in map(str.rstrip, text.splitlines()) if line and not re.match(LEFT_OUT, line)]
    kept = [i for i, line in enumerate(lines) if any(re.search(p, line) for p in says)][:LINES]
    for i in [0, *range(len(lines) - 1, -1, -1)]:
        if len(kept) >= FEW:
            break
        if i < len(lines) and i not in kept:
            kept.append(i)
    out, last = [], -1
    for i in sorted(kept):
        if i != last + 1:
            out.append("...")
        out.append(lines[i] if len(lines[i]) <= WIDTH else lines[i][:WIDTH] + " ...")
        last = i
    return out + (["..."] if lines and last != len(lines) - 1 else [])


def page_of(records, cabling, folders):
    out = ["# Bring-up, walked", "",
           "Written by `tests/docs/walk_bring_up.py build/colift --out docs/bring-up-walked.md`, which carries out the commands of [bring-up.md](bring-up.md)",
           "in their order; do not edit. No real device was there, only the emulators. Each command is shown as it was given, with its exit code and the lines",
           "that matter of what it printed; ports, paths and dates are made alike. `far$` is the terminal of the emulator, whose address is left out here. One of",
           "arm, hand or camera that is named again has been running since; a rig is a new one each time.", ""]
    section, row, end, here = None, None, "", ""
    for r in records:
        if not r.shown:
            continue
        if r.item.section != section:
            section = r.item.section
            out += [f"# {TITLES[section]}", ""]
        title = f"{r.item.step}. {r.item.row[0]}" if r.item.step else r.item.row[0] or f"`{r.item.text}`"
        if (section, title) != row:
            row, here = (section, title), ""
            out += [f"## {title}", ""]
        if r.here not in ("", here):
            out += [f"Here: {r.here}.", ""]
        emulates = r.shown.startswith("colift emulate")
        out += ["```text"] + ([f"far$ colift emulate {r.words}"] if r.words and not emulates and r.end != end else [])
        end, here = r.end if r.words else end, r.here
        out += [f"{'far' if emulates else 'robot'}$ {same(r.shown, folders)}"] + [f"> {line}" for line in shortened(same(r.text, folders), r.says)]
        out += [f"exit code {r.code}"] * (not emulates) + ["```", ""]
    out += ["# Not walked", "", "| what | why |", "|---|---|"]
    out += [f"| {r.item.text if ' ' in r.item.text and not re.search('--|:', r.item.text) else f'`{r.item.text}`'} | {r.here} |" for r in records if not r.shown]
    out += [f"| `{pattern.split(' (')[0]}` | {why} |" for pattern, why in cabling.items()]
    out += ["| a depth camera of V4L2 or OpenNI2 in the Kinect's place | the document's tables for these two are of devices that no command emulates alone |", ""]
    return "\n".join(out)
