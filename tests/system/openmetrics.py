"""A strict reader of OpenMetrics 1.0 text, and of the Prometheus text format 0.0.4 before it, as dexeld writes them:
what the formats allow and dexeld has no use for (timestamps, exemplars, other types) is refused as well.

  openmetrics.py check FILE [--prometheus]        the format, and what holds for all metrics of a service
  openmetrics.py grows BEFORE AFTER               no counter, bucket or count has gone back
  openmetrics.py value FILE NAME [LABEL=VALUE...] the value of the one sample that is meant
  openmetrics.py used FILE DASHBOARD RULES        each metric that dashboard and rules name is there
  openmetrics.py documented FILE PAGE             PAGE has a row for each family, and none besides
"""

import json
import re
import sys

NAME = re.compile(r"[a-zA-Z_:][a-zA-Z0-9_:]*")
LABEL = re.compile(r"[a-zA-Z_][a-zA-Z0-9_]*")
NUMBER = re.compile(r"-?\d+(\.\d+)?([eE][-+]?\d+)?")
SUFFIXES = {"gauge": ("",), "counter": ("_total",), "histogram": ("_bucket", "_sum", "_count")}
UNITS = ("seconds", "bytes", "ratio")
ESCAPES = {"\\": "\\", '"': '"', "n": "\n"}


class Bad(Exception):
    pass


def need(condition, what):
    if not condition:
        raise Bad(what)


def take(pattern, text, what):
    m = pattern.match(text)
    need(m, f"expected {what} at '{text[:40]}'")
    return m.group(), text[m.end() :]


def take_labels(text):
    """{a="b",...} at the front of the text: a dictionary, and the rest."""
    labels = {}
    if not text.startswith("{"):
        return labels, text
    text = text[1:]
    while not text.startswith("}"):
        if labels:
            need(text.startswith(","), f"expected ',' at '{text[:40]}'")
            text = text[1:]
        name, text = take(LABEL, text, "a label")
        need(name not in labels, f"label {name} is there twice")
        need(text.startswith('="'), f"expected =\" at '{text[:40]}'")
        text, value = text[2:], ""
        while not text.startswith('"'):
            need(text, "a label without its end")
            if text[0] == "\\":
                need(text[1:2] in ESCAPES, f"no such escape: {text[:2]}")
                value, text = value + ESCAPES[text[1]], text[2:]
            else:
                value, text = value + text[0], text[1:]
        labels[name], text = value, text[1:]
    return labels, text[1:]


class Family:
    def __init__(self, name):
        self.name, self.type, self.unit, self.help = name, None, None, None
        self.samples = {}  # (sample name, labels) -> value, in their order

    def sample_names(self):
        return [self.name + suffix for suffix in SUFFIXES[self.type]]


def read(path, prometheus=False):
    """The families of a text, by name: without _total, in either format."""
    with open(path, "rb") as f:
        text = f.read().decode("utf-8")
    lines = text.split("\n")
    need(lines.pop() == "", "the last line has no end")
    if not prometheus:
        need(lines and lines.pop() == "# EOF", "no # EOF at the end")
    families, family = {}, None
    for number, line in enumerate(lines, 1):
        try:
            family = read_line(line, families, family, prometheus)
        except Bad as e:
            raise Bad(f"{path}:{number}: {e}: {line}") from None
    return families


def read_line(line, families, family, prometheus):
    need(line and line == line.strip(), "an empty line, or blanks at its ends")
    if not line.startswith("#"):
        need(family and family.type, "a sample without TYPE")
        read_sample(line, family)
        return family
    words = line.split(" ", 3)
    need(len(words) == 4 and words[0] == "#" and words[1] in ("HELP", "TYPE", "UNIT"), "no such line")
    _, what, name, value = words
    need(NAME.fullmatch(name), "no name of a metric")
    if prometheus:
        need(what != "UNIT", "UNIT is of OpenMetrics")
        name = name[:-6] if name.endswith("_total") else name
    need(not name.endswith("_total"), "_total is of samples")
    if family is None or family.name != name:
        need(name not in families, "a family in two places")
        families[name] = family = Family(name)
    need(not family.samples, f"{what} after a sample")
    need(getattr(family, what.lower()) is None, f"{what} is there twice")
    setattr(family, what.lower(), value)
    if what == "TYPE":
        need(value in SUFFIXES, "no such type")
        need(not prometheus or (words[2].endswith("_total")) == (value == "counter"), "_total is of counters")
    return family


def read_sample(line, family):
    name, rest = take(NAME, line, "a name")
    need(name in family.sample_names(), f"no sample of {family.name}, a {family.type}")
    labels, rest = take_labels(rest)
    need(rest.startswith(" "), f"expected a blank at '{rest[:40]}'")
    need(NUMBER.fullmatch(rest[1:]), f"found '{rest[1:]}', expected a number")
    key = (name, tuple(sorted(labels.items())))
    need(key not in family.samples, "a sample that is there twice")
    family.samples[key] = float(rest[1:])


# ---- what holds for all --------------------------------------------------------------------------------------------


