#!/usr/bin/env python3
"""Documents name what exists: links, files and folders, a README in every folder with sources.

    tests/docs/check_links.py [ROOT]

Checked in every Markdown file of the repository:
- a relative link leads to a file or folder; its #anchor is a heading there;
- a path in backticks or in a code block that begins with a top-level folder exists, seen from the root or from the document's
  own folder; a file may be named without its extension (`hal/os/udp_link`), and * stands for anything;
- a name in backticks that looks like one of the program (GuardedArm, find_ground, guard_arm.max_velocity_rad_s, hal::Arm) is a word
  of some file that is not a document, and not the old name of a configuration key.
And in the tree:
- every folder with sources has a README.md that begins with a heading; tests/unit mirrors the tree and needs one only at its top;
- a page of docs/ that a source file names exists.

Ends with 0 when all of it holds, 1 with a line for each exception, 2 when there is nothing to check.
"""

import fnmatch
import pathlib
import re
import subprocess
import sys

TOPS = ("hal", "perception", "planner", "control", "sim_hal", "tools", "tests", "config", "docs")
SOURCES = {".cpp", ".hpp", ".py", ".ts", ".mjs"}
WITHOUT_README = ("tests/unit/", "tests/data/")  # below these folders
LINK = re.compile(r"\[[^\]]*\]\(<?([^)\s>]+)>?\)")
BACKTICKS = re.compile(r"`([^`\n]+)`")
PATH = re.compile(r"(?<![\w./@-])(?:%s)/[\w./*-]*" % "|".join(TOPS))
NAME = re.compile(r"[A-Za-z_]\w*(?:(?:::|\.)[A-Za-z_]\w*)*(?=$|[(=,: ])")
LIKE_CODE = re.compile(r"[a-z0-9]_[a-z0-9]|[a-z0-9][A-Z][a-z]|^k[A-Z]")
# names of other systems, placeholders and examples of style, names that CMake composes
FOREIGN = set("""BitRate SamplePoint RestartSec solvePnP cmdCartPos cmdCartPosFriOffset _optical_frame camera_link my_robot kConstants
                 ContactMonitor plan_path estimate_share live_alone live_foxglove_client live_page""".split())
RENAMED = re.compile(r'renamed\("([\w.]+)", *"')  # old names of configuration keys (hal/config/field_table.hpp)
DOCS_IN_SOURCE = re.compile(r"(?<![\w/-])docs/[\w/-]+\.md\b|(?<![\w/-])docs/decisions/(\d{4})")


def tracked(root):
    """Files of the repository: tracked ones and new ones that are not ignored; without git every file."""
    try:
        out = subprocess.run(
            ["git", "-C", str(root), "ls-files", "--cached", "--others", "--exclude-standard"],
            check=True, capture_output=True, text=True).stdout
        names = [n for n in out.splitlines() if (root / n).is_file()]
    except (OSError, subprocess.CalledProcessError):
        names = [str(p.relative_to(root)) for p in root.rglob("*") if p.is_file()]
        names = [n for n in names if not n.startswith((".", "build/", "out/"))]
    return sorted(names)


