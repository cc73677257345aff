"""Made orchards for finding rows, and the measure of where finding begins to fail.

    .venv/bin/python tests/made_orchards.py 100 table      # or others, or large

prints the tables of docs/survey.md: 8 rows of about 25 trees at gaps of 2.7 to 3.3 m, 5 % of them
missing, rows of different lengths and starts, any heading, positions with white GPS noise.
"""

from __future__ import annotations

import sys

import numpy as np

from orchard_cli.survey.finding import find_rows

CEP_PER_SIGMA = 1.17741  # of a round Gaussian
LEAST = 0.85  # of the trees in their own row: fewer are wrong rows


def made(
    seed, rows=8, trees=25, spacing=5.0, cep=0.0, gap=3.0, uneven=0.3, missing=0.05, radius=None,
    off_line=0.1, road=0.0,
):  # fmt: skip
    """Places (n, 2) m in any order, the row of each, and the rows' direction, rad."""
    rng = np.random.default_rng(seed)
    direction = rng.uniform(0, np.pi)
    places, labels = [], []
    for k in range(rows):
        count = max(2, trees + rng.integers(-3, 4))
        u = rng.uniform(-2, 2) + np.cumsum(rng.uniform(gap - uneven, gap + uneven, count))
        u -= trees * gap / 2
        v = k * spacing + (road if k >= rows // 2 else 0.0) + rng.normal(0, off_line, count)
        v += u**2 / (2 * radius) if radius else 0.0
        there = rng.random(count) >= missing
        places.append(np.column_stack([u, v])[there])
        labels += [k] * int(there.sum())
    along = np.array([np.cos(direction), np.sin(direction)])
    turned = np.concatenate(places) @ np.array([along, [-along[1], along[0]]])
    turned += rng.normal(0, cep / CEP_PER_SIGMA, turned.shape)
    order = rng.permutation(len(turned))
    return turned[order], np.array(labels)[order], direction


def share_right(found, labels):
    """Share of the trees in their own row, numbering the rows from either side."""
    member = np.full(len(labels), -1)
    for k, row in enumerate(found.rows):
        member[row] = k
    turned = np.where(member >= 0, len(found.rows) - 1 - member, -1)
    return max(float((member == labels).mean()), float((turned == labels).mean()))


def measured(seeds, **kinds):
    """Shares of orchards with the right number of rows, taken, taken though wrong (another number
    of rows, or under LEAST of the trees in their own); and of trees in their own row where the
    number is right."""
    right, trusted, wrong, trees = 0, 0, 0, []
    for seed in range(seeds):
        places, labels, _ = made(seed, **kinds)
        found = find_rows(places)
        good = found is not None and len(found.rows) == labels.max() + 1
        sure = found is not None and not found.why_not
        own = share_right(found, labels) if good else 0.0
        right, trusted, wrong = right + good, trusted + sure, wrong + (sure and own < LEAST)
        if good:
            trees.append(own)
    mean = float(np.mean(trees)) if trees else float("nan")
    return right / seeds, trusted / seeds, wrong / seeds, mean


MISSING = (0.05, 0.2)
TABLE = tuple(
    {"cep": cep, "spacing": spacing, "missing": missing}
    for missing in MISSING for cep in (0.3, 0.5, 1.0, 1.5) for spacing in (3, 4, 5)
)  # fmt: skip
OTHERS = (
    {"cep": 1.5, "spacing": 6},
    {"cep": 1.0, "spacing": 5, "radius": 200},
    {"cep": 1.5, "spacing": 5, "radius": 200},
    {"cep": 0.5, "spacing": 4, "road": 3.0},
    {"cep": 1.5, "spacing": 5, "road": 3.0},
    {"cep": 1.0, "spacing": 4, "rows": 3, "trees": 12},
)
LARGE = tuple(
    {"cep": 1.5, "spacing": spacing, "rows": 20, "trees": 50, "radius": radius}
    for spacing, radius in ((5, None), (5, 400), (4, None))
)


def main(seeds, kinds):
    print("| orchard | CEP m | rows m apart | taken, wrong | taken | rows right | trees right |")
    print("|---|---|---|---|---|---|---|")
    for kind in kinds:
        right, trusted, wrong, trees = measured(seeds, **kind)
        size = f"{kind.get('rows', 8)} rows of {kind.get('trees', 25)}"
        size += f", {kind['missing']:.0%} missing" if "missing" in kind else ""
        size += f", bent to {kind['radius']:g} m" if kind.get("radius") else ""
        size += f", a road of {kind['road']:g} m more" if kind.get("road") else ""
        print(
            f"| {size} | {kind['cep']:g} | {kind['spacing']:g} | {wrong:.0%} | {trusted:.0%} "
            f"| {right:.0%} | {trees:.1%} |",
            flush=True,
        )


if __name__ == "__main__":
    kinds = {"table": TABLE, "others": OTHERS, "large": LARGE}
    main(int(sys.argv[1]), kinds[sys.argv[2]])