def check_histogram(family):
    series = {}
    for (name, labels), value in family.samples.items():
        rest = tuple(pair for pair in labels if pair[0] != "le")
        of = series.setdefault(rest, {"buckets": []})
        if name.endswith("_bucket"):
            of["buckets"].append((dict(labels)["le"], value))
        else:
            need(rest == labels, f"{name}: le is of buckets")
            of[name[len(family.name) :]] = value
    for labels, of in series.items():
        bounds = [float(le) for le, _ in of["buckets"]]
        counts = [n for _, n in of["buckets"]]
        what = f"{family.name} {labels}"
        need(of["buckets"] and of["buckets"][-1][0] == "+Inf", f"{what}: no bucket +Inf at the end")
        need(all(re.fullmatch(r"\d+\.\d+", le) for le, _ in of["buckets"][:-1]), f"{what}: le is no float")
        need(bounds == sorted(set(bounds)), f"{what}: bounds do not ascend")
        need(counts == sorted(counts), f"{what}: counts do not ascend")
        need(of["_count"] == counts[-1], f"{what}: another count than that of +Inf")
        need(of["_sum"] >= 0 and (of["_sum"] > 0) == (counts[-1] > 0), f"{what}: sum {of['_sum']} of {counts[-1]}")


def check_states(family):
    series = {}
    for (_, labels), value in family.samples.items():
        rest = tuple(pair for pair in labels if pair[0] != "state")
        series.setdefault(rest, []).append(value)
    for labels, values in series.items():
        need(sorted(values) == [0] * (len(values) - 1) + [1], f"{family.name} {labels}: not in one state: {values}")


def check(path, prometheus=False):
    families = read(path, prometheus)
    names = [name for family in families.values() for name in family.sample_names()]
    need(len(names) == len(set(names)), "a sample name of two families")
    for family in families.values():
        name = family.name
        need(name.startswith("dexeld_"), f"{name}: not ours")
        need(family.help and family.type, f"{name}: no HELP or no TYPE")
        need(re.match(r"[A-Z].*\.$", family.help), f"{name}: help is no sentence: {family.help}")
        units = [u for u in UNITS if name.endswith("_" + u)]
        if not prometheus:
            need(units == ([family.unit] if family.unit else []), f"{name}: unit {family.unit}")
        need(not re.search(r"_(ms|ns|us|kb|mb|percent)(_|$)", name), f"{name}: not a base unit")
        if family.type == "histogram":
            check_histogram(family)
        if family.type == "counter":
            need(all(v >= 0 for v in family.samples.values()), f"{name}: a counter below 0")
        if name.endswith("_state"):
            check_states(family)
        if name.endswith("_info"):
            need(all(v == 1 for v in family.samples.values()), f"{name}: information is 1")
    return families


# ---- commands ------------------------------------------------------------------------------------------------------


def grows(before_path, after_path):
    before, after = read(before_path), read(after_path)
    moved = 0
    for name, family in before.items():
        if family.type == "gauge":
            continue
        for key, value in family.samples.items():
            now = after[name].samples.get(key)
            if now is None:  # of a client that has gone
                need("client" in dict(key[1]), f"{key}: it is gone")
                continue
            need(now >= value, f"{key}: {value}, then {now}")
            moved += now > value
    need(moved > 10, f"only {moved} samples have grown")


def value(path, name, *labels):
    wanted = dict(word.split("=", 1) for word in labels)
    found = [
        v
        for family in read(path).values()
        for (sample, have), v in family.samples.items()
        if sample == name and wanted.items() <= dict(have).items()
    ]
    need(len(found) == 1, f"{name} {wanted}: found {len(found)} samples, expected one")
    print(f"{found[0]:.15g}")


def used(path, dashboard, rules):
    names = {name for family in read(path).values() for name in family.sample_names()}
    with open(dashboard, encoding="utf-8") as f:
        expressions = [t["expr"] for panel in json.load(f)["panels"] for t in panel.get("targets", [])]
    with open(rules, encoding="utf-8") as f:
        lines = [line for line in f if not re.match(r" *(#|summary:|description:)", line)]
    for what, text, least in (("dashboard", " ".join(expressions), 20), ("rules", "".join(lines), 10)):
        named = set(re.findall(r"\bdexeld_[a-z0-9_]+", text))
        need(named <= names, f"{what}: no such metric: {sorted(named - names)}")
        need(len(named) >= least, f"{what}: names only {len(named)} metrics")


def documented(path, page):
    families = {name + ("_total" if f.type == "counter" else "") for name, f in read(path).items()}
    with open(page, encoding="utf-8") as f:
        rows = re.findall(r"^\| `(dexeld_[a-z0-9_]+)", f.read(), re.M)
    need(len(rows) == len(set(rows)), "a metric with two rows")
    need(set(rows) == families, f"{page}: {sorted(set(rows) ^ families)}")


def main(command, *words):
    if command == "check":
        check(words[0], "--prometheus" in words)
    else:
        {"grows": grows, "value": value, "used": used, "documented": documented}[command](*words)


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    except Bad as e:
        sys.exit(f"openmetrics: {e}")
