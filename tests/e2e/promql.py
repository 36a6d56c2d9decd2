"""What a PromQL expression uses: enough of its grammar for the dashboard and the alert rules."""

import re

SCRAPE_LABELS = {"job", "instance"}  # Prometheus adds these itself
WORDS = {"and", "or", "unless", "by", "without", "on", "ignoring", "offset", "bool"}
NAME = r"[a-zA-Z_:][a-zA-Z0-9_:]*"


def selectors(expression):
    """(metric, set of label names) of each selector in it."""
    bare = re.sub(r'"[^"]*"', '""', expression)
    bare = re.sub(r"\[[^\]]*\]", "", bare)
    bare = re.sub(r"\b(by|without|on|ignoring)\s*\([^)]*\)", "", bare)
    found = []
    for match in re.finditer(rf"({NAME})\s*(\(|\{{[^}}]*\}})?", bare):
        name, rest = match.group(1), match.group(2) or ""
        if rest == "(" or name in WORDS or re.match(r".*\d", bare[max(0, match.start() - 1)]):
            continue
        found.append((name, set(re.findall(rf"({NAME})\s*(?:=~|!~|!=|=)", rest))))
    return found


def grouping_labels(expression):
    """The labels that it sums by."""
    groups = re.findall(r"\b(?:by|on)\s*\(([^)]*)\)", expression)
    return {label.strip() for group in groups for label in group.split(",")}


def problems(expression, series):
    """What of it `series`, the label names of each metric that is exported, does not have."""
    wrong = []
    known = set(SCRAPE_LABELS)
    for metric, labels in selectors(expression):
        if metric == "up":
            continue
        if metric not in series:
            wrong.append(f"no metric {metric}")
            continue
        known |= series[metric]
        wrong += [f"{metric} has no label {label}"
                  for label in labels - series[metric] - SCRAPE_LABELS]
    return wrong + [f"no metric has the label {label}"
                    for label in grouping_labels(expression) - known]
