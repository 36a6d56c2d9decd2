"""Parses PromQL expressions: enough of the grammar for the dashboard and the alert rules."""

import re

SCRAPE_LABELS = {"job", "instance"}  # added by Prometheus
WORDS = {"and", "or", "unless", "by", "without", "on", "ignoring", "offset", "bool"}
NAME = r"[a-zA-Z_:][a-zA-Z0-9_:]*"


def selectors(expression):
    """Returns (metric, [(label, operator, value)]) of each selector."""
    values = re.findall(r'"([^"]*)"', expression)
    number = iter(range(len(values)))
    bare = re.sub(r'"[^"]*"', lambda _: f'"{next(number)}"', expression)
    bare = re.sub(r"\[[^\]]*\]", "", bare)
    bare = re.sub(r"\b(by|without|on|ignoring)\s*\([^)]*\)", "", bare)
    found = []
    for match in re.finditer(rf"({NAME})\s*(\(|\{{[^}}]*\}})?", bare):
        name, rest = match.group(1), match.group(2) or ""
        if rest == "(" or name in WORDS or re.match(r".*\d", bare[max(0, match.start() - 1)]):
            continue
        found.append((name, [(label, operator, values[int(value)]) for label, operator, value in
                             re.findall(rf'({NAME})\s*(=~|!~|!=|=)\s*"(\d+)"', rest)]))
    return found


def alternatives(value):
    """Returns the alternatives of A|B and X(A|B)."""
    inner = re.search(r"\(([^()]*)\)", value)
    if inner is None:
        return value.split("|")
    return [word for label_value in inner.group(1).split("|")
            for word in alternatives(value[:inner.start()] + label_value + value[inner.end():])]


def unknown_values(matcher, exported):
    """Returns the values of a matcher that no series has."""
    label, operator, value = matcher
    if label in SCRAPE_LABELS or "$" in value:  # a variable of the dashboard
        return []
    words = alternatives(value) if operator in ("=~", "!~") else [value]
    return [word for word in words
            if not any(re.fullmatch(word, label_value) if operator in ("=~", "!~") else word == label_value
                       for label_value in exported)]


def grouping_labels(expression):
    """Returns the labels that the expression groups by."""
    groups = re.findall(r"\b(?:by|on)\s*\(([^)]*)\)", expression)
    return {label.strip() for group in groups for label in group.split(",")}


def problems(expression, series):
    """Returns the parts of the expression that are not in `series`: the exported metrics, with
    values by label."""
    wrong = []
    known = set(SCRAPE_LABELS)
    for metric, matchers in selectors(expression):
        if metric == "up":
            continue
        if metric not in series:
            wrong.append(f"no metric {metric}")
            continue
        labels = series[metric]
        known |= set(labels)
        wrong += [f"{metric} has no label {label}" for label, _, _ in matchers
                  if label not in labels and label not in SCRAPE_LABELS]
        wrong += [f"{metric} has no {matcher[0]} {word}" for matcher in matchers
                  if matcher[0] in labels for word in unknown_values(matcher, labels[matcher[0]])]
    return wrong + [f"no metric has the label {label}"
                    for label in grouping_labels(expression) - known]