def slug(heading):
    """The anchor that a heading gets: lower case, punctuation dropped, blanks become hyphens."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading.strip())
    return re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-")


def lines_with_kind(text):
    """Every line with its number and whether it is code."""
    fenced = False
    blank_before = True
    indented = False
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
            continue
        indented = line.startswith("    ") and (indented or blank_before)
        yield number, line, fenced or indented
        blank_before = not line.strip()


def anchors(text):
    found = {}
    for _, line, code in lines_with_kind(text):
        match = None if code else re.match(r"#{1,6} +(.*)", line)
        if match:
            name = slug(match[1])
            count = found.get(name, 0)
            found[name] = count + 1
            if count:
                found[f"{name}-{count}"] = 1
    return set(found)


class Tree:
    def __init__(self, root):
        self.root = root
        self.files = tracked(root)
        self.names = set(self.files)
        for name in self.files:
            for parent in pathlib.PurePosixPath(name).parents:
                self.names.add(str(parent))
        self.all_words, self.old_keys, self.keys = None, set(), set()
        self.stems = {re.sub(r"\.\w+$", "", name) for name in self.files}

    def words(self):
        """Every word of every file that is not a document, and the names of files and folders."""
        if self.all_words is None:
            self.all_words = {pathlib.PurePosixPath(name).stem for name in self.names}
            for name in self.names:  # programs of unit tests are called after their folder
                if name.startswith("tests/unit/"):
                    self.all_words.add("_".join(name.split("/")[1:]))
            for name in self.files:
                if pathlib.PurePosixPath(name).suffix in (".md", ".png", ".svg", ".bin", ".pcd"):
                    continue
                text = (self.root / name).read_text(encoding="utf-8", errors="replace")
                self.all_words.update(re.findall(r"[A-Za-z_]\w*", text))
                if name.startswith("hal/config/"):
                    continue  # its comments explain renaming with an example
                self.old_keys.update(old.split(".")[-1] for old in RENAMED.findall(text))
                self.keys.update(re.findall(r'\bv\("(\w+)"', text))
            for word in [w for w in self.all_words if w.startswith("colift_")]:  # CoLift::x is made of colift_x
                self.all_words.add(word.removeprefix("colift_"))
        return self.all_words

    def has(self, path):
        """A file or folder, with * for anything; a file also without its extension."""
        path = path.rstrip("/.")
        if "*" in path:
            return any(fnmatch.fnmatch(name, path) for name in self.names)
        return path in self.names or path in self.stems

    def resolved(self, folder, target):
        """The path from the root of a path that is relative to a folder; None: outside of the repository."""
        parts = [] if folder == "." else folder.split("/")
        for step in target.split("/"):
            if step == "..":
                if not parts:
                    return None
                parts.pop()
            elif step not in ("", "."):
                parts.append(step)
        return "/".join(parts) or "."


def check_links(tree, document, text):
    folder = str(pathlib.PurePosixPath(document).parent)
    for number, line, code in lines_with_kind(text):
        if code:
            continue
        for target in LINK.findall(BACKTICKS.sub("", line)):
            if re.match(r"[a-z][a-z0-9+.-]*:", target):
                continue
            path, _, anchor = target.partition("#")
            name = tree.resolved(folder, path) if path else document
            if name is None or name.rstrip("/") not in tree.names:
                yield f"{document}:{number}: the link {target} leads nowhere"
            elif anchor and name.endswith(".md"):
                if anchor not in anchors((tree.root / name).read_text(encoding="utf-8")):
                    yield f"{document}:{number}: {name} has no heading #{anchor}"


def check_paths(tree, document, text):
    folder = str(pathlib.PurePosixPath(document).parent)
    for number, line, code in lines_with_kind(text):
        for piece in [line] if code else BACKTICKS.findall(line):
            for path in PATH.findall(piece):
                path = re.sub(r"\b(?:NNNN|NAME|FOLDER)\b", "*", path)  # placeholders
                if not tree.has(path) and not tree.has(tree.resolved(folder, path) or path):
                    yield f"{document}:{number}: there is no {path}"


def check_names(tree, document, text):
    folder = tree.root / document
    beside = {p.stem for p in folder.parent.iterdir()}  # files of the document's folder, named without extension
    for number, line, code in lines_with_kind(text):
        if code:
            continue
        for piece in BACKTICKS.findall(line):
            if "/" in piece:
                continue
            for found in NAME.finditer(piece):
                name = found[0]
                for word in re.split(r"::|\.", name):
                    if not LIKE_CODE.search(word) or word.startswith("_") or word in FOREIGN or word in beside:
                        continue
                    if word in tree.words() and word in tree.old_keys - tree.keys:
                        yield f"{document}:{number}: {word} is the old name of a configuration key ({name})"
                    elif word not in tree.words():
                        yield f"{document}:{number}: nothing is called {word} ({name})"


def check_readmes(tree):
    folders = {str(pathlib.PurePosixPath(name).parent) for name in tree.files
               if pathlib.PurePosixPath(name).suffix in SOURCES}
    for folder in sorted(folders - {"."}):
        if f"{folder}/".startswith(WITHOUT_README) and f"{folder}/" not in WITHOUT_README:
            continue
        readme = tree.root / folder / "README.md"
        if not readme.is_file():
            yield f"{folder}: there are sources, but no README.md"
        elif not readme.read_text(encoding="utf-8").startswith("# "):
            yield f"{folder}/README.md: does not begin with a heading"


def check_docs_in_sources(tree):
    for name in tree.files:
        if pathlib.PurePosixPath(name).suffix not in SOURCES | {".src", ".yaml"} or name.startswith("tests/docs/"):
            continue
        text = (tree.root / name).read_text(encoding="utf-8", errors="replace")
        ours = "\n".join(line for line in text.splitlines() if "://" not in line)  # not pages of other projects
        for match in DOCS_IN_SOURCE.finditer(ours):
            page = f"docs/decisions/{match[1]}-*" if match[1] else match[0]
            if not tree.has(page):
                yield f"{name}: there is no {match[0]}"


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2]).resolve()
    tree = Tree(root)
    documents = [name for name in tree.files if name.endswith(".md")]
    if not documents:
        print(f"{root}: no documents")
        return 2
    wrong = []
    for document in documents:
        text = (root / document).read_text(encoding="utf-8")
        wrong += check_links(tree, document, text)
        wrong += check_paths(tree, document, text)
        if document != "CHANGELOG.md":  # which tells of the past
            wrong += check_names(tree, document, text)
    wrong += check_readmes(tree)
    wrong += check_docs_in_sources(tree)
    for line in wrong:
        print(line)
    print(f"{len(documents)} documents, {len(wrong)} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
