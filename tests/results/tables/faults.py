"""Faults of the camera, changes of light, absences and a covered lens."""

from .statistics import percent
from .table import Table

ALL = ("tld", "more", "many")


def by_fault(said):
    """{fault: {tracker: row}} in the order of host-sim."""
    faults = {}
    for row in said["measured"]:
        faults.setdefault(row["fault"], {})[row["tracker"]] = row
    return faults


def short(row):
    """Four columns of one tracker under one fault."""
    frames = row["tracking"] + row["leaving"] + row["uncertain"] + row["lost"]
    return [
        percent(row["right"], row["visible"]) if frames else "-",
        percent(row["right_again"], row["runs"]),
        percent(row["right_at_the_end"], row["runs"]),
        percent(row["tracking_while_wrong"], row["frames"], 1),
    ]


def both_trackers(said):
    return [[fault, *short(rows["robust"]), *short(rows["paper"])] for fault, rows in by_fault(said).items()]


def camera(programs):
    said = programs.eval(*programs.recordings("tld"), "--fault", "all", "--config", "camera")
    return {}, {"all": both_trackers(said)}


def light(programs):
    said = programs.eval(*programs.recordings("tld", "more"), "--fault", "light", "--config", "camera")
    faults = by_fault(said)
    right = [row["robust"]["right"] / row["robust"]["visible"] for fault, row in faults.items() if fault not in ("none", "light:200")]
    return {"least-right": f"{100 * min(right):.0f} %"}, {"all": both_trackers(said)}


def away(programs):
    said = programs.eval(*programs.recordings(*ALL), "--fault", "away", "--config", "camera")
    rows, figures = [], {}
    for fault, trackers in by_fault(said).items():
        if fault == "none":
            continue
        for name in ("robust", "paper"):
            row = trackers[name]
            frames = row["tracking"] + row["leaving"] + row["uncertain"] + row["lost"]
            cells = {
                "answered": percent(frames - row["lost"], frames),
                "tracking": percent(row["tracking"], frames),
                "again": percent(row["right_again"], row["runs"]),
                "end": percent(row["right_at_the_end"], row["runs"]),
            }
            rows.append([name, str(row["runs"]), *cells.values()])
            figures |= {f"{name}-{key}": value for key, value in cells.items()}
    return figures, {"all": rows}


def cover(programs):
    rows = []
    for method, config in (("robust", []), ("paper", ["--config", "camera"])):
        said = programs.eval(*programs.recordings("tld", "more"), "--fault", "cover", "--method", method, *config)
        for row in said["means"]:
            count, before = row["recordings"], row["right_before"]
            rows.append([method, row["cover"], f"{row['tracking_most']}", f"{row['tracking_too_long']}", f"{row['lost_in_time']} of {count}", f"{row['right_again']} of {before}"])
    return {}, {"all": rows}


TABLES = [
    Table("faults", "short faults of the camera", ("paper", "robust"), camera),
    Table("light", "changes of light", ("paper", "robust"), light),
    Table("away", "a target that is away", ("paper", "robust"), away),
    Table("cover", "a covered lens", ("paper", "robust"), cover),
]
