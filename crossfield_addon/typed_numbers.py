"""Numbers as the user typed them: Blender's float properties have single precision."""


def as_typed(value: float) -> float:
    """The shortest number that a float property shows as this: 0.3 for 0.30000001192092896."""
    return float(f"{value:.7g}")
