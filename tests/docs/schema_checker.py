"""What check_schemas.py and its parts share: the program, its schemas made strict, what did not agree, emulated devices.

Needs Debian's python3-jsonschema and python3-yaml.
"""

import copy
import json
import pathlib
import re
import signal
import socket
import subprocess

import jsonschema
import yaml

CONDITIONS = ("if", "then", "else", "not", "allOf")


def strict(schema):
    """The schema with no other keys than those it names. What only adds conditions to the same object stays as it is."""
    if isinstance(schema, dict):
        schema = {k: v if k in CONDITIONS else strict(v) for k, v in schema.items()}
        if "properties" in schema:
            schema.setdefault("additionalProperties", False)
    elif isinstance(schema, list):
        schema = [strict(v) for v in schema]
    return schema


def leaves(error):
    """Of a choice between forms the errors of the form that fits best; else the error itself."""
    forms = {}
    for e in error.context:
        forms.setdefault(e.schema_path[0], []).append(e)
    return [leaf for e in min(forms.values(), key=len) for leaf in leaves(e)] if forms else [error]


class Core(yaml.SafeLoader):
    """YAML 1.2's core schema, as the program reads it: "off" and a date are texts, 1e3 is a number."""


Core.yaml_implicit_resolvers = {}
for tag, form, first in (("bool", "true|True|TRUE|false|False|FALSE", [*"tTfF"]), ("null", "~|null|Null|NULL|", [*"~nN", ""]),
                         ("int", "[-+]?[0-9]+", [*"-+0123456789"]),
                         ("float", r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?", [*"-+.0123456789"])):
    Core.add_implicit_resolver("tag:yaml.org,2002:" + tag, re.compile(f"^(?:{form})$"), first)
Core.add_constructor("tag:yaml.org,2002:float", lambda loader, node: float(loader.construct_scalar(node)))
Core.add_constructor("tag:yaml.org,2002:int", lambda loader, node: int(loader.construct_scalar(node)))


def read_yaml(file):
    return yaml.load(pathlib.Path(file).read_text(), Core)


class Checker:
    def __init__(self, program, schemas=None):
        self.program, self.schemas, self.wrong, self.agreed, self.known = program, schemas, [], [], {}

    def run(self, *words):
        return subprocess.run([self.program, *map(str, words)], capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL)

    def schema(self, name):
        if name not in self.known:
            self.known[name] = json.loads((self.schemas / f"{name}.json").read_text() if self.schemas else self.run("schema", name).stdout)
        return self.known[name]

    def validate(self, name, document, what):
        errors = list(jsonschema.Draft202012Validator(strict(self.schema(name))).iter_errors(document))
        for e in [leaf for error in errors for leaf in leaves(error)][:5]:
            self.wrong.append(f"{what}: {'.'.join(map(str, e.absolute_path)) or 'document'}: {e.message[:200]}")
        if not errors:
            self.agreed.append((name, what))

    def command(self, name, *words, tries=1):
        """`tries`: a busy machine may keep a device in real time from answering."""
        what = "colift " + " ".join(map(str, words))
        for left in reversed(range(tries)):
            done = self.run(*words, "--json", "--quiet")
            try:
                document = json.loads(done.stdout)
            except json.JSONDecodeError:
                if not left:
                    self.wrong.append(f"{what}: no document, exit {done.returncode}: {done.stderr[-200:]}")
                continue
            self.validate(name, document, what)
            return document
        return None

    def is_valid(self, name, document):
        return jsonschema.Draft202012Validator(self.schema(name)).is_valid(document)

    def has_to_fail(self, name, document, change, what):
        broken = copy.deepcopy(document)
        change(broken)
        if self.is_valid(name, broken):
            self.wrong.append(f"the schema {name} accepts {what}")
        return broken


class Emulator:
    """`colift emulate WORDS` that is ready; end() gives its document."""

    def __init__(self, c, *words):
        self.process = subprocess.Popen([c.program, "emulate", *map(str, words), "--json", "--quiet"], stdin=subprocess.DEVNULL,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.ready = self.process.stderr.readline()

    def end(self):
        self.process.send_signal(signal.SIGINT)
        out, _ = self.process.communicate(timeout=60)
        return json.loads(out)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.communicate()


def free_port(kind):
    with socket.socket(socket.AF_INET, kind) as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]
