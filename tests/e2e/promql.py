"""What a PromQL expression uses: enough of its grammar for the dashboard and the alert rules."""

import re

SCRAPE_LABELS = {"job", "instance"}  # Prometheus adds these itself
WORDS = {"and", "or", "unless", "by", "without", "on", "ignoring", "offset", "bool"}
NAME = r"[a-zA-Z_:][a-zA-Z0-9_:]*"


def selectors(expression):
    """(metric, [(label, operator, value)]) of each selector in it."""
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
    """A|B and X(A|B) as the words that they stand for."""
    inner = re.search(r"\(([^()]*)\)", value)
    if inner is None:
        return value.split("|")
    return [word for one in inner.group(1).split("|")
            for word in alternatives(value[:inner.start()] + one + value[inner.end():])]


def unknown_values(matcher, exported):
    """Those of a matcher that no series has: nobody would ever see them match."""
    label, operator, value = matcher
    if label in SCRAPE_LABELS or "$" in value:  # a choice that the dashboard offers
        return []
    words = alternatives(value) if operator in ("=~", "!~") else [value]
    return [word for word in words
            if not any(re.fullmatch(word, one) if operator in ("=~", "!~") else word == one
                       for one in exported)]


def grouping_labels(expression):
    """The labels that it sums by."""
    groups = re.findall(r"\b(?:by|on)\s*\(([^)]*)\)", expression)
    return {label.strip() for group in groups for label in group.split(",")}


def problems(expression, series):
    """What of it `series`, the values by label of each metric that is exported, does not have."""
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
