#!/usr/bin/env python3
"""Tables and curves of the rows that bench/rate_distortion.sh gathers.

usage: rate_distortion_report.py ROWS.csv ROOT
Writes the section rate_distortion of ROOT/docs/benchmarks.md, ROOT/docs/rate-distortion.md with
every row, ROOT/docs/plots/rate_distortion.csv and one SVG a frame.
"""
import csv
import os
import shutil
import sys

from doc_section import replace_section, table
from svg_plot import line_plot

NUMBERS = ("bits_per_point", "d1_ab_mm", "d1_ba_mm", "d1_mm", "d2_mm", "max_mm", "encode_ms",
           "decode_ms")
COUNTS = ("points", "bytes", "points_out", "dropped", "merged")
FAST_MS = 10


def read_rows(path):
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        row.update({name: float(row[name]) for name in NUMBERS})
        row.update({name: int(row[name]) for name in COUNTS})
        row["ours"] = row["ours"] == "1"
    return rows


def by_frame(rows):
    frames = {}
    for row in rows:
        frames.setdefault(row["frame"], []).append(row)
    return frames


def cell(row):
    if row is None:
        return "-"
    return (f"**{row['bits_per_point']:.2f}** {row['codec']}, {row['setting']} "
            f"({row['encode_ms']:.0f}/{row['decode_ms']:.0f} ms; {row['d1_mm']:.1f} mm)")


def best_peer(rows, d1_mm, most_ms=None):
    fit = [r for r in rows if not r["ours"] and r["dropped"] == 0 and r["d1_mm"] <= d1_mm
           and (most_ms is None or r["encode_ms"] <= most_ms)]
    return min(fit, key=lambda r: r["bits_per_point"], default=None)


def own(rows, codec, **wanted):
    fit = [r for r in rows if r["codec"] == codec and all(r[k] == v for k, v in wanted.items())]
    return fit[0] if fit else None


def summary(frames):
    efforts = sorted({r["codec"] for rows in frames.values() for r in rows if r["ours"]},
                     reverse=True)
    head = ["frame", "contract", f"best peer, encode at most {FAST_MS} ms", "best peer"] + efforts
    lines = []
    for name, rows in frames.items():
        contracts = [("lossless", 1e-9, {"setting": "lossless"})]
        targets = sorted({r["target_d1_mm"] for r in rows if r["target_d1_mm"]}, key=float)
        contracts += [(f"d1 {t} mm", float(t), {"target_d1_mm": t}) for t in targets]
        for what, d1, wanted in contracts:
            lines.append([name, what, cell(best_peer(rows, d1, FAST_MS)), cell(best_peer(rows, d1))]
                         + [cell(own(rows, effort, **wanted)) for effort in efforts])
        lines.append([name, "2sigma", "-", "-"]
                     + [cell(own(rows, effort, setting="2sigma")) for effort in efforts])
    kinect = [rows for name, rows in frames.items()
              if name.startswith("kinect_") and own(rows, efforts[0], setting="lossless")]
    if len(kinect) > 1:
        lossless = [[own(rows, e, setting="lossless") for rows in kinect] for e in efforts]
        lines.append([f"mean of {len(kinect)} Kinect v1 frames", "lossless", "-", "-"]
                     + [f"**{sum(r['bits_per_point'] for r in rows) / len(rows):.2f}**"
                        if all(rows) else "-" for rows in lossless])
    return table(head, lines)


def draco_ratios(frames):
    """Our time over Draco's where both were measured in one run, at the qp of the nearest d1."""
    lines = []
    for name, rows in frames.items():
        draco = [r for r in rows if r["codec"] == "Draco kd cl7"]
        if not draco:
            continue
        for row in (r for r in rows if r["ours"] and (r["target_d1_mm"] or r["setting"] == "2sigma")):
            peer = min(draco, key=lambda r: abs(r["d1_mm"] - row["d1_mm"]))
            lines.append([name, f"{row['codec']}, {row['setting']}", f"{row['d1_mm']:.1f}",
                          f"{row['encode_ms']:.1f}", peer["setting"], f"{peer['d1_mm']:.1f}",
                          f"{peer['encode_ms']:.1f}",
                          f"{row['encode_ms'] / peer['encode_ms']:.2f}",
                          f"{row['decode_ms'] / peer['decode_ms']:.2f}",
                          f"{row['bits_per_point'] / peer['bits_per_point']:.2f}"])
    head = ["frame", "ours", "d1 mm", "encode ms", "Draco kd cl7", "d1 mm", "encode ms",
            "encode ratio", "decode ratio", "bits ratio"]
    return table(head, lines) if lines else "Draco was not installed."


def full_table(rows):
    head = ["codec", "setting", "bit/point", "bytes", "points out", "dropped", "merged", "d1_ab mm",
            "d1_ba mm", "d1 mm", "d2 mm", "max mm", "encode ms", "decode ms"]
    return table(head, [
        [r["codec"], r["setting"] + (f" (d1 {r['target_d1_mm']})" if r["target_d1_mm"] else ""),
         f"{r['bits_per_point']:.3f}"] + [str(r[c]) for c in COUNTS[1:]]
        + [f"{r[n]:.2f}" for n in NUMBERS[1:6]] + [f"{r[n]:.1f}" for n in NUMBERS[6:]]
        for r in rows])


def plot(path, name, rows):
    series = {}
    for r in rows:
        series.setdefault(r["codec"], []).append((r["d1_mm"], r["bits_per_point"]))
    left_out = ("Draco kd cl3", "Draco kd cl10", "RVL+zstd-1", "PNG-1")  # beside their neighbours
    line_plot(path, f"{name}: bits against d1, all points kept", "d1 [mm]", "bit/point",
              [(c, p) for c, p in series.items() if c not in left_out], True, True,
              [c for c in series if c.startswith("planecast")])


def main():
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 2
    rows, root = read_rows(sys.argv[1]), sys.argv[2]
    frames = by_frame(rows)
    plots = os.path.join(root, "docs", "plots")
    os.makedirs(plots, exist_ok=True)
    kept = os.path.join(plots, "rate_distortion.csv")
    if os.path.abspath(kept) != os.path.abspath(sys.argv[1]):
        shutil.copyfile(sys.argv[1], kept)
    replace_section(os.path.join(root, "docs", "benchmarks.md"), "rate_distortion",
                    "### All points kept: bits at an error\n\n" + summary(frames)
                    + "\n\n### Against Draco's time, in one run\n\n" + draco_ratios(frames))
    pages = ["# Rate, distortion and time, every row", "",
             "Written by `bench/rate_distortion_report.py` from `plots/rate_distortion.csv`; how it "
             "was measured is in [benchmarks.md](benchmarks.md).", ""]
    for name, frame_rows in frames.items():
        plot(os.path.join(plots, f"rate_distortion_{name}.svg"), name, frame_rows)
        kept_rows = [r for r in frame_rows if r["dropped"] == 0]
        lost_rows = [r for r in frame_rows if r["dropped"] > 0]
        pages += [f"## {name}, {frame_rows[0]['points']} points", "",
                  f"![curves](plots/rate_distortion_{name}.svg)", "", "All points kept:", "",
                  full_table(kept_rows), ""]
        if lost_rows:
            pages += ["Points dropped:", "", full_table(lost_rows), ""]
    with open(os.path.join(root, "docs", "rate-distortion.md"), "w", encoding="utf-8") as file:
        file.write("\n".join(pages))
    return 0


if __name__ == "__main__":
    sys.exit(main())
