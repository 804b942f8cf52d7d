"""The wheel and its environment, made once for all files here."""

from tests.packaging.installed import installed, source, wheel

__all__ = ["installed", "source", "wheel"]  # fixtures
