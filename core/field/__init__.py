"""The cross-field: fixed crosses, arrival distance, propagation, relaxation, singularities."""
