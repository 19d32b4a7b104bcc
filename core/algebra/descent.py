"""Minimisation of smooth functions of many variables: limited-memory BFGS, preconditioned."""

from __future__ import annotations

import numpy as np

_MEMORY = 10
_HALVINGS = 10
_SUFFICIENT = 1e-4  # Armijo: share of the promised decrease that a step must bring
_RESCALE = 4  # steps between two measurements of the preconditioner's scale
_SETTLED = 1e-5  # relative decrease in one step that ends the search


def minimise(function, start, iterations, first_move, largest_move, precondition) -> np.ndarray:
    """Walk downhill from start; every accepted step decreases the function.

    function      maps (n,) to (value, gradient (n,))
    first_move, largest_move  length of the largest component of the first and of any step
    precondition  maps a gradient (n,) to a direction (n,), roughly the inverse of the Hessian up
                  to a factor; positive definite

    Returns the last point (n,). (Nocedal & Wright, Numerical Optimization, algorithm 7.4)
    """
    point, history, scale = start, [], None
    value, gradient = function(point)
    for iteration in range(iterations):
        if history and (scale is None or iteration % _RESCALE == 0):
            scale = _scale(history, precondition)
        direction = _direction(gradient, history, precondition, scale, first_move)
        found = _search(function, point, value, gradient, direction, largest_move)
        if found is None:
            if not history:
                break
            history, scale = [], None
            continue
        new_point, new_value, new_gradient = found
        _remember(history, new_point - point, new_gradient - gradient)
        settled = value - new_value <= _SETTLED * abs(new_value)
        point, value, gradient = new_point, new_value, new_gradient
        if settled:
            break
    return point


def _scale(history, precondition):
    """Factor between the preconditioner and the inverse Hessian along the last step."""
    _, change, inverse = history[-1]
    return 1.0 / (inverse * (change @ precondition(change)))


def _direction(gradient, history, precondition, scale, first_move):
    """Minus the inverse Hessian, as the past steps show it, times the gradient."""
    direction, shares = -gradient, []
    for step, change, inverse in reversed(history):
        shares.append(inverse * (step @ direction))
        direction = direction - shares[-1] * change
    direction = precondition(direction)
    if not history:
        return direction * (first_move / max(np.abs(direction).max(initial=0.0), 1e-300))
    direction = direction * scale
    for (step, change, inverse), share in zip(history, reversed(shares)):
        direction = direction + (share - inverse * (change @ direction)) * step
    return direction


def _search(function, point, value, gradient, direction, largest_move):
    """Shorten the step until the function falls enough; None if it never does."""
    slope = gradient @ direction
    if not slope < 0:
        return None
    size = min(1.0, largest_move / max(np.abs(direction).max(), 1e-300))
    for attempt in range(_HALVINGS):
        new_point = point + size * direction
        new_value, new_gradient = function(new_point)
        if new_value <= value + _SUFFICIENT * size * slope:
            return new_point, new_value, new_gradient
        size *= 0.5 if attempt < 2 else 0.2
    return None


def _remember(history, step, change):
    curvature = step @ change
    if curvature > 1e-12 * np.linalg.norm(step) * np.linalg.norm(change):
        history.append((step, change, 1.0 / curvature))
        del history[:-_MEMORY]
