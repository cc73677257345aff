"""What the airframe touches, looked for again and again as it moves."""

from __future__ import annotations

from orchard_cli.model.arrays import Vector

from .scene import Scene


class Feeler:
    """Looks at everything only when the vehicle has moved far enough to have reached anything."""

    def __init__(self, scene: Scene, radius: float) -> None:
        self._scene = scene
        self._radius = radius
        self._looked = [0.0, 0.0, 0.0]  # m, where it looked last
        self._room = 0.0  # m from there in which nothing stands

    def touched(self, position_site: Vector, time: float) -> str | None:
        """What is touched, as Scene.contact tells it."""
        here = position_site.tolist()
        moved = max(abs(a - b) for a, b in zip(here, self._looked, strict=True))
        if moved < self._room and not self._scene.world.people:
            return None
        self._looked, self._room = here, self._scene.room(position_site, self._radius)
        return self._scene.contact(position_site, self._radius, time)
