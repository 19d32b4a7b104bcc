"""Multi-block decomposition of surfaces with cross-fields: everything that computes.

Imports NumPy and the standard library only. Data flows one way through the stages; `pipeline`
runs them in order.
"""
