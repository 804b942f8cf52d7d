"""Kernels that generated code calls, and the environment interface."""
