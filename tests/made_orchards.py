"""Made orchards for finding rows, and the measure of where finding begins to fail.

    .venv/bin/python tests/made_orchards.py [SEEDS] [large]

prints the table of docs/survey.md: 8 rows of about 25 trees at gaps of 2.7 to 3.3 m, 5 % of them
missing, rows of different lengths and starts, any heading, positions with white GPS noise.
"""

from __future__ import annotations

import sys

import numpy as np

from orchard_cli.survey.finding import find_rows

CEP_PER_SIGMA = 1.17741  # of a round Gaussian


def made(
    seed, rows=8, trees=25, spacing=5.0, cep=0.0, gap=3.0, uneven=0.3, missing=0.05, radius=None,
    off_line=0.1,
):  # fmt: skip
    """Places (n, 2) m in any order, the row of each, and the rows' direction, rad."""
    rng = np.random.default_rng(seed)
    direction = rng.uniform(0, np.pi)
    places, labels = [], []
    for k in range(rows):
        count = max(2, trees + rng.integers(-3, 4))
        u = rng.uniform(-2, 2) + np.cumsum(rng.uniform(gap - uneven, gap + uneven, count))
        u -= trees * gap / 2
        v = k * spacing + rng.normal(0, off_line, count)
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
    """Shares of orchards with the right number of rows, trusted, trusted though wrong; and of
    trees in their own row where the number is right."""
    right, trusted, wrong, trees = 0, 0, 0, []
    for seed in range(seeds):
        places, labels, _ = made(seed, **kinds)
        found = find_rows(places)
        good = found is not None and len(found.rows) == labels.max() + 1
        sure = found is not None and not found.why_not
        right, trusted, wrong = right + good, trusted + sure, wrong + (sure and not good)
        if good:
            trees.append(share_right(found, labels))
    mean = float(np.mean(trees)) if trees else float("nan")
    return right / seeds, trusted / seeds, wrong / seeds, mean


SMALL = tuple(
    {"cep": cep, "spacing": spacing}
    for cep, spacing in (
        (1.5, 5), (1.5, 4), (1.5, 6), (1.0, 4), (1.0, 3), (2.0, 6), (2.0, 5), (1.0, 5), (0.5, 3),
        (0.5, 4),
    )
)  # fmt: skip
BENT = tuple({"cep": cep, "spacing": 5, "radius": 200} for cep in (1.0, 1.5))
LARGE = tuple(
    {"cep": 1.5, "spacing": spacing, "rows": 20, "trees": 50, "radius": radius}
    for spacing, radius in ((5, None), (5, 400), (4, None))
)


def main(seeds, kinds):
    print("| orchard | CEP m | spacing m | rows right | trees right | taken | taken, wrong |")
    print("|---|---|---|---|---|---|---|")
    for kind in kinds:
        right, trusted, wrong, trees = measured(seeds, **kind)
        size = f"{kind.get('rows', 8)} rows of {kind.get('trees', 25)}"
        bent = f", radius {kind['radius']:g} m" if kind.get("radius") else ""
        print(
            f"| {size}{bent} | {kind['cep']:g} | {kind['spacing']:g} | {right:.0%} | {trees:.1%} "
            f"| {trusted:.0%} | {wrong:.0%} |",
            flush=True,
        )


if __name__ == "__main__":
    main(
        int(sys.argv[1]) if len(sys.argv) > 1 else 100,
        LARGE if "large" in sys.argv else (*SMALL, *BENT),
    )
