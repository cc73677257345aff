"""`--system none`: flies the reference whatever stands in the way; to compare with."""

from __future__ import annotations

from orchard_cli.motion.situation import Keep, Situation, Verdict


class Blind:
    """Looks at nothing and keeps everything."""

    name = "none"
    needs: frozenset[str] = frozenset()

    def plan(self, situation: Situation) -> Verdict:
        """Keep the active trajectory."""
        del situation
        return Keep("no avoidance system")
