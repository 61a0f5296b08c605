"""A scene as the text of its file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from towage.scene.scene import Scene

LEFT_OUT = (
    "parameters", "inputs", "set", "record", "cases", "checks", "report_only", "description", "connections", "transformations",
    "values",
)  # fmt: skip
"""What a file has no need of where it is empty."""


def toml(scene: Scene) -> str:
    """What `Scene.load` reads back as the same scene."""
    import tomli_w

    return tomli_w.dumps(_told(scene.to_dict()), multiline_strings=True)


def _told(table: dict[str, Any]) -> dict[str, Any]:
    """Without what has no value."""
    told = {}
    for key, value in table.items():
        if isinstance(value, dict):
            value = _told(value)
        if value is not None and (value or key not in LEFT_OUT):
            told[key] = value
    return told
